#!/usr/bin/env bash
# Accuracy table: replays each recording from several starts and prints the median and the worst.
#
#   scripts/accuracy.sh [--starts N] [--step S] [--config FILE] [--jobs N] RECORDING...
#
# A recording is a folder that `pled-vins replay` reads and that has groundtruth.txt. Defaults: ten
# starts, 0.2 s apart. Results stay in build/accuracy/.
set -euo pipefail

top=$(cd "$(dirname "$0")/.." && pwd)
program=${PLED_VINS:-$top/build/release/pled-vins}
starts=10
step=0.2
jobs=$(nproc)
config=()
recordings=()
while [ $# -gt 0 ]; do
  case "$1" in
    --starts) starts=${2:?--starts needs a number}; shift 2 ;;
    --step) step=${2:?--step needs seconds}; shift 2 ;;
    --jobs) jobs=${2:?--jobs needs a number}; shift 2 ;;
    --config) config=(--config "${2:?--config needs a file}"); shift 2 ;;
    -h|--help) sed -n '2,7s/^# \{0,1\}//p' "$0"; exit 0 ;;
    -*) echo "accuracy.sh: unknown option $1 (see --help)" >&2; exit 2 ;;
    *) recordings+=("$1"); shift ;;
  esac
done
[ ${#recordings[@]} -gt 0 ] || { echo "accuracy.sh: name at least one recording (see --help)" >&2; exit 2; }
[ -x "$program" ] || { echo "accuracy.sh: $program is missing: run scripts/demo.sh or scripts/test.sh first" >&2; exit 1; }

out=${PLED_ACCURACY_OUT:-$top/build/accuracy}
mkdir -p "$out"
# shellcheck disable=SC2016  # the inner shell expands
for recording in "${recordings[@]}"; do
  name=$(basename "$recording")
  for k in $(seq 0 $((starts - 1))); do
    start=$(awk -v k="$k" -v s="$step" 'BEGIN { printf "%.3f", k * s }')
    printf '%s\0%s\0%s\0' "$recording" "$start" "$out/$name-$start"
  done
done | xargs -0 -n 3 -P "$jobs" bash -c '
  program=$1; shift; config=("${@:1:$#-3}"); set -- "${@: -3}"
  rm -rf "$3"
  "$program" replay "$1" --start "$2" --out "$3" --force "${config[@]}" > "$3.log" 2>&1 || echo "failed: $1 --start $2 (see $3.log)" >&2
' accuracy "$program" "${config[@]}"

value() { # file key: the number after "key" in a report, or nothing
  sed -n "s/.*\"$2\": *\(-\{0,1\}[0-9.eE+-]*\).*/\1/p" "$1" | head -n 1
}
median_worst() { # numbers on stdin, one a line; $1 = max or min is the worst
  sort -g | awk -v worst="$1" '{ v[NR] = $1 }
    END { if (NR == 0) { print "- -"; exit }
          m = NR % 2 ? v[(NR + 1) / 2] : (v[NR / 2] + v[NR / 2 + 1]) / 2
          printf "%.4g %.4g\n", m, worst == "max" ? v[NR] : v[1] }'
}

printf '%-18s %6s | %-17s | %-17s | %-17s | %-15s | %s\n' recording runs "ATE m med/worst" "MPE % med/worst" "coverage med/min" "start s med/max" "CPU ms/frame, resets"
for recording in "${recordings[@]}"; do
  name=$(basename "$recording")
  reports=()
  for report in "$out/$name"-*/report.json; do [ -f "$report" ] && reports+=("$report"); done
  column() { for r in "${reports[@]}"; do value "$r" "$1"; done | grep -v '^$' | median_worst "$2" || true; }
  read -ra numbers <<<"$(column ate_rmse_m max) $(column mpe_percent max) $(column coverage min) $(column initialised_at_s max)"
  printf '%-18s %6s | %8s %8s | %8s %8s | %8s %8s | %7s %7s | %s\n' "$name" "${#reports[@]}" \
    "${numbers[@]}" \
    "$(column cpu_ms_per_frame max | cut -d' ' -f1), $(for r in "${reports[@]}"; do value "$r" resets; done | awk '{ s += $1 } END { print s + 0 }')"
done
