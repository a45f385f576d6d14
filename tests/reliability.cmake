pled_add_tests(test_reliability
  SOURCES unit/reliability/bin_counters_test.cpp
  DEPS pled::reliability)
pled_add_tests(test_reliability_law LABEL law
  SOURCES law/reliability/anchored_map_test.cpp
          law/reliability/bin_clock_test.cpp
          law/reliability/bin_counters_test.cpp
          law/reliability/entropy_recency_test.cpp
  DEPS pled::reliability)
