#!/usr/bin/env bash
# Sets up, builds and runs every test: on a fresh Debian 12 machine, nothing else is needed.
#
# First what runs in threads under ThreadSanitizer, then all tests under AddressSanitizer and UBSan, then everything in a release
# build, whose summary comes last. Sources are compiled together where nobody will change one of them: in the release build those of
# the tests, else all. With ACCEL_DISCARD_BUILDS set, no build outlives its tests: together they take some 6 GB.
set -euo pipefail
cd "$(dirname "$0")/.."
export CTEST_PARALLEL_LEVEL="${CTEST_PARALLEL_LEVEL:-$(nproc)}"

bash cmake/install-deps.sh --tests
[[ -z $(command -v ccache) ]] || export CMAKE_CXX_COMPILER_LAUNCHER=ccache CMAKE_CUDA_COMPILER_LAUNCHER=ccache

done_with() { [[ -z ${ACCEL_DISCARD_BUILDS:-} ]] || rm -rf "build/$1"; }

bash cmake/tsan.sh || [[ $? -eq 77 ]]  # 77: it has said that it cannot be run on this machine
done_with tsan
# Where nothing runs kernels, they are compiled to PTX, and not to Hopper's machine code beside it: two fifths of their time.
[[ -e /dev/nvidiactl ]] || export CUDAARCHS="${CUDAARCHS:-75-virtual}"
for preset in debug release; do
  together=CMAKE_UNITY_BUILD
  [[ $preset != release ]] || together=ACCEL_UNITY_TESTS
  cmake --preset "$preset" -D "$together=ON"
  cmake --build --preset "$preset"
  ctest --preset "$preset"
  done_with "$preset"
done
