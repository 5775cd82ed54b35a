#!/usr/bin/env bash
# Tests the builders and executors under ThreadSanitizer: sets up, builds, runs the tests of the preset `tsan`.
#
# oneTBB as Debian ships it is not built with ThreadSanitizer, which therefore does not see that a task is finished before who
# waits for it goes on, and reports races that are none. Suppressing them would hide ours, so oneTBB is built here with the
# sanitizer, once, from Debian's source package (or from the folder TBB_SOURCE), into build/tsan-tbb.
#
# Not part of cmake/test.sh: with oneTBB, the whole library is compiled a third time, which does not fit beside the other two in the
# time of continuous integration. Run it after changes of builders or executors.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
prefix="$root/build/tsan-tbb"

# Into $1, without changing the machine's package sources.
fetch_source() {
  local apt=(-o "Dir::Etc::sourcelist=$1/sources.sources" -o Dir::Etc::sourceparts=/dev/null -o "Dir::State::lists=$1/lists")
  mkdir -p "$1/lists/partial"
  sed 's/^Types: deb$/Types: deb-src/' /etc/apt/sources.list.d/debian.sources >"$1/sources.sources"
  (cd "$1" && apt-get "${apt[@]}" update -qq && apt-get "${apt[@]}" source -qq --download-only onetbb && tar xf onetbb_*.orig.tar.*)
}

if [ ! -e "$prefix/lib/cmake/TBB/TBBConfig.cmake" ]; then
  work="$root/build/tsan-tbb-work"
  mkdir -p "$work"
  if [ -z "${TBB_SOURCE:-}" ]; then
    fetch_source "$work"
    TBB_SOURCE=$(echo "$work"/oneTBB-*)
  fi
  cmake -S "$TBB_SOURCE" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_SANITIZE=thread -DTBB_TEST=OFF \
    -DTBBMALLOC_BUILD=OFF -DTBB_STRICT=OFF -DCMAKE_INSTALL_LIBDIR=lib -DCMAKE_INSTALL_PREFIX="$prefix"
  cmake --build "$work/build" --target install
fi

cd "$root"
cmake --preset tsan
targets=$(ninja -C build/tsan -t targets all | sed -nE 's/^(unit\.(build|exec)\.[a-z0-9_]+): phony$/\1/p')
cmake --build build/tsan --target $targets
ctest --preset tsan
