pled_add_tests(test_drivers
  SOURCES unit/drivers/decimal_test.cpp unit/drivers/evt3_decoder_test.cpp
          unit/drivers/text_event_decoder_test.cpp unit/drivers/raw_file_source_test.cpp
          unit/drivers/imu_source_test.cpp unit/drivers/image_reader_test.cpp
          unit/drivers/frame_source_test.cpp unit/drivers/recording_test.cpp
          unit/drivers/recording_info_test.cpp unit/drivers/input_faults_test.cpp
          unit/drivers/stamp_source_test.cpp
          unit/drivers/aedat2_decoders_test.cpp unit/drivers/aedat2_file_test.cpp
          unit/drivers/aedat4_packets_test.cpp unit/drivers/aedat4_event_decoder_test.cpp
          unit/drivers/aedat4_file_test.cpp unit/drivers/aedat4_damage_test.cpp
  DEPS pled::replay PNG::PNG JPEG::JPEG pled::lz4 pled::zstd)
pled_add_tests(test_drivers_law LABEL law
  SOURCES law/drivers/event_decoder_test.cpp
  DEPS pled::decode pled::lz4 pled::zstd)
pled_add_tests(test_drivers_replay LABEL replay
  SOURCES replay/drivers/golden_files_test.cpp
  DEPS pled::replay)
pled_add_tests(test_drivers_memory LABEL memory
  SOURCES memory/drivers/allocations_test.cpp
  DEPS pled::replay PNG::PNG JPEG::JPEG pled::lz4 pled::zstd)
pled_check_pointers(test_drivers test_drivers_law test_drivers_replay test_drivers_memory)
