pled_add_tests(test_sim TIMEOUT 1500
  SOURCES
    unit/sim/options_test.cpp
    unit/sim/evt3_encoder_test.cpp
    unit/sim/simulator_test.cpp
  DEPS pled::sim pled::decode)
# Minutes under the thread sanitizer.
pled_add_tests(test_sim_law LABEL law TIMEOUT 1500
  SOURCES
    law/sim/event_model_test.cpp
    law/sim/evt3_round_trip_test.cpp
    law/sim/imu_model_test.cpp
    law/sim/labels_test.cpp
    law/sim/renderer_test.cpp
    law/sim/reprojection_test.cpp
    law/sim/scenes_test.cpp
    law/sim/trajectory_test.cpp
  DEPS pled::sim pled::decode pled::imu pled::frontend pled::lines)
