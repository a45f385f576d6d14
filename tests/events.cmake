pled_add_tests(test_events
  SOURCES unit/events/active_surface_test.cpp
          unit/events/config_test.cpp
          unit/events/turn_history_test.cpp
  DEPS pled::events)
pled_add_tests(test_events_law LABEL law
  SOURCES law/events/active_surface_test.cpp
          law/events/turn_history_test.cpp
          law/events/event_warp_test.cpp
          law/events/brightness_surface_test.cpp
          law/events/time_surface_test.cpp
          law/events/arc_star_test.cpp
  DEPS pled::events)
pled_add_tests(test_events_memory LABEL memory
  SOURCES memory/events/events_test.cpp support/heap_counter.cpp
  DEPS pled::events)
pled_add_tests(test_events_replay LABEL replay
  SOURCES replay/events/contrast_test.cpp
  DEPS pled::replay pled::events)
pled_check_pointers(test_events test_events_law)
add_executable(bench_events bench/events_bench.cpp)
target_include_directories(bench_events PRIVATE ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(bench_events PRIVATE pled_warnings pled::events pled::reliability)
