#!/usr/bin/env bash
# Set-up if needed, build, tests. The last line is "N passed, N failed" over all runs.
#
#   scripts/test.sh          release build, then again under the address and undefined-behaviour sanitizers
#   scripts/test.sh --full   also: long tests, thread sanitizer, fuzzers, clang-tidy, clang-format
#
#   PLED_RECORDINGS     folder of recordings for the tests that need some; without it they say what they skip
#   PLED_FUZZ_SECONDS   for each fuzzer (default 60)
#   PLED_JOBS           compile and test jobs
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/common.sh

passed=0
failed=0
summary=()

# count NAME PASSED FAILED SECONDS: adds one run to the totals.
count() {
  passed=$((passed + $2))
  failed=$((failed + $3))
  summary+=("$(printf '%-14s %5d passed %5d failed %6d s' "$1" "$2" "$3" "$4")")
}

# Counts cases in a ctest log: doctest's own count where a test prints one, else one for the test.
# A test that fails without a failed case (crash, leak, timeout) counts as one failure.
count_cases() {
  awk '
    /^\[doctest\] test cases:/ { split($0, n, /[:|]/); p = n[3] + 0; f = n[4] + 0; counted = 1 }
    /^Test Passed\.$/ { ok = 1 }
    /^".*" end time:/ {
      if (!counted) { p = ok; f = 0 }
      if (!ok && f == 0) f = 1
      passed += p; failed += f; p = f = counted = ok = 0
    }
    END { print passed + 0, failed + 0 }' "$1"
}

# run_tests NAME PRESET TEST_PRESET [BUILD_OPTION...]: builds and runs; a build that fails is one failure.
run_tests() {
  local name=$1 preset=$2 test_preset=$3 started=$SECONDS log cases_passed cases_failed status=0
  local runner=()
  printf '\n== %s\n' "$name"
  if ! build_preset "$preset" "${@:4}"; then
    count "$name: build" 0 1 $((SECONDS - started))
    return
  fi
  # Address randomisation of newer kernels collides with the thread sanitizer's fixed layout.
  if [[ $preset == tsan ]] && setarch -R true 2>/dev/null; then runner=(setarch -R); fi
  log=build/$preset/Testing/Temporary/LastTest.log
  rm -f "$log"
  "${runner[@]}" ctest --preset "$test_preset" --parallel "$(compile_jobs)" \
    --test-output-size-passed 1000000 --test-output-size-failed 1000000 </dev/null || status=$?
  read -r cases_passed cases_failed < <(if [[ -f $log ]]; then count_cases "$log"; else echo 0 0; fi)
  if [[ $status -ne 0 && $cases_failed -eq 0 ]]; then cases_failed=1; fi
  count "$name" "$cases_passed" "$cases_failed" $((SECONDS - started))
}

# check NAME COMMAND...: one pass or one failure.
check() {
  local name=$1 started=$SECONDS
  shift
  printf '\n== %s\n' "$name"
  if "$@" </dev/null; then
    count "$name" 1 0 $((SECONDS - started))
  else
    count "$name" 0 1 $((SECONDS - started))
  fi
}

run_fuzzers() {
  local seconds=${PLED_FUZZ_SECONDS:-60} fuzzer name folders
  rm -rf build/fuzz/fuzzers  # a fuzzer that no longer builds must not run
  check "fuzz: build" build_preset fuzz --target pled_fuzzers
  for fuzzer in build/fuzz/fuzzers/*; do
    [[ -x $fuzzer && -f $fuzzer ]] || continue
    name=${fuzzer##*/}
    folders=("build/fuzz/corpus/$name")
    mkdir -p "${folders[0]}"
    if [[ -d tests/fuzz/corpus/$name ]]; then folders+=("tests/fuzz/corpus/$name"); fi
    check "$name" "$fuzzer" -max_total_time="$seconds" -timeout=10 -print_final_stats=1 -verbosity=0 \
      -artifact_prefix="build/fuzz/$name-" "${folders[@]}"
  done
}

main() {
  local full=0 line
  case ${1:-} in
    '') ;;
    --full) full=1 ;;
    -h | --help) sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//;p}' "${BASH_SOURCE[0]}"; return 0 ;;
    *) printf "test: unknown option '%s' (there is --full)\n" "$1" >&2; return 2 ;;
  esac

  if [[ $full -eq 1 ]]; then scripts/setup.sh --full; else scripts/setup.sh; fi
  run_tests release release release
  run_tests sanitizers asan asan
  if [[ $full -eq 1 ]]; then
    run_tests long release long
    run_tests threads tsan tsan --target pled_threaded_tests
    run_fuzzers
    check clang-format scripts/lint.sh format
    check clang-tidy scripts/lint.sh tidy
  fi

  printf '\n'
  for line in "${summary[@]}"; do printf '%s\n' "$line"; done
  printf '\n%d passed, %d failed\n' "$passed" "$failed"
  [[ $failed -eq 0 && $passed -gt 0 ]]
}

main "$@"
