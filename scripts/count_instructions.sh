#!/usr/bin/env bash
# What events cost at four sensor sizes, on generated streams with the same number of events:
# instructions counted by callgrind, and nanoseconds beside a plain store of each event in the same
# run. Then the cost of the map's anchors beside warping anew for each frame, and how their scores
# differ.
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
build_preset release --target bench_events bench_anchors >&2
benches=build/release/tests
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# count_stages PROGRAM ARGUMENT...: "stage instructions" of each function stage_*; what the program
# prints goes to $out/summary.
count_stages() {
  valgrind --tool=callgrind --callgrind-out-file="$out/profile" --toggle-collect='stage_*' \
    "$benches/$1" "${@:2}" >"$out/summary" 2>"$out/log" || { cat "$out/log" >&2; return 1; }
  callgrind_annotate --inclusive=yes --threshold=100 "$out/profile" |
    awk 'match($0, /stage_[a-z_0-9]+/) {
           name = substr($0, RSTART + 6, RLENGTH - 6)
           count = $1
           gsub(/,/, "", count)
           if (!(name in seen)) print name, count
           seen[name] = 1
         }'
}

# Rows "size stage per_event per_picture".
for size in 240x180 346x260 640x480 1280x720; do
  count_stages bench_events "${size%x*}" "${size#*x}" >"$out/stages"
  awk -v size="$size" '
    NR == FNR { if (FNR == 1) { events = $2; frames = $4 } next }
    { print size, $1, $2 / events, $2 / frames }' "$out/summary" "$out/stages"
done >"$out/counts"
"$benches/bench_events" >"$out/times"

awk '
  FILENAME == ARGV[1] { event[$1, $2] = $3; picture[$1, $2] = $4; next }
  /^[0-9]+x[0-9]+:/ { size = $1; sub(/:/, "", size); next }
  { ns[size, $1] = $2 }
  function row(label, format, table, name,    k) {
    printf "%-34s", label
    for (k = 1; k <= 4; ++k) printf format, table[sizes[k], name]
    printf "\n"
  }
  END {
    split("240x180 346x260 640x480 1280x720", sizes, " ")
    for (k = 1; k <= 4; ++k) {
      s = sizes[k]
      event[s, "sum"] = event[s, "surface"] + event[s, "compensation"] + event[s, "counters"]
      ns[s, "sum"] = ns[s, "surface"] + ns[s, "compensation"] + ns[s, "counters"]
    }
    printf "%-34s%12s%12s%12s%12s\n", "", sizes[1], sizes[2], sizes[3], sizes[4]
    print "instructions an event"
    n = split("floor surface compensation counters sum brightness", names, " ")
    for (i = 1; i <= n; ++i) row("  " names[i], "%12.1f", event, names[i])
    most = 0
    for (k = 1; k <= 4; ++k) if (event[sizes[k], "sum"] > most) most = event[sizes[k], "sum"]
    printf "  the sum is at most %.1f (due 110) and grows by %.2f (due 1.3)\n", most,
      event[sizes[4], "sum"] / event[sizes[1], "sum"]
    print "instructions a frame, thousands"
    m = split("brightness_picture time_surface_raw time_surface_carried arc_star", pictures, " ")
    for (i = 1; i <= m; ++i) {
      for (k = 1; k <= 4; ++k) thousand[sizes[k], pictures[i]] = picture[sizes[k], pictures[i]] / 1000
      row("  " pictures[i], "%12.0f", thousand, pictures[i])
    }
    print "nanoseconds an event, processor time"
    for (i = 1; i <= n; ++i) row("  " names[i], "%12.2f", ns, names[i])
  }' "$out/counts" "$out/times"

echo
echo "anchors of the map at 240x180, beside warping the window anew for each frame"
printf '%8s %30s\n%8s %10s %9s %9s\n' '' 'instructions an event' 'rad/s' anchors 'at 30 Hz' 'at 60 Hz'
for rate in 0 0.1 0.5 2; do
  count_stages bench_anchors "$rate" >"$out/stages"
  awk -v rate="$rate" '
    NR == FNR { events = $1; next }
    { per[$1] = $2 / events }
    END { printf "%8.2f %10.1f %9.1f %9.1f\n", rate, per["anchors"], per["rewarp_at_30_hz"],
            per["rewarp_at_60_hz"] }' "$out/summary" "$out/stages"
done
"$benches/bench_anchors"
