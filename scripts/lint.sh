#!/usr/bin/env bash
# Style checks; each prints what is wrong and fails if there is anything.
#
#   scripts/lint.sh format [FILE...]   clang-format, all sources unless files are named; changes nothing
#   scripts/lint.sh tidy [FILE...]     clang-tidy, as build/release compiles them: what ships, with its headers; tests when named
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/common.sh

# sources PATTERN FOLDER...
sources() {
  local folder
  for folder in "${@:2}"; do
    if [[ -d $folder ]]; then find "$folder" -type f -name "$1"; fi
  done | sort
}

command=${1:-}
[[ $# -eq 0 ]] || shift
case $command in
  format)
    if [[ $# -eq 0 ]]; then mapfile -t files < <(sources '*.[ch]pp' include src drivers firmware_bridge tests); else files=("$@"); fi
    clang-format --dry-run --Werror "${files[@]}"
    ;;
  tidy)
    [[ -f build/release/compile_commands.json ]] || build_preset release
    if [[ $# -eq 0 ]]; then
      # Only what the build compiles: a fuzz target, say, has no command in it.
      mapfile -t files < <(sources '*.cpp' src drivers firmware_bridge | while read -r file; do
        if grep -qF "\"file\": \"$PWD/$file\"" build/release/compile_commands.json; then
          printf '%s\n' "$file"
        fi
      done)
    else
      files=("$@")
    fi
    # GCC's own warning options mean nothing to clang.
    printf '%s\0' "${files[@]}" |
      xargs -0 -n 1 -P "$(compile_jobs)" clang-tidy -p build/release --quiet \
        --extra-arg=-Wno-unknown-warning-option
    ;;
  *)
    sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//;p}' "${BASH_SOURCE[0]}" >&2
    exit 2
    ;;
esac
