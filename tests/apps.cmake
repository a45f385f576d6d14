pled_add_tests(test_apps
  SOURCES
    unit/apps/ablation_test.cpp
    unit/apps/command_line_test.cpp
    unit/apps/derived_truth_test.cpp
    unit/apps/estimator_storage_test.cpp
    unit/apps/labelled_features_test.cpp
    unit/apps/output_test.cpp
    unit/apps/progress_test.cpp
  DEPS pled::apps nlohmann_json::nlohmann_json)
target_compile_definitions(test_apps PRIVATE PLED_VINS_EXE="$<TARGET_FILE:pled-vins>")
add_dependencies(test_apps pled-vins)
# GCC 12 sees an overlap in std::string's operator+ that is not there (GCC bug 105651).
target_compile_options(test_apps PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
