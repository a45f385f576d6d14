pled_add_tests(test_backend
  SOURCES
    law/backend/consistency_test.cpp
    law/backend/residual_test.cpp
    law/backend/window_test.cpp
    support/point_world.cpp
    support/simulated_run.cpp
    unit/backend/backend_test.cpp
  DEPS pled::backend pled::backend_solver)

# Prints the mean NEES over simulated runs; exit 1 when it lies outside its bounds.
add_executable(consistency bench/consistency.cpp support/point_world.cpp support/simulated_run.cpp)
target_include_directories(consistency PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(consistency PRIVATE pled_warnings pled::backend pled::backend_solver)
add_test(NAME backend_consistency_50_runs COMMAND consistency 50 10)
set_tests_properties(backend_consistency_50_runs PROPERTIES LABELS long TIMEOUT 3000)
