pled_add_tests(test_evaluation
  SOURCES
    law/evaluation/align_test.cpp
    law/evaluation/weights_test.cpp
    unit/evaluation/evaluate_test.cpp
    unit/evaluation/trajectory_test.cpp
  DEPS pled::evaluation)
