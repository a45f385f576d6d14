#!/usr/bin/env bash
# Instructions of each stage of the event front end, counted by callgrind on generated streams with
# the same number of events at four sensor sizes.
#
# usage: scripts/count_instructions.sh            (needs valgrind; builds the release preset)
set -euo pipefail
cd "$(dirname "$0")/.."
# shellcheck source=scripts/common.sh
source scripts/common.sh

command -v valgrind >/dev/null || {
  echo "count_instructions: valgrind is not installed (apt-get install valgrind)" >&2
  exit 1
}
build_preset release --target bench_events >&2
bench=build/release/tests/bench_events
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

printf '%-24s %12s %16s %16s\n' stage sensor instr/event instr/frame
for size in 240x180 346x260 640x480 1280x720; do
  profile=$out/$size
  summary=$(valgrind --tool=callgrind --callgrind-out-file="$profile" --toggle-collect='stage_*' \
    "$bench" "${size%x*}" "${size#*x}" 2>"$out/log" | head -1) || { cat "$out/log" >&2; exit 1; }
  events=$(sed -E 's/.*: ([0-9]+) events.*/\1/' <<<"$summary")
  frames=$(sed -E 's/.* ([0-9]+) frames.*/\1/' <<<"$summary")
  callgrind_annotate --inclusive=yes --threshold=100 "$profile" |
    awk -v size="$size" -v events="$events" -v frames="$frames" '
      match($0, /stage_[a-z_]+/) {
        name = substr($0, RSTART + 6, RLENGTH - 6)
        count = $1
        gsub(/,/, "", count)
        if (!(name in seen)) printf "%-24s %12s %16.1f %16.0f\n", name, size, count / events, count / frames
        seen[name] = 1
      }'
done
