pled_add_tests(test_architecture SOURCES unit/architecture_test.cpp)
target_compile_definitions(test_architecture PRIVATE PLED_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
