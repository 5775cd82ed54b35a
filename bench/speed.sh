#!/usr/bin/env bash
# The README's table of speed: the default method against every mode of Embree, on the scenes of a folder, in one run a scene.
#
#   bash bench/speed.sh [FOLDER] [OUT] [THREADS]
#
# FOLDER and OUT are those of bench/scenes.sh (default out/speed); THREADS is 1. Prints Markdown: the median over the scenes, then
# each scene. Takes half a minute a scene.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=${1:-../shared/scenes}
out=${2:-out/speed}
bash bench/scenes.sh "$folder" "$out" --method best --rays primary,shadow,soft-shadow,diffuse,random --width 640 --height 480 \
  --threads "${3:-1}" --repeat 5 --check none --embree all >&2
python3 bench/speed_table.py "$out"/*.json
