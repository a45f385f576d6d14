pled_add_tests(test_geometry LABEL law
  SOURCES law/geometry/so3_test.cpp
          law/geometry/camera_test.cpp
          law/geometry/triangulation_test.cpp
          law/geometry/line_test.cpp
          law/geometry/line_baseline_test.cpp
          law/geometry/line_triangulation_test.cpp
  DEPS pled::geometry)
