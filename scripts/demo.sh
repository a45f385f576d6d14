#!/usr/bin/env bash
# The main job from nothing: set-up if needed, build, make a small recording, estimate its trajectory,
# compare with the truth. Everything it writes is under build/.
#
#   scripts/demo.sh
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/common.sh

case ${1:-} in
  '') ;;
  -h | --help) sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//;p}' "${BASH_SOURCE[0]}"; exit 0 ;;
  *) printf "demo: unknown option '%s' (there are none)\n" "$1" >&2; exit 2 ;;
esac

readonly program=build/release/pled-vins
readonly recording=build/demo/recording
readonly result=build/demo/result

step() { printf '\n== %s\n' "$*"; }

step "set-up and build"
scripts/setup.sh
build_preset release --target pled-vins

step "making a recording, a car park with traffic: $recording"
rm -rf -- "$recording.new"
"$program" simulate --preset demo --out "$recording.new" --seed 3
rm -rf -- "$recording"
mv -- "$recording.new" "$recording"

step "estimating the trajectory from it"
"$program" replay "$recording" --out "$result" --force

step "comparing with the truth"
"$program" evaluate "$result/trajectory.tum" "$recording/groundtruth.txt"

step "done"
printf '%s\n' "trajectory  $result/trajectory.tum   t tx ty tz qx qy qz qw, one line a frame" \
  "features    $result/features.csv" \
  "report      $result/report.json, to look at: $result/report.html" \
  "again       $program replay $recording --out $result --force"
