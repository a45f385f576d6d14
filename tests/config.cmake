pled_add_tests(test_config
  SOURCES
    unit/config/app_config_test.cpp
    unit/config/calibration_test.cpp
  DEPS pled::config)
target_compile_definitions(test_config PRIVATE PLED_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
pled_add_tests(test_config_replay LABEL replay
  SOURCES replay/config/recorded_calibration_test.cpp
  DEPS pled::config)
