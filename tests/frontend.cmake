pled_add_tests(test_frontend
  SOURCES unit/frontend/frame_tracker_test.cpp
          unit/frontend/frame_tracker_faults_test.cpp
          unit/frontend/event_points_tracker_test.cpp
          unit/frontend/epipolar_fit_test.cpp
          unit/frontend/motion_check_test.cpp
          law/frontend/corners_test.cpp
          law/frontend/pyramid_test.cpp
          law/frontend/patch_aligner_test.cpp
  DEPS pled::frontend)
pled_add_tests(test_frontend_memory LABEL memory
  SOURCES memory/frontend/frame_tracker_test.cpp support/heap_counter.cpp
  DEPS pled::frontend)
add_executable(bench_frontend bench/frontend_bench.cpp)
target_include_directories(bench_frontend PRIVATE ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(bench_frontend PRIVATE pled_warnings pled::frontend)
