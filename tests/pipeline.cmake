if(TARGET pled_pipeline)
  pled_add_tests(test_pipeline
    SOURCES unit/pipeline/latency_histogram_test.cpp unit/pipeline/event_feed_test.cpp
            unit/pipeline/still_gyro_bias_test.cpp unit/pipeline/time_shift_search_test.cpp
            unit/pipeline/event_admission_test.cpp unit/pipeline/rate_limit_test.cpp
            unit/pipeline/event_stage_test.cpp unit/pipeline/event_stage_clock_test.cpp
            unit/pipeline/event_scores_test.cpp unit/pipeline/event_losses_test.cpp
            unit/pipeline/line_cues_test.cpp unit/pipeline/line_stage_test.cpp
            unit/pipeline/guess_path_test.cpp unit/pipeline/temporal_cues_test.cpp
            unit/pipeline/vio_pipeline_test.cpp
    DEPS pled::pipeline)
endif()
pled_add_tests(test_pipeline_memory LABEL memory
  SOURCES memory/pipeline/vio_pipeline_test.cpp
          ${PROJECT_SOURCE_DIR}/src/apps/allocation_counter.cpp
  DEPS pled::pipeline pled::backend_solver)
