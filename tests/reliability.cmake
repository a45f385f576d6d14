pled_add_tests(test_reliability
  SOURCES unit/reliability/bin_counters_test.cpp
          unit/reliability/line_motion_cue_test.cpp
          unit/reliability/motion_cue_test.cpp
          unit/reliability/nearness_test.cpp
  DEPS pled::reliability)
pled_add_tests(test_reliability_law LABEL law
  SOURCES law/reliability/anchored_map_test.cpp
          law/reliability/bin_clock_test.cpp
          law/reliability/bin_counters_test.cpp
          law/reliability/entropy_recency_test.cpp
          law/reliability/line_alpha_test.cpp
          law/reliability/line_band_test.cpp
          law/reliability/line_motion_cue_test.cpp
          law/reliability/motion_cue_test.cpp
          law/reliability/rewarp_test.cpp
          support/reliability/rotating_edges.cpp
  DEPS pled::reliability)
add_executable(bench_anchors bench/anchors_bench.cpp support/reliability/rotating_edges.cpp)
target_include_directories(bench_anchors PRIVATE ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(bench_anchors PRIVATE pled_warnings pled::pipeline)
