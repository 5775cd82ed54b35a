#!/usr/bin/env bash
# Run time against error: every configuration of method, triangle test, box test and node precision on the plane, and Embree's modes.
#
#   bash bench/sweep.sh [FOLDER] [OUT] [THREADS]
#
# FOLDER and OUT are those of bench/scenes.sh (default out/sweep); THREADS is 2. Prints a table of all scenes. Takes one to five minutes a scene.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

out=${2:-$root/out/sweep}
bash "$root/bench/scenes.sh" "${1:-$root/../shared/scenes}" "$out" --sweep --threads "${3:-2}" --embree robust,high >&2
python3 "$root/bench/sweep_table.py" "$out"/*.json
