#!/usr/bin/env bash
# Everything that needs a GPU, in one call: build, check the device's hits against the CPU's, look for memory errors, measure.
#
#   bash bench/gpu.sh [--out DIR] [--build DIR] [--no-build] [--quick] [SCENE | RAYS.npy]...
#
#   --out DIR     where logs and gpu_trace.json go                      (default: out/gpu)
#   --build DIR   where it is built, or was with --no-build             (default: build-gpu)
#   --no-build    use the programs in the build folder as they are
#   --quick       0.3 million rays a set instead of 4.2, fewer repeats
#
# Scenes are files or builtin:NAME[:size]; ray files are traced in every scene. Only the core library is needed: no Embree and no
# OpenImageIO. Where libraries lie in unusual places, set CMAKE_PREFIX_PATH.
#
# Exit status: 0 ok, 1 a step failed, 2 usage, 3 a device answer differs from the CPU's, 5 no device or no CUDA compiler.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
out=$root/out/gpu
build=$root/build-gpu
do_build=true
trace_arguments=()

fail() {
  echo "error: $2" >&2
  exit "$1"
}

while (($# > 0)); do
  case $1 in
    --out) out=${2:?--out needs a folder} && shift 2 ;;
    --build) build=${2:?--build needs a folder} && shift 2 ;;
    --no-build) do_build=false && shift ;;
    --quick) trace_arguments+=(--size 512 --repeat 5) && shift ;;
    -h | --help) sed -n '2,/^set/s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" && exit 0 ;;
    -*) fail 2 "unknown option: $1 (see --help)" ;;
    *.npy) trace_arguments+=(--rays "$1") && shift ;;
    *) trace_arguments+=(--scene "$1") && shift ;;
  esac
done

find_nvcc() {
  command -v nvcc || { [[ -x /usr/local/cuda/bin/nvcc ]] && echo /usr/local/cuda/bin/nvcc; } || true
}

build_programs() {
  # The resource report of every kernel (registers, stack, spills) goes into the log.
  cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CUDA_COMPILER="$nvcc" \
    -DCMAKE_CUDA_ARCHITECTURES=native -DCMAKE_CUDA_FLAGS="-Xptxas=-v" \
    -DACCEL_WITH_CUDA=ON -DACCEL_WITH_EMBREE=OFF -DACCEL_WITH_OIIO=OFF || return 1
  ninja -C "$build" unit.exec.cuda_test unit.exec.cuda_primitives_test gpu_trace gpu_primitives
}

# Small enough for the sanitizer, which is some hundred times slower: every method and policy on a few thousand rays.
check_memory() {
  local sanitizer
  sanitizer=$(command -v compute-sanitizer || true)
  if [[ -z $sanitizer ]]; then
    echo "skipped: compute-sanitizer is not on PATH"
    return 0
  fi
  local tool
  for tool in memcheck racecheck synccheck; do
    echo "compute-sanitizer --tool $tool"
    "$sanitizer" --tool "$tool" --error-exitcode 1 "$cuda_test" --gtest_filter='*HitsAreTheCpus*:Cuda.Small*:Cuda.Packets*' || return 1
    "$sanitizer" --tool "$tool" --error-exitcode 1 "$primitives_test" --gtest_filter='-*TooMuchMemory*' || return 1
  done
}

mkdir -p "$out"
if command -v nvidia-smi > /dev/null; then
  nvidia-smi --query-gpu=name,driver_version,memory.total --format=csv,noheader || fail 5 "no CUDA device: nvidia-smi finds none"
else
  fail 5 "no CUDA device: there is no nvidia-smi, so no driver"
fi

cuda_test=$build/validation/unit.exec.cuda_test
primitives_test=$build/validation/unit.exec.cuda_primitives_test
gpu_trace=$build/bench/gpu_trace
gpu_primitives=$build/bench/gpu_primitives
if $do_build; then
  nvcc=$(find_nvcc)
  [[ -n $nvcc ]] || fail 5 "no CUDA compiler: put nvcc on PATH"
  echo "building in $build (log: $out/build.log)"
  build_programs > "$out/build.log" 2>&1 || { tail -n 30 "$out/build.log" >&2 && fail 1 "the build failed"; }
fi
for program in "$cuda_test" "$primitives_test" "$gpu_trace" "$gpu_primitives"; do
  [[ -x $program ]] || fail 1 "there is no $program: leave out --no-build"
done

echo "comparing the primitives with their serial twins"
"$primitives_test" > "$out/cuda_primitives_test.log" 2>&1 ||
  { tail -n 30 "$out/cuda_primitives_test.log" >&2 && fail 3 "device and CPU differ"; }
tail -n 3 "$out/cuda_primitives_test.log"

echo "comparing hits with the CPU's"
"$cuda_test" > "$out/cuda_test.log" 2>&1 || { tail -n 30 "$out/cuda_test.log" >&2 && fail 3 "device and CPU differ"; }
tail -n 3 "$out/cuda_test.log"

echo "looking for memory errors and races (log: $out/sanitizer.log)"
check_memory > "$out/sanitizer.log" 2>&1 || { tail -n 30 "$out/sanitizer.log" >&2 && fail 1 "compute-sanitizer found errors"; }
tail -n 1 "$out/sanitizer.log"

echo "measuring the primitives"
"$gpu_primitives" | tee "$out/gpu_primitives.txt"

"$gpu_trace" "${trace_arguments[@]}" --json "$out/gpu_trace.json"
echo "written: $out/gpu_trace.json"
