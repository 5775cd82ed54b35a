#!/usr/bin/env bash
# Sets up, builds and runs every test: on a fresh Debian 12 machine, nothing else is needed.
#
# First a minute of fuzzing, then what runs in threads under ThreadSanitizer, then all tests under AddressSanitizer and UBSan, then
# everything in a release build, whose summary comes last.
set -euo pipefail
cd "$(dirname "$0")/.."
export CTEST_PARALLEL_LEVEL="${CTEST_PARALLEL_LEVEL:-$(nproc)}"

bash cmake/install-deps.sh --tests
[[ -z $(command -v ccache) ]] || export CMAKE_CXX_COMPILER_LAUNCHER=ccache CMAKE_CUDA_COMPILER_LAUNCHER=ccache

bash cmake/fuzz.sh 60
bash cmake/tsan.sh || [[ $? -eq 77 ]]  # 77: it has said that it cannot be run on this machine
for preset in debug release; do
  cmake --preset "$preset"
  cmake --build --preset "$preset"
  ctest --preset "$preset"
done
