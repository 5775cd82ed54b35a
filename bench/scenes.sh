#!/usr/bin/env bash
# Traces and judges every scene of a folder: 1M rays of every kind, single-threaded against Embree, each hit checked; or whatever the
# options of accel-trace say that are given instead, such as `--sweep`: run time against error of every configuration.
#
#   bash bench/scenes.sh [FOLDER] [OUT] [OPTIONS of accel-trace]
#
# FOLDER holds .ply.zst scenes (default ../shared/scenes, or the built-in scenes where it is missing); OUT gets a report and a JSON
# file for each (default out/scenes). Exits 3 if any hit of ours is wrong, and goes on to the other scenes all the same.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=${1:-../shared/scenes}
out=${2:-out/scenes}
shift $(($# < 2 ? $# : 2))
options=("$@")
[[ $# -gt 0 ]] || options=(--method bvh/stack,sbvh/stack --rays primary,shadow,diffuse,random,edge --width 1000 --height 1000 --threads 1 --repeat 3)
trace=${ACCEL_TRACE:-build/release/apps/accel-trace}
[[ -x $trace ]] || { echo "error: no $trace: build it first (cmake/demo.sh does), or set ACCEL_TRACE" >&2; exit 1; }
mkdir -p "$out"

scenes=("$folder"/*.ply.zst)
if [[ ! -e ${scenes[0]} ]]; then
  scenes=(builtin:cornell builtin:stadium builtin:terrain builtin:hairball builtin:colonnade builtin:spheres)
fi

status=0
for scene in "${scenes[@]}"; do
  name=$(basename "${scene#builtin:}" .ply.zst)
  "$trace" "$scene" "${options[@]}" --json "$out/$name.json" >"$out/$name.txt" || status=$?
  echo "$name: exit status $status"
done
exit "$status"
