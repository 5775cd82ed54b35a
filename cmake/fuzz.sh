#!/usr/bin/env bash
# Fuzzes for SECONDS (60 without an argument), divided among all targets of validation/fuzz or those that are named behind it:
#
#   cmake/fuzz.sh [SECONDS [TARGET...]]
#
# Configures and builds the preset `fuzz` (clang, libFuzzer, AddressSanitizer, UBSan), only the targets and what they need, and runs
# each target with its seeds. What it finds beyond them is kept in build/fuzz/found/TARGET and goes on from there the next time; an
# input that crashes is left in build/fuzz/crashes/TARGET, and the script fails when all targets have run.
#
# The build takes some 9 minutes of one core without ccache, most of it for the methods. Where that is too much,
# `cmake/fuzz.sh SECONDS` with the targets obj, ply, ply_zst, gltf, scene and npy still builds it: the library is one target.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
targets=("${@:2}")
if [[ ${#targets[@]} -eq 0 ]]; then
  for source in validation/fuzz/*_fuzz.cpp; do
    name=$(basename "$source" _fuzz.cpp)
    targets+=("$name")
  done
fi

[[ -z $(command -v ccache) ]] || export CMAKE_CXX_COMPILER_LAUNCHER=ccache
cmake --preset fuzz
cmake --build build/fuzz --target fuzz.make_corpus "${targets[@]/#/fuzz.}"
build/fuzz/validation/fuzz/fuzz.make_corpus build/fuzz/seeds

each=$((seconds / ${#targets[@]}))
failed=()
for target in "${targets[@]}"; do
  found="build/fuzz/found/$target"
  crashes="build/fuzz/crashes/$target/"
  mkdir -p "$found" "$crashes"
  seeds=("build/fuzz/seeds/$target")
  [[ ! -d validation/fuzz/corpus/$target ]] || seeds+=("validation/fuzz/corpus/$target")
  echo "fuzzing $target for $((each > 0 ? each : 1)) s" >&2
  UBSAN_OPTIONS=print_stacktrace=1 "build/fuzz/validation/fuzz/fuzz.$target" -max_total_time=$((each > 0 ? each : 1)) -timeout=20 \
    -rss_limit_mb=4096 -max_len=20000 -print_final_stats=1 -print_funcs=0 -verbosity=0 -artifact_prefix="$crashes" "$found" "${seeds[@]}" || failed+=("$target")
done
[[ ${#failed[@]} -eq 0 ]] || { echo "error: crashes in: ${failed[*]}; see build/fuzz/crashes" >&2; exit 1; }
