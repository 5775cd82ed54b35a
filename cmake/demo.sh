#!/usr/bin/env bash
# Sets up, builds, and runs the main job on the built-in default scene: builds a structure, traces it, checks every hit. Pictures and
# numbers land in out/.
set -euo pipefail
cd "$(dirname "$0")/.."

bash cmake/install-deps.sh
[[ -z $(command -v ccache) ]] || export CMAKE_CXX_COMPILER_LAUNCHER=ccache
cmake --preset release -DACCEL_WITH_CUDA=OFF -DACCEL_BUILD_TESTS=OFF -DACCEL_BUILD_BENCH=OFF -B build/demo
cmake --build build/demo

mkdir -p out
build/demo/apps/accel-trace --image out/stadium.png --heatmap out/stadium-steps.png --diff out/stadium-verdicts.png \
  --json out/stadium.json --report out/stadium.html
echo "Pictures and numbers: out/stadium.png, out/stadium-steps.png, out/stadium-verdicts.png, out/stadium.json" >&2
echo "All of it on one page: out/stadium.html" >&2
