pled_add_fuzz(fuzz_evt3 SOURCES fuzz/evt3_fuzz.cpp DEPS pled::decode)
pled_add_fuzz(fuzz_aedat2 SOURCES fuzz/aedat2_fuzz.cpp DEPS pled::decode)
pled_add_fuzz(fuzz_aedat4 SOURCES fuzz/aedat4_fuzz.cpp DEPS pled::replay)
