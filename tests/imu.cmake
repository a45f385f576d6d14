pled_add_tests(test_imu LABEL law
  SOURCES unit/imu/imu_history_test.cpp
          law/imu/dead_reckoning_test.cpp
          law/imu/integrator_test.cpp
          law/imu/preintegration_test.cpp
          law/imu/covariance_monte_carlo_test.cpp
  DEPS pled::imu)
pled_add_tests(test_imu_replay LABEL replay
  SOURCES replay/imu/euroc_preintegration_test.cpp
  DEPS pled::imu)
