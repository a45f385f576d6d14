pled_add_tests(test_report
  SOURCES
    unit/report/feature_digest_test.cpp
    unit/report/features_file_test.cpp
    unit/report/page_test.cpp
    unit/report/picture_test.cpp
    unit/report/rates_test.cpp
  DEPS pled::report nlohmann_json::nlohmann_json)
