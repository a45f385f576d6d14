pled_add_fuzz(fuzz_evt3 SOURCES fuzz/evt3_fuzz.cpp DEPS pled::decode)
