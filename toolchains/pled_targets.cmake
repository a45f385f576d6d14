# Helpers that give every target the same warnings, sanitizers and names.

add_library(pled_warnings INTERFACE)
target_compile_options(pled_warnings INTERFACE
  -Wall -Wextra -Werror -Wconversion -Wsign-conversion -Wshadow -Wdouble-promotion
  -Wnon-virtual-dtor -Woverloaded-virtual
  # The same bits wherever IEEE arithmetic is the same: no contraction to fused multiply-add.
  -ffp-contract=off)
if(PLED_SANITIZE)
  list(JOIN PLED_SANITIZE "," pled_sanitize_list)
  target_compile_options(pled_warnings INTERFACE
    -fsanitize=${pled_sanitize_list} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(pled_warnings INTERFACE -fsanitize=${pled_sanitize_list})
  if("undefined" IN_LIST PLED_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # Checks on every pointer that Eigen's templates touch double GCC's compile time (gyro_bias.cpp: 25 s
    # with them, 15 s without; preintegration.cpp: 35 s and 17 s), so they are on only where a target
    # asks for them: those that step through bytes and pixels by hand. Elsewhere the address sanitizer
    # and Eigen's own asserts see most of it. The fuzzers, built by clang, keep all of them everywhere.
    target_compile_options(pled_warnings INTERFACE
      $<$<NOT:$<BOOL:$<TARGET_PROPERTY:PLED_POINTER_CHECKS>>>:-fno-sanitize=null,alignment,object-size,pointer-overflow,vptr>)
  endif()
endif()

if(PLED_BUILD_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    message(FATAL_ERROR "PLED_BUILD_FUZZ needs clang: use the preset 'fuzz'.")
  endif()
  target_compile_options(pled_warnings INTERFACE -fsanitize=fuzzer-no-link)
  add_custom_target(pled_fuzzers)
endif()

# Compiler cache where there is one; a choice on the command line wins.
find_program(PLED_CCACHE ccache)
if(PLED_CCACHE)
  foreach(language C CXX)
    if(NOT CMAKE_${language}_COMPILER_LAUNCHER)
      set(CMAKE_${language}_COMPILER_LAUNCHER ${PLED_CCACHE})
    endif()
  endforeach()
endif()

# Adds a folder when it has a CMakeLists.txt of its own.
function(pled_add_folder folder)
  if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/CMakeLists.txt)
    add_subdirectory(${folder})
  endif()
endfunction()

# pled_check_pointers(target …): all of the undefined-behaviour checks for these, see above.
function(pled_check_pointers)
  set_target_properties(${ARGN} PROPERTIES PLED_POINTER_CHECKS ON)
endfunction()

# pled_add_library(pled_core SOURCES a.cpp … DEPS pled::other …  PRIVATE_DEPS lib …): static library, alias pled::core.
function(pled_add_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS;PRIVATE_DEPS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  string(REPLACE "pled_" "" short ${name})
  add_library(pled::${short} ALIAS ${name})
  target_include_directories(${name} PUBLIC ${PROJECT_SOURCE_DIR}/include)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PUBLIC ${ARG_DEPS} PRIVATE pled_warnings ${ARG_PRIVATE_DEPS})
endfunction()

# pled_add_tests(test_core LABEL unit SOURCES … DEPS …): one doctest executable and one ctest entry per
# test suite file's executable, labelled.
function(pled_add_tests name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT" "SOURCES;DEPS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/tests)
  target_link_libraries(${name} PRIVATE pled_warnings pled_doctest_main ${ARG_DEPS})
  add_test(NAME ${name} COMMAND ${name})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  set_tests_properties(${name} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT})
endfunction()

# pled_add_fuzz(fuzz_evt3 SOURCES … DEPS …): a libFuzzer executable in build/fuzz/fuzzers, and a short run
# of it as a test, labelled fuzz. Nothing unless PLED_BUILD_FUZZ is on.
function(pled_add_fuzz name)
  if(NOT PLED_BUILD_FUZZ)
    return()
  endif()
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/tests)
  target_link_libraries(${name} PRIVATE pled_warnings ${ARG_DEPS})
  target_link_options(${name} PRIVATE -fsanitize=fuzzer)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/fuzzers)
  add_dependencies(pled_fuzzers ${name})
  add_test(NAME ${name} COMMAND ${name} -runs=20000 -seed=1 -timeout=10)
  set_tests_properties(${name} PROPERTIES LABELS fuzz TIMEOUT 300)
endfunction()
