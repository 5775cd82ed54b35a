#!/usr/bin/env bash
# Traces and judges every scene of a folder: 1M rays of every kind, single-threaded against Embree, each hit checked; or whatever the
# options of accel-trace say that are given instead, such as `--sweep`: run time against error of every configuration.
#
#   bash bench/scenes.sh [FOLDER] [OUT] [OPTIONS of accel-trace]
#
# FOLDER holds scenes (.ply, .obj, .gltf, .glb, each with or without .zst; default ../shared/scenes, or the built-in scenes where that
# is missing); OUT gets a report and a JSON file for each (default out/scenes), in place of those of another run. Exits 3 if any hit of
# ours is wrong, and goes on to the other scenes all the same.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

folder=${1:-$root/../shared/scenes}
out=${2:-$root/out/scenes}
given=$#
shift $(($# < 2 ? $# : 2))
options=("$@")
[[ $# -gt 0 ]] || options=(--method bvh/stack,sbvh/stack --rays primary,shadow,diffuse,random,edge --width 1000 --height 1000 --threads 1 --repeat 3)
trace=${ACCEL_TRACE:-$root/build/release/apps/accel-trace}
[[ -x $trace ]] || {
  echo "error: no $trace: build it (cmake --preset release && cmake --build --preset release), or set ACCEL_TRACE" >&2
  exit 1
}

shopt -s nullglob
scenes=("$folder"/*.{ply,obj,gltf,glb}{,.zst})
shopt -u nullglob
if [[ ${#scenes[@]} -eq 0 ]]; then
  [[ $given -eq 0 || $folder -ef $root/../shared/scenes || $folder = ../shared/scenes ]] || { echo "error: no scenes in $folder" >&2; exit 1; }
  scenes=(builtin:cornell builtin:stadium builtin:terrain builtin:hairball builtin:colonnade builtin:spheres)
fi
mkdir -p "$out"
rm -f "$out"/*.json

status=0
for scene in "${scenes[@]}"; do
  name=$(basename "${scene#builtin:}" .zst)
  name=${name%.*}
  one=0
  "$trace" "$scene" "${options[@]}" --json "$out/$name.json" >"$out/$name.txt" || one=$?
  echo "$name: exit status $one"
  [[ $one -lt 130 ]] || exit "$one"
  [[ $one -eq 0 || $status -eq 3 ]] || status=$one
done
exit "$status"
