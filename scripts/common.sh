# Shared by the scripts of this folder; sourced, not run.
# shellcheck shell=bash

# PLED_JOBS if set; else one job a processor, but no more than one per GiB of free memory.
compile_jobs() {
  local memory_gib jobs
  memory_gib=$(awk '/^MemAvailable:/ { print int($2 / 1048576) }' /proc/meminfo)
  jobs=$(nproc)
  if [[ ${memory_gib:-1} -lt $jobs ]]; then jobs=$((memory_gib > 0 ? memory_gib : 1)); fi
  printf '%s' "${PLED_JOBS:-$jobs}"
}

# Configures and builds a preset; further arguments go to the build. What CMake prints on the way
# is shown only when it fails.
build_preset() {
  local preset=$1 log=build/$1.configure.log
  shift
  # Clones of this repository share what they have compiled: paths below the checkout count as
  # relative ones.
  local -x CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1
  mkdir -p build
  cmake --preset "$preset" >"$log" 2>&1 || { cat "$log" >&2; return 1; }
  cmake --build --preset "$preset" --parallel "$(compile_jobs)" "$@"
}
