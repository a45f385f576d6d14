if(TARGET pled_pipeline)
  pled_add_tests(test_pipeline
    SOURCES unit/pipeline/latency_histogram_test.cpp unit/pipeline/event_feed_test.cpp
            unit/pipeline/still_gyro_bias_test.cpp
    DEPS pled::pipeline)
endif()
