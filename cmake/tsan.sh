#!/usr/bin/env bash
# Tests what runs in threads under ThreadSanitizer: sets up, builds, runs the tests of the preset `tsan`.
#
# oneTBB as Debian ships it is not built with ThreadSanitizer, which therefore does not see that a task is finished before who
# waits for it goes on, and reports races that are none. Suppressing them would hide ours, so oneTBB is built here with the
# sanitizer, once, from Debian's source package (or from the folder TBB_SOURCE), into build/tsan-tbb.
#
# Exit status: 77 where that source cannot be had, else 0 or the failure's.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
prefix="$root/build/tsan-tbb"

# GCC 12's ThreadSanitizer cannot start where the kernel spreads addresses widely (vm.mmap_rnd_bits of 32).
if [[ -z ${ACCEL_FIXED_ADDRESSES:-} ]] && setarch --addr-no-randomize true 2>/dev/null; then
  ACCEL_FIXED_ADDRESSES=1 exec setarch --addr-no-randomize bash "$0"
fi

# Into $1, without changing the machine's package sources.
fetch_source() {
  local apt=(-o Dir::Etc::sourceparts=- -o "Dir::State::lists=$1/lists")
  mkdir -p "$1/lists/partial"
  if [[ -e /etc/apt/sources.list.d/debian.sources ]]; then
    sed 's/^Types: deb$/Types: deb-src/' /etc/apt/sources.list.d/debian.sources >"$1/source.sources"
    apt+=(-o "Dir::Etc::sourcelist=$1/source.sources")
  else
    sed -E 's/^deb(\s)/deb-src\1/' /etc/apt/sources.list >"$1/source.list"
    apt+=(-o "Dir::Etc::sourcelist=$1/source.list")
  fi
  (cd "$1" && apt-get "${apt[@]}" update -qq && apt-get "${apt[@]}" source -qq --download-only onetbb && tar xf onetbb_*.orig.tar.*)
}

if [[ ! -e $prefix/lib/cmake/TBB/TBBConfig.cmake ]]; then
  work="$root/build/tsan-tbb-work"
  mkdir -p "$work"
  if [[ -z ${TBB_SOURCE:-} ]]; then
    if ! fetch_source "$work"; then
      echo "skipped: ThreadSanitizer, because Debian's source of oneTBB cannot be fetched; TBB_SOURCE may name a folder of it" >&2
      exit 77
    fi
    TBB_SOURCE=$(echo "$work"/oneTBB-*)
  fi
  cmake -S "$TBB_SOURCE" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_SANITIZE=thread -DTBB_TEST=OFF \
    -DTBBMALLOC_BUILD=OFF -DTBB_STRICT=OFF -DCMAKE_INSTALL_LIBDIR=lib -DCMAKE_INSTALL_PREFIX="$prefix"
  cmake --build "$work/build" --target install
fi

cd "$root"
cmake --preset tsan
cmake --build --preset tsan
ctest --preset tsan
