pled_add_tests(test_lines
  SOURCES unit/frontend/lines/line_detector_test.cpp
          unit/frontend/lines/line_match_test.cpp
          unit/frontend/lines/line_rates_test.cpp
          unit/frontend/lines/line_tracker_test.cpp
          law/frontend/lines/line_image_test.cpp
          law/frontend/lines/line_descriptor_test.cpp
          law/frontend/lines/segment_merge_test.cpp
  DEPS pled::lines)
pled_add_tests(test_lines_memory LABEL memory
  SOURCES memory/frontend/lines/line_tracker_test.cpp support/heap_counter.cpp
  DEPS pled::lines)
