# Third-party packages, each behind one name, headers as SYSTEM.

find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Threads REQUIRED)

# OpenCV: core and imgproc only. Debian's OpenCVConfig.cmake comes with the package of every
# module, so the two libraries are looked up by name.
find_path(PLED_OPENCV_INCLUDE opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
find_library(PLED_OPENCV_CORE opencv_core REQUIRED)
find_library(PLED_OPENCV_IMGPROC opencv_imgproc REQUIRED)
add_library(pled_opencv INTERFACE)
add_library(pled::opencv ALIAS pled_opencv)
target_include_directories(pled_opencv SYSTEM INTERFACE ${PLED_OPENCV_INCLUDE}
  /usr/include/${CMAKE_LIBRARY_ARCHITECTURE}/opencv4)
target_link_libraries(pled_opencv INTERFACE ${PLED_OPENCV_IMGPROC} ${PLED_OPENCV_CORE})

# Ceres, built by scripts/setup.sh.
if(NOT PLED_CERES_ROOT)
  set(pled_cache "$ENV{PLED_CACHE}")
  if(NOT pled_cache)
    set(pled_cache "$ENV{XDG_CACHE_HOME}")
    if(NOT pled_cache)
      set(pled_cache "$ENV{HOME}/.cache")
    endif()
    set(pled_cache "${pled_cache}/pled-vins")
  endif()
  set(pled_ceres_root "${pled_cache}/ceres")
else()
  set(pled_ceres_root "${PLED_CERES_ROOT}")
endif()
find_package(Ceres 2.1 QUIET HINTS ${pled_ceres_root} NO_DEFAULT_PATH)
if(NOT Ceres_FOUND)
  message(FATAL_ERROR "Ceres was not found in ${pled_ceres_root}: run scripts/setup.sh first.")
endif()

find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(CLI11 2.1 REQUIRED)
find_package(PNG REQUIRED)
find_package(JPEG REQUIRED)

# pled_find_optional(lz4 LZ4 header library): pled::lz4, with PLED_WITH_LZ4 defined as 1 when it is there.
# Without it, recordings that need it are refused with words that name the package.
function(pled_find_optional name upper header library)
  add_library(pled_${name} INTERFACE)
  add_library(pled::${name} ALIAS pled_${name})
  find_path(PLED_${upper}_INCLUDE ${header})
  find_library(PLED_${upper}_LIBRARY ${library})
  if(PLED_${upper}_INCLUDE AND PLED_${upper}_LIBRARY)
    target_include_directories(pled_${name} SYSTEM INTERFACE ${PLED_${upper}_INCLUDE})
    target_link_libraries(pled_${name} INTERFACE ${PLED_${upper}_LIBRARY})
    target_compile_definitions(pled_${name} INTERFACE PLED_WITH_${upper}=1)
  else()
    message(STATUS "lib${name} was not found: AEDAT4 files that it packed cannot be read")
    target_compile_definitions(pled_${name} INTERFACE PLED_WITH_${upper}=0)
  endif()
endfunction()
pled_find_optional(lz4 LZ4 lz4frame.h lz4)
pled_find_optional(zstd ZSTD zstd.h zstd)
if(PLED_BUILD_TESTS)
  find_package(doctest 2.4 REQUIRED)
endif()
