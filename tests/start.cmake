pled_add_tests(test_start
  SOURCES
    support/start_world.cpp
    unit/start/refusal_test.cpp
    law/start/motion_derivatives_test.cpp
    law/start/gravity_constraint_test.cpp
    law/start/start_statistics_test.cpp
  DEPS pled::start pled::point_world)

pled_add_tests(test_bootstrap
  SOURCES
    support/start_world.cpp
    unit/start/bootstrap_test.cpp
  DEPS pled::backend pled::backend_solver pled::point_world)
