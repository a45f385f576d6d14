#!/usr/bin/env bash
# Accuracy table: replays each recording from several starts and prints the median and the worst.
#
#   scripts/accuracy.sh [--starts N] [--step S] [--config FILE] [--jobs N] [--no-events|--no-frames]
#                       RECORDING...
#
# "ATE % path": ATE in hundredths of the way that was evaluated.
# A run that never started, or failed, counts as worse than any other ("none").
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
    --config) config+=(--config "${2:?--config needs a file}"); shift 2 ;;
    --no-events|--no-frames) config+=("$1"); shift ;;
    -h|--help) sed -n '2,11s/^# \{0,1\}//p' "$0"; exit 0 ;;
    -*) echo "accuracy.sh: unknown option $1 (see --help)" >&2; exit 2 ;;
    *) recordings+=("$1"); shift ;;
  esac
done
[ ${#recordings[@]} -gt 0 ] || { echo "accuracy.sh: name at least one recording (see --help)" >&2; exit 2; }
[ -x "$program" ] || { echo "accuracy.sh: $program is missing: run scripts/demo.sh or scripts/test.sh first" >&2; exit 1; }

out=${PLED_ACCURACY_OUT:-$top/build/accuracy}
mkdir -p "$out"

# One folder a run, by the recording's place in the list: two recordings may have the same name.
run_folder() { printf '%s/%s-%s-%s' "$out" "$1" "$(basename "${recordings[$1]}")" "$2"; }
start_of() { awk -v k="$1" -v s="$step" 'BEGIN { printf "%.3f", k * s }'; }

for n in "${!recordings[@]}"; do
  for k in $(seq 0 $((starts - 1))); do
    start=$(start_of "$k")
    printf '%s\0%s\0%s\0' "${recordings[$n]}" "$start" "$(run_folder "$n" "$start")"
  done
done | xargs -0 -n 3 -P "$jobs" bash -c '
  program=$1; shift; config=("${@:1:$#-3}"); set -- "${@: -3}"
  rm -rf "$3"
  "$program" replay "$1" --start "$2" --out "$3" --force --no-report "${config[@]}" > "$3.log" 2>&1 || echo "failed: $1 --start $2 (see $3.log)" >&2
' accuracy "$program" "${config[@]}"

value() { # file key: the number after "key" in a report, or "none"
  local number=
  if [ -f "$1" ]; then number=$(sed -n "s/.*\"$2\": *\(-\{0,1\}[0-9.eE+-]*\).*/\1/p" "$1" | head -n 1); fi
  printf '%s\n' "${number:-none}"
}
path_percent() { # recording run-folder: 100 ATE / evaluated path, or "none"
  local facts
  facts=$("$program" evaluate "$2/trajectory.tum" "$1/groundtruth.txt" --json 2>/dev/null) || facts=
  awk '/"ate_rmse_m"/ { ate = $2 + 0; found = $2 ~ /^[0-9]/ } /"path_m"/ { path = $2 + 0 }
    END { if (found && path > 0) printf "%.6g\n", 100 * ate / path; else print "none" }' <<<"$facts"
}
# Numbers on stdin, one a line; $1 = max or min is the worst. "none" is worse than any number.
median_worst() {
  sort -g | awk -v worst="$1" '$1 == "none" { none++; next } { v[++n] = $1 }
    function at(i) { # of all, missing ones at the bad end
      if (worst == "max") return i <= n ? v[i] : "none"
      return i > none ? v[i - none] : "none"
    }
    END { all = n + none; if (all == 0) { print "- -"; exit }
          low = at(int((all + 1) / 2)); high = at(int(all / 2) + 1)
          m = low == "none" || high == "none" ? "none" : sprintf("%.4g", (low + high) / 2)
          w = worst == "max" ? at(all) : at(1)
          print m, w == "none" ? w : sprintf("%.4g", w) }'
}

printf '%-24s %8s | %-17s | %-17s | %-17s | %-17s | %-15s | %s\n' recording started "ATE m med/worst" "ATE % path" "MPE % med/worst" "coverage med/min" "start s med/max" "CPU ms/frame, resets"
for n in "${!recordings[@]}"; do
  reports=()
  for k in $(seq 0 $((starts - 1))); do reports+=("$(run_folder "$n" "$(start_of "$k")")/report.json"); done
  column() { for r in "${reports[@]}"; do value "$r" "$1"; done | median_worst "$2"; }
  of_path() { for r in "${reports[@]}"; do path_percent "${recordings[$n]}" "$(dirname "$r")"; done | median_worst max; }
  started=$(for r in "${reports[@]}"; do value "$r" initialised_at_s; done | grep -vc none || true)
  read -ra numbers <<<"$(column ate_rmse_m max) $(of_path) $(column mpe_percent max) $(column coverage min) $(column initialised_at_s max)"
  printf '%-24s %8s | %8s %8s | %8s %8s | %8s %8s | %8s %8s | %7s %7s | %s\n' \
    "$(basename "${recordings[$n]}")" "$started of $starts" "${numbers[@]}" \
    "$(column cpu_ms_per_frame max | cut -d' ' -f1), $(for r in "${reports[@]}"; do value "$r" resets; done | awk '{ s += $1 } END { print s + 0 }')"
done
