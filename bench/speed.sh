#!/usr/bin/env bash
# The README's tables of speed: the default method against every mode of Embree, on the scenes of a folder, in one run a scene; rays of
# pixels by rows, and along a Z-curve.
#
#   bash bench/speed.sh [FOLDER] [OUT] [THREADS]
#
# FOLDER and OUT are those of bench/scenes.sh (default out/speed); THREADS is 1. Prints Markdown: for each order the median over the
# scenes, then each scene. Takes a minute a scene.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

folder=${1:-$root/../shared/scenes}
out=${2:-$root/out/speed}
measure() {
  bash "$root/bench/scenes.sh" "$folder" "$out/$1" --method best --rays "$2" --pixel-order "$1" --width 640 --height 480 \
    --threads "${3:-1}" --repeat 5 --check none --embree all >&2
}
measure rows primary,shadow,soft-shadow,diffuse,random "${3:-1}"
measure z-curve primary,shadow,soft-shadow,diffuse "${3:-1}"
for order in rows z-curve; do
  printf '## Pixels: %s\n\n' "$order"
  python3 "$root/bench/speed_table.py" "$out/$order"/*.json
done
