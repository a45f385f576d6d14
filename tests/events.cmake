add_executable(bench_events bench/events_bench.cpp)
target_include_directories(bench_events PRIVATE ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(bench_events PRIVATE pled_warnings pled::events)
