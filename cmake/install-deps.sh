#!/usr/bin/env bash
# Installs the Debian 12 packages that libaccel is built from, where they are missing. As root, or through sudo. With --tests also
# the browser that looks at reports: 411 MB, of which 122 MB are fetched.
set -euo pipefail

packages=(
  g++ cmake ninja-build mold       # the build
  libtbb-dev                       # parallel loops
  libtinyobjloader-dev             # OBJ files
  libhwy-dev                       # SIMD, for the best instructions that the machine has
  libzstd-dev libxxhash-dev        # compressed scenes, checksums
  nlohmann-json3-dev               # scene descriptions, reports
  libboost-dev                     # exact arithmetic (Multiprecision)
  libcli11-dev                     # command lines
  libembree-dev                    # the witness
  libopenimageio-dev libimath-dev  # pictures
  libgtest-dev libgmock-dev        # tests
  libbenchmark-dev                 # benchmarks
  clang libclang-rt-14-dev         # fuzzing
)

# Vega-Lite, for plots in reports: unless npm is there from elsewhere, whose packages contradict Debian's.
command -v npm >/dev/null || packages+=(npm)
[[ ${1:-} != --tests ]] || packages+=(chromium)

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ $status == installed ]] || missing+=("$package")
done
if [[ ${#missing[@]} -eq 0 ]]; then
  exit 0
fi

as_root=()
if [[ $(id -u) -ne 0 ]]; then
  command -v sudo >/dev/null || { echo "error: missing packages, and neither root nor sudo: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi

echo "installing: ${missing[*]}" >&2
log=$(mktemp)
trap 'rm -f "$log"' EXIT
quietly() { "$@" >"$log" 2>&1 </dev/null || { cat "$log" >&2; exit 1; }; }
quietly "${as_root[@]}" apt-get -o DPkg::Lock::Timeout=300 update -q
quietly "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get -o DPkg::Lock::Timeout=300 install -q -y --no-install-recommends "${missing[@]}"
