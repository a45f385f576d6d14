#!/usr/bin/env bash
# The development set: simulated recordings to choose cues and parameters on.
#
#   scripts/development_set.sh list                       what it holds: name, seed, world, traffic, light
#   scripts/development_set.sh make [CHOICE...] [DIR]     makes those that are not there yet
#   scripts/development_set.sh run  [CHOICE...] [DIR]     replays each and prints its accuracy
#   scripts/development_set.sh score [CHOICE...] [DIR]    AUC of each weight on those where something moves
#   scripts/development_set.sh ablate [CHOICE...] [DIR]   the same and accuracy, for each way to weigh features
#
# CHOICE: --seeds "1 2"   --worlds "room street"   --levels "none high"   --lights "day night"
#         --paired: to each with traffic the same world and flight without
# DIR: build/development. Whole: 12 seeds x 3 worlds, 6 s each; every traffic level and every light
# comes with every world. A quarter to half a minute each on two cores. A recording is made anew when
# the simulator's sources have changed since.
#
# Seeds 1 to 8 are for choosing. Seeds 9 to 12 are looked at for a closing figure only: what was
# chosen on a recording says nothing about others.
set -euo pipefail

top=$(cd "$(dirname "$0")/.." && pwd)
program=${PLED_VINS:-$top/build/release/pled-vins}
usage() { sed -n '2,17s/^# \{0,1\}//p' "$0"; }
misused() { echo "development_set.sh: $1 (see --help)" >&2; exit 2; }

job=${1:-}
case "$job" in
  list | make | run | score | ablate) shift ;;
  -h | --help) usage; exit 0 ;;
  '') usage >&2; exit 2 ;;
  *) misused "unknown job '$job'" ;;
esac
seeds=$(seq 1 12)
worlds="room car_park street"
levels="none low mid high"
if [ "$job" = score ] || [ "$job" = ablate ]; then levels="low mid high"; fi
lights="day dim night"
folder=$top/build/development
paired=0
while [ $# -gt 0 ]; do
  case "$1" in
    --seeds) seeds=${2:?--seeds needs numbers}; shift 2 ;;
    --worlds) worlds=${2:?--worlds needs names}; shift 2 ;;
    --levels) levels=${2:?--levels needs names}; shift 2 ;;
    --lights) lights=${2:?--lights needs names}; shift 2 ;;
    --paired) paired=1; shift ;;
    -h | --help) usage; exit 0 ;;
    -*) misused "unknown option $1" ;;
    *) folder=$1; shift ;;
  esac
done

has() { case " ${1//$'\n'/ } " in *" $2 "*) ;; *) return 1 ;; esac }
for world in $worlds; do has "room car_park street" "$world" || misused "no world '$world'"; done
for level in $levels; do has "none low mid high" "$level" || misused "no level '$level'"; done
for light in $lights; do has "day dim night" "$light" || misused "no light '$light'"; done

# name seed world level light, a line each. Levels go round every 4 seeds, lights every 3: in 12 seeds
# each level meets each light once. The worlds are a step apart, so that a seed is not all night.
sequences() {
  local all_levels=(none high mid low) all_lights=(day night dim) k=0 world seed level light
  for world in room car_park street; do
    for seed in $(seq 1 12); do
      level=${all_levels[(seed - 1 + k) % 4]}
      light=${all_lights[(seed - 1 + k) % 3]}
      if has "$worlds" "$world" && has "$seeds" "$seed" && has "$levels" "$level" && has "$lights" "$light"; then
        printf '%s %s %s %s %s\n' "$world-$seed-$level-$light" "$seed" "$world" "$level" "$light"
        if [ "$paired" = 1 ] && [ "$level" != none ]; then
          printf '%s %s %s %s %s\n' "$world-$seed-none-$light" "$seed" "$world" none "$light"
        fi
      fi
    done
    k=$((k + 1))
  done
}

chosen=$(sequences)
[ -n "$chosen" ] || { echo "development_set.sh: nothing fits that choice" >&2; exit 1; }
if [ "$job" = list ]; then echo "$chosen"; exit 0; fi
[ -x "$program" ] || { echo "development_set.sh: $program is missing: run scripts/demo.sh or scripts/test.sh first" >&2; exit 1; }

mkdir -p "$folder"
simulator=$(cd "$top" && find src/sim include/pled_vins/sim src/geometry -type f | LC_ALL=C sort | xargs cksum | cksum)
make_one() { # name seed world level light
  [ -f "$folder/$1/simulator" ] && [ "$(cat "$folder/$1/simulator")" = "$simulator" ] && return
  rm -rf -- "$folder/$1.new" "${folder:?}/$1"
  "$program" simulate --out "$folder/$1.new" --preset "$3" --seed "$2" --moving "$4" --light "$5" --duration 6 \
    >"$folder/$1.log" 2>&1 || { cat "$folder/$1.log" >&2; exit 1; }
  echo "$simulator" >"$folder/$1.new/simulator"
  mv -- "$folder/$1.new" "$folder/$1"
}
started=$SECONDS
count=0
total=$(wc -l <<<"$chosen")
while read -r name seed world level light; do
  count=$((count + 1))
  printf '%3d of %d  %s\n' "$count" "$total" "$name" >&2
  make_one "$name" "$seed" "$world" "$level" "$light"
done <<<"$chosen"
printf '%s recordings in %s, %d s\n' "$total" "$folder" $((SECONDS - started)) >&2

if [ "$job" = run ]; then
  recordings=()
  while read -r name _; do recordings+=("$folder/$name"); done <<<"$chosen"
  PLED_VINS=$program exec "$top/scripts/accuracy.sh" --starts "${PLED_STARTS:-3}" --step 0.3 "${recordings[@]}"
fi

if [ "$job" = ablate ]; then
  while read -r name _; do echo "$name"; done <<<"$chosen" |
    xargs -P "$(nproc)" -I{} sh -c '"$1" ablate "$2/$3" --json --starts "$4" >"$2/$3.ablation.json" 2>"$2/$3.ablation.log" || { cat "$2/$3.ablation.log" >&2; exit 1; }' \
      ablate "$program" "$folder" {} "${PLED_STARTS:-1}"
  tables=()
  while read -r name _; do tables+=("$folder/$name.ablation.json"); done <<<"$chosen"
  for rows in all used; do awk -F'"' -v rows=$rows -f "$top/scripts/ablation_table.awk" "${tables[@]}"; done
fi

# Lines of `score --json`: one row an object, keys in the order that score prints them.
if [ "$job" = score ]; then
  while read -r name _; do echo "$name"; done <<<"$chosen" |
    xargs -P "$(nproc)" -I{} sh -c '"$1" score "$2/$3" --json >"$2/$3.scores.json" 2>"$2/$3.scores.log" || { cat "$2/$3.scores.log" >&2; exit 1; }' \
      score "$program" "$folder" {}
  while read -r name _; do cat "$folder/$name.scores.json"; done <<<"$chosen" | awk -F'"' '
    /"sequence"/ { sequence = $4 }
    /"mode"/ { mode = $4 }
    /"kind"/ { kind = $4 }
    /"rows"/ { rows = $4 }
    /"auc"/ {
      split($3, part, /[:,]/)
      auc = part[2]
      if (auc ~ /null/) next
      key = sequence SUBSEP kind SUBSEP rows
      if (!(key in seen)) { seen[key] = 1; order[++n] = key }
      value[key, mode] = auc + 0
      group = kind SUBSEP rows SUBSEP mode
      if (!(group in count) || auc + 0 < least[group]) least[group] = auc + 0
      sum[group] += auc; ++count[group]
    }
    function row(name, kind, set, values,   m, line) { # values[mode], of modes that have one
      line = sprintf("%-26s %-12s %-7s", name, kind, set)
      for (m = 1; m <= modes; ++m)
        line = line (mode_of[m] in values ? sprintf(" %9.3f", values[mode_of[m]]) : sprintf(" %9s", "-"))
      print line
    }
    END {
      modes = split("motion paper count geometric fused", mode_of, " ")
      printf "%-26s %-12s %-7s", "AUC of", "features", "rows"
      for (m = 1; m <= modes; ++m) printf " %9s", mode_of[m]
      printf "\n"
      for (i = 1; i <= n; ++i) {
        split(order[i], k, SUBSEP)
        split("", v)
        for (m = 1; m <= modes; ++m) if ((order[i], mode_of[m]) in value) v[mode_of[m]] = value[order[i], mode_of[m]]
        row(k[1], k[2], k[3], v)
      }
      kinds = split("image_point event_point line", kind_of, " "); sets = split("all used common", set_of, " ")
      for (a = 1; a <= kinds; ++a) for (b = 1; b <= sets; ++b) {
        split("", mean); split("", low); any = 0
        for (m = 1; m <= modes; ++m) {
          g = kind_of[a] SUBSEP set_of[b] SUBSEP mode_of[m]
          if (!count[g]) continue
          mean[mode_of[m]] = sum[g] / count[g]; low[mode_of[m]] = least[g]; any = 1
        }
        if (!any) continue
        row("mean", kind_of[a], set_of[b], mean)
        row("least", kind_of[a], set_of[b], low)
      }
    }'
fi
