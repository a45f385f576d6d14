pled_add_tests(test_core
  SOURCES
    unit/core/fixed_vector_test.cpp
    unit/core/image_view_test.cpp
    unit/core/result_test.cpp
    unit/core/spsc_ring_test.cpp
    unit/core/timestamp_test.cpp
  DEPS pled::core Threads::Threads)
pled_check_pointers(test_core)
