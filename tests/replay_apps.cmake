# For cases that need a disk which breaks; preloaded, so it has no sanitizer in it.
add_library(pled_failing_read MODULE support/failing_read.cpp)

# The main job through the real executable. Recordings are made in the build folder.
function(pled_add_replay_tests name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT" "SOURCES" ${ARGN})
  pled_add_tests(${name} LABEL ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT}
    SOURCES ${ARG_SOURCES} support/recording_fixture.cpp
    DEPS pled::sim pled::replay pled::evaluation pled::lz4 pled::zstd nlohmann_json::nlohmann_json)
  target_compile_definitions(${name} PRIVATE PLED_VINS_EXE="$<TARGET_FILE:pled-vins>"
                                             PLED_TEST_FOLDER="${CMAKE_CURRENT_BINARY_DIR}/${name}.run"
                                             PLED_FAILING_READ="$<TARGET_FILE:pled_failing_read>")
  add_dependencies(${name} pled-vins pled_failing_read)
  # GCC 12 sees an overlap in std::string's operator+ that is not there (GCC bug 105651).
  target_compile_options(${name} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
endfunction()

# Two of them, so that two processors share the time.
pled_add_replay_tests(test_apps_replay LABEL replay TIMEOUT 1800
  SOURCES replay/apps/results_test.cpp replay/apps/options_test.cpp
          replay/apps/report_test.cpp replay/apps/simulate_test.cpp replay/apps/sizes_test.cpp
          replay/apps/time_shift_test.cpp replay/apps/aedat_test.cpp
          replay/apps/streams_test.cpp)
pled_add_replay_tests(test_apps_bad_input LABEL replay TIMEOUT 1800
  SOURCES replay/apps/bad_files_test.cpp replay/apps/bad_data_test.cpp
          replay/apps/bad_events_test.cpp replay/apps/ablate_test.cpp
          replay/apps/score_test.cpp)
pled_add_replay_tests(test_apps_no_start LABEL replay TIMEOUT 1200
  SOURCES replay/apps/no_start_test.cpp support/simulated_scene.cpp)
pled_add_replay_tests(test_apps_behaviour LABEL long TIMEOUT 3600
  SOURCES replay/apps/behaviour_test.cpp support/simulated_scene.cpp)
pled_add_replay_tests(test_apps_recordings LABEL long TIMEOUT 1800
  SOURCES replay/apps/recordings_test.cpp replay/apps/unknown_time_shift_test.cpp)
