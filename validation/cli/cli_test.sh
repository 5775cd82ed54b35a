#!/usr/bin/env bash
# Tests of accel-build and accel-trace as users call them: exit statuses, messages, files.
#
#   ACCEL_TRACE=... ACCEL_BUILD=... cli_test.sh NAME     runs test_NAME in a folder of its own
#
# Every test_NAME() is one ctest entry (validation/cli/CMakeLists.txt). Statuses are compared exactly, so that a crash is no error
# message; 77 means skipped.
set -u

fail() { echo "FAILED: $*"; echo "--- stdout"; head -c 2000 out; echo "--- stderr"; head -c 2000 err; exit 1; }
skip() { echo "skipped: $*"; exit 77; }

# expect STATUS COMMAND...: runs it, keeps its output in the files out and err.
expect() {
  local expected=$1 status
  shift
  "$@" >out 2>err
  status=$?
  [ "$status" -eq "$expected" ] || fail "status $status instead of $expected: $*"
}

# says FILE TEXT: the file has the text. is_silent FILE: it is empty. one_line_error: err is one line in the house's form.
says() { grep -qF -- "$2" "$1" || fail "$1 does not say: $2"; }
fits_100_columns() { [ "$(awk '{ if (length($0) > most) most = length($0) } END { print most + 0 }' "$1")" -le 100 ] || fail "a line of $1 is too long"; }
lacks() { ! grep -qF -- "$2" "$1" || fail "$1 should not say: $2"; }
is_silent() { [ ! -s "$1" ] || fail "$1 is not empty"; }
one_line_error() { [ "$(wc -l <err)" -eq 1 ] && grep -qE '^accel-(trace|build): error: ' err || fail "err is not one line of error"; }
usage_error() { expect 2 "$@"; one_line_error; is_silent out; }
input_error() { expect 1 "$@"; one_line_error; is_silent out; }

# json FILE EXPRESSION: evaluates a Python expression of the parsed file, j, and wants it to be true.
json() { python3 -c 'import json, sys; j = json.load(open(sys.argv[1])); sys.exit(0 if eval(sys.argv[2]) else 1)' "$1" "$2" || fail "$1: not $2"; }
needs_python() { command -v python3 >/dev/null || skip "python3 was not found"; }
# Whether an optional part is built in: has embree, has images.
has() { "$ACCEL_TRACE" --version | grep -E "^ *$1 " | grep -qv "not built"; }

trace() { "$ACCEL_TRACE" --threads 2 --repeat 1 --width 32 --height 24 "$@"; }
build() { "$ACCEL_BUILD" --threads 2 "$@"; }
quad() { printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n' >quad.obj; }

test_version() {
  expect 0 "$ACCEL_TRACE" --version; says out "accel-trace "; says out embree; is_silent err
  expect 0 "$ACCEL_BUILD" --version; says out "accel-build "; is_silent err
}

test_help() {
  expect 0 "$ACCEL_TRACE" --help; says out "Examples:"; says out "Exit status:"; says out --max-leaf-size
  expect 0 "$ACCEL_TRACE" scene-that-is-not-there.ply --nonsense -h; says out Usage
  expect 0 "$ACCEL_BUILD" --help; says out "Examples:"
}

test_what_follows_two_dashes_is_no_option() {
  quad; mv quad.obj ./-quad.obj
  expect 0 trace --check none -- -quad.obj; says out "2 triangles"
  usage_error trace --check none -- -quad.obj another.obj; says err "another.obj"
}

test_help_fits_100_columns() {
  for program in "$ACCEL_TRACE" "$ACCEL_BUILD"; do
    expect 0 "$program" --help
    fits_100_columns out
  done
}

test_list() {
  expect 0 "$ACCEL_TRACE" --list; says out brute/loop; says out bvh/stack; says out watertight; says out soft-shadow; says out builtin:stadium
  expect 0 "$ACCEL_BUILD" --list; says out builtin:hairball
}

test_trace_checks_every_kind() {
  expect 0 trace builtin:cornell --method all --rays primary,shadow,soft-shadow,diffuse,ao,random,edge
  for kind in primary shadow soft-shadow diffuse ao random edge; do says out "$kind"; done
  says out "all right"; lacks out WRONG
  fits_100_columns out
  is_silent err
}

# What users see first: no scene, all defaults but the size.
test_demo() {
  expect 0 trace --quiet; says out builtin:stadium
  for kind in primary shadow diffuse edge; do says out "$kind"; done
  says out "all right"; lacks out WRONG
}

test_check_exact_and_none() {
  expect 0 trace builtin:cornell --check exact --report page.html; says out "all hits judged by exact arithmetic"; lacks out Embree
  for word in itness "who was right"; do lacks out "$word"; done
  sed 's/<script.*//' page.html >words.html; lacks words.html "with the witness"; lacks words.html "Who was right"
  expect 0 trace builtin:cornell --check none; says out "not checked"; lacks out Verdicts
}

test_check_embree_status() {
  if has embree; then expect 0 trace builtin:cornell --check embree; says out "x Embree"
  else expect 5 trace builtin:cornell --check embree; one_line_error; fi
}

# Streams are Embree 3's alone.
test_embree_modes() {
  if ! has embree; then expect 5 trace builtin:cornell --embree robust; one_line_error; return; fi
  expect 0 trace builtin:cornell --rays primary,shadow --embree all; says out "x best"
  for mode in robust high packet8 packet16 packet8-m packet16-m; do says out "Embree/$mode"; done
  fits_100_columns out
  expect 0 trace builtin:cornell; lacks out "x best"; lacks out Embree/
  expect 0 trace builtin:cornell --check none --rays random --embree packet8,high; says out Embree/packet8; lacks out robust
  set -- builtin:forest:2000 --check none --rays shadow
  expect 0 trace "$@" --method instances/stack --embree all; says out Embree/packet8; says out "skipped: Embree/stream"
  expect 5 trace "$@" --method instances/stack --embree stream; one_line_error
  expect 0 trace "$@" --embree stream; says out Embree/stream
}

test_embree_modes_in_json() {
  has embree || return 0
  needs_python
  expect 0 trace builtin:cornell --rays primary,shadow --embree robust,packet8 --json -
  json out '[m["name"] for m in j["benchmarks"][0]["embree_modes"]] == ["fast", "robust", "packet8"]'
  json out 'all(set(["mrays_per_second", "mrays_min", "mrays_max", "ratio"]) <= set(m) for b in j["benchmarks"] for m in b["embree_modes"])'
  json out 'all(b["ratio_to_best_embree"] == min(m["ratio"] for m in b["embree_modes"]) for b in j["benchmarks"])'
  json out '[b["method"] for b in j["benchmarks"]][-3:] == ["Embree", "Embree/robust", "Embree/packet8"]'
}

test_triangle_tests() {
  for t in watertight moeller-trumbore woop woop-kahan pluecker baldwin-weber; do
    expect 0 trace builtin:cornell --method sbvh/stack --test $t --rays primary --check none
  done
  expect 1 trace builtin:cornell --method bvh8/ordered --test baldwin-weber --check none
  one_line_error; says err "have no room for what it precomputes"
  expect 1 trace builtin:cornell --method sbvh/stack --test woop --profile simt --check none
  one_line_error; says err "models of machines"
}

# Run time against error: everything is tried, what is promised is clean, edge rays are always among the rays.
test_sweep() {
  expect 0 "$ACCEL_TRACE" builtin:spheres:2000 --sweep --rays primary --width 48 --height 32 --count 3000 --repeat 1
  says out "Run time against error, primary rays"; says out "Run time against error, edge rays"
  says out "Advice: for this scene and primary rays, use "; fits_100_columns out
  expect 0 "$ACCEL_TRACE" builtin:spheres:2000 --sweep --rays primary --width 48 --height 32 --count 3000 --repeat 1 --json -
  json out '{b["rays_kind"] for b in j["benchmarks"]} == {"primary", "edge"}'
  json out '{"watertight", "woop", "woop-kahan", "pluecker", "moeller-trumbore", "baldwin-weber"} <= {b.get("test") for b in j["benchmarks"]}'
  json out '{"bvh8/ordered-fma", "bvh8-compact/ordered", "bvh8-byte/ordered", "bvh8-half/ordered", "Embree"} <= {b["method"] for b in j["benchmarks"]}'
  json out 'any(b["pareto"] for b in j["benchmarks"] if b["rays_kind"] == "primary")'
  json out 'all(b["error"]["per_million"] == 0 for b in j["benchmarks"] if b["promised"])'
  json out 'set(j["context"]["advice"]) == {"primary", "edge"}'
}

# How things grow with the scene: every method and Embree at every size, in the tables, the JSON and the report.
test_scaling() {
  expect 0 trace builtin:terrain:500 --method sbvh/stack,bvh8/ordered --scaling 200,2k --report out.html
  says out "Scaling, primary rays"; fits_100_columns out; says out.html "Scaling in numbers"; says out.html plot-scaling
  expect 0 trace builtin:terrain:500 --method sbvh/stack,bvh8/ordered --scaling 200,2k --json -
  json out '{"sbvh/stack", "bvh8/ordered"} <= {p["method"] for p in j["scaling"]}'
  json out 'all(p["ns_per_ray"] > 0 and p["bytes"] > 0 for p in j["scaling"])'
  json out 'len({p["triangles"] for p in j["scaling"]}) == 2'
  usage_error trace quad.obj --scaling 1k; says err "only built-in scenes"
  expect 0 trace builtin:soup:500 --method all --scaling 500,30k --rays random --count 7000 --check none
  says out "skipped: brute/loop in builtin:soup:30k"
  # Found before any work is done.
  for sizes in 1k,zwei 1k,300M 1k,; do usage_error trace builtin:terrain --scaling $sizes --hits-out hits.npy; says err "--scaling: "; done
  [ ! -e hits.npy ] || fail "an output was written"
}

test_sweep_usage() {
  usage_error trace builtin:cornell --max-error 5; says err "add --sweep"
  usage_error trace builtin:cornell --sweep --check none; says err "measures errors"
  usage_error trace builtin:cornell --sweep --profile simt; says err "one at a time"
  usage_error trace builtin:cornell --sweep --max-error -1; says err "should be a number from 0 to 1000000"
}

# Methods that are known to lose hits are for those who name them.
test_all_leaves_out_what_loses_hits() {
  expect 0 trace builtin:cornell --method all
  says out "skipped: bvh8/ordered-naive, because it is known to lose hits"
  expect 0 trace builtin:cornell --method bvh8/ordered-naive,bvh8/ordered-fma --check none
}

# Moeller-Trumbore leaks along edges: the judge must notice, say so first, and leave a bundle.
test_mismatch_is_status_3() {
  expect 3 trace builtin:spheres:20000 --test moeller-trumbore --rays edge --count 200000
  one_line_error; says err "verification failed"
  [ "$(head -n 1 out)" = "WRONG HITS" ] || fail "failures do not come first"
  says out "to reproduce: accel-repro-"
  ls accel-repro-*.txt accel-repro-*-rays.npy accel-repro-*.obj >/dev/null || fail "the repro bundle is not there"
}

# The bundle's own command finds the failures again: with the test, the scene's seed and the builds' options.
test_repro_bundle_reproduces() {
  expect 3 trace builtin:soup:3000 --seed 7 --test moeller-trumbore --rays edge --count 50000 --max-leaf-size 2 --repro "it's wrong"
  local again
  again=$(sed -n 's/^again *accel-trace //p' "it's wrong"*.txt)
  echo "$again" >again
  for option in "--seed 7" "--test moeller-trumbore" "--max-leaf-size 2"; do says again "$option"; done
  expect 3 eval "trace $again"; grep -qE "(1 ray of 1|([0-9]+) rays of \2) wrong" out || fail "not all are wrong again"
}

test_usage_errors() {
  quad
  usage_error trace --metod bvh/stack; says err "did you mean '--method'?"
  usage_error trace --method bvh/stak; says err "did you mean 'bvh/stack'?"
  usage_error trace --rays primry; says err "did you mean 'primary'?"
  usage_error trace --test waterthight; says err "did you mean 'watertight'?"
  usage_error trace --check embre; says err "did you mean 'embree'?"
  usage_error trace --embree strem; says err "did you mean 'stream'?"
  usage_error trace --embree fast,packets; says err "did you mean"
  usage_error trace builtin:stadum; says err "did you mean 'stadium'?"
  usage_error trace --sort ray-hsah; says err "did you mean 'ray-hash'?"
  usage_error trace --cell-fraction 0; says err "should be a number from"
  usage_error trace --spp; says err "--spp: its value is missing"
  usage_error trace --profile cuda; says err simt
  usage_error trace --schedule sometimes; says err while-while; says err delany
  usage_error trace --profile simt,multipas; says err "did you mean 'multipass'?"
  usage_error trace --device gpu; says err --device
  usage_error trace quad.obj another.obj; says err "another.obj"
  usage_error trace --progress maybe; says err --progress
  usage_error trace --schedule if-if; says err "add --profile"
  usage_error trace --rays-out same.npy --hits-out ./same.npy; says err "--rays-out, --hits-out"
  usage_error build quad.obj -o same.accel --json same.accel; says err "--output, --json"
  usage_error trace --quiet --verbose
  usage_error trace --rays edge --rays random; says err "--rays: is given twice"
  usage_error build quad.obj --structure bvh --structure sbvh; says err "is given twice"
  usage_error trace quad.obj --json ""; says err "--json: its value is empty"
  usage_error build quad.obj --stats --json ""; says err "--json: its value is empty"
}

# Options of what was not asked for.
test_idle_options() {
  usage_error trace builtin:cornell --check none --judge-limit 5; says err "leave out --check none"
  usage_error trace builtin:cornell --check none --repro mine; says err "leave out --check none"
  usage_error trace builtin:cornell --method sbvh/stack --packet-size 8; says err "make packets"
  usage_error trace builtin:cornell --method sbvh/stack,kdtree/stack --cell-fraction 0.1; says err "--sort"
  expect 0 trace builtin:cornell --method sbvh/stack --cell-fraction 0.1 --sort ray-hash --check none
  usage_error trace builtin:cornell --method sbvh/stack --cell-fraction 0.1 --sort morton; says err "--sort ray-hash"
  usage_error trace builtin:cornell --rays random --camera 0,0,3,0,0,0,0,1,0,45; says err "have pixels"
}

# No run writes over what it reads, nor what the next run would take for a description of the scene.
test_outputs_spare_inputs() {
  quad; cp quad.obj same.obj; ln -s same.obj link.obj
  for flag in --json --report; do usage_error trace quad.obj $flag quad.obj; says err "'quad.obj' is the scene"; done
  usage_error trace same.obj --json ./link.obj; says err "is the scene"
  usage_error build quad.obj --stats --json quad.obj; says err "is the scene"
  for name in quad.json quad.obj.json; do
    usage_error trace quad.obj --json $name; says err "cameras and light of 'quad.obj'"
    usage_error build quad.obj -o quad.accel --json $name; says err "cameras and light of 'quad.obj'"
  done
  cmp quad.obj same.obj || fail "the scene was written over"
  expect 0 trace quad.obj --rays-out rays.npy --check none; cp rays.npy same.npy
  usage_error trace quad.obj --rays rays.npy --hits-out rays.npy; says err "'rays.npy' is read"
  cmp rays.npy same.npy || fail "the rays were written over"
  expect 0 trace quad.obj --rays rays.npy --json other.json
  expect 0 build quad.obj -o stored.accel; expect 0 trace stored.accel --json stored.json
  usage_error trace stored.accel --json stored.accel; says err "is the scene"
}

# One each: apps/test/trace_options_test.cpp has all flags and all that is no number.
test_bad_numbers_name_the_flag() {
  usage_error "$ACCEL_TRACE" builtin:cornell --width 0; says err --width
  usage_error "$ACCEL_TRACE" builtin:cornell --count ''; says err --count
  usage_error trace --threads 4096; says err "from 0 to 1,024"
  usage_error trace --traversal-cost nan; says err --traversal-cost
}

test_cameras() {
  quad
  expect 0 trace quad.obj --camera -0.5,0.5,3,0.5,0.5,0,0,1,0,45
  usage_error trace quad.obj --camera 1,2,3; says err --camera
  usage_error trace quad.obj --camera 0,0,0,0,0,0,0,1,0,45; says err --camera
  usage_error trace quad.obj --camera 0,0,3,0,0,0,0,1,0,180; says err --camera
  usage_error trace quad.obj --camera 0,0,3,0,0,x,0,1,0,45; says err "'x'"
  usage_error trace quad.obj --camera 1; says err "no cameras"
  echo '{"cameras": [{"name": "door", "eye": [0.5, 0.5, 3], "at": [0.5, 0.5, 0]}]}' >quad.json
  expect 0 trace quad.obj --camera door; says out "'door'"
  expect 0 trace quad.obj --camera 1; says out "'door'"
  usage_error trace quad.obj --camera dor; says err "did you mean 'door'?"
  usage_error trace quad.obj --camera 2; says err "1 camera"
  usage_error trace quad.obj --camera 0,0,1e19,0,0,0,0,1,0,45; says err "--camera: "
  echo '{"cameras": [{"name": "door, left", "eye": [0.5, 0.5, 3], "at": [0.5, 0.5, 0]}]}' >quad.json
  expect 0 trace quad.obj --camera "door, left"; says out "'door, left'"
}

test_input_errors() {
  input_error trace nothing.ply; says err nothing.ply
  input_error trace interrupted.ply; says err interrupted.ply
  input_error trace .; says err "is a folder"
  mkdir folder.ply folder.accel; input_error trace folder.ply; says err "is a folder"; input_error trace folder.accel; says err "is a folder"
  echo 'v 0 0 0' >scene.stl; input_error trace scene.stl; says err scene.stl
  printf 'v 0 0 0\nf 1 2 9\n' >bad.obj; input_error trace bad.obj; says err bad.obj
  printf 'ply\nformat ascii 1.0\nelement vertex 99999999999\n' >bad.ply; input_error trace bad.ply; says err bad.ply
  head -c 100 /dev/zero >bad.accel; input_error trace bad.accel; says err bad.accel
  head -c 100 /dev/zero >bad.npy; input_error trace builtin:cornell --rays bad.npy; says err bad.npy
  quad; echo '{"cameras": 3}' >quad.json; input_error trace quad.obj; says err quad.json
  # Rays that are not there are found before others are traced.
  input_error trace builtin:cornell --rays primary,nothing.npy --hits-out hits.npy; says err nothing.npy
  [ ! -e hits.npy ] || fail "an output was written"
}

test_empty_and_odd_scenes() {
  printf 'v 0 0 0\n' >empty.obj; expect 0 trace empty.obj --method all --rays primary,shadow,random,edge
  printf 'v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n' >line.obj; expect 0 trace line.obj --method all --rays primary,random
  says out "1 triangle, because it has no area"
  quad; printf 'f 1 2\n' >>quad.obj
  expect 0 trace quad.obj; says out "skipped: 1 face, because it has fewer than three corners"
  expect 0 build quad.obj --stats; says out "skipped: 1 face, because it has fewer than three corners"
  printf 'v 0 0 0\nv 1 0 0\nv nan 1 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\n' >nan.obj; expect 0 trace nan.obj --method all
}

test_accel_files() {
  quad
  expect 0 build quad.obj -o quad.accel --structure bvh; says out "written to quad.accel"
  expect 0 trace quad.accel; says out bvh/stack; says out "all right"
  expect 1 trace quad.accel --method brute/loop; one_line_error; says err "--method bvh/stack"
  expect 0 trace quad.accel --method all; says out "skipped: brute/loop"
  expect 0 build quad.obj -o list.accel --for brute/loop
  expect 0 trace list.accel; says out brute/loop
  echo 'f 1 2' >>quad.obj
  expect 0 build quad.obj -o quad.accel
  expect 0 trace quad.accel; says out "skipped: 1 face, because it has fewer than three corners"
}

# A file's expected cost is that of its build, whatever the costs were.
test_accel_files_keep_their_costs() {
  needs_python
  for options in "kdtree --traversal-cost 8" "bvh --traversal-cost 4 --max-leaf-size 2" "grid --traversal-cost 10" "bvh8 --intersection-cost 5"; do
    expect 0 build builtin:soup:3000 --structure $options -o soup.accel --json built.json
    expect 0 trace soup.accel --check none --json traced.json
    json traced.json 'abs(j["benchmarks"][0]["sah_cost"] / json.load(open("built.json"))["benchmarks"][0]["sah_cost"] - 1) < 1e-6'
  done
}

# The same input and options give the same bytes, for any number of threads.
test_accel_files_are_reproducible() {
  for structure in bvh sbvh bvh8 kdtree grid; do
    expect 0 "$ACCEL_BUILD" builtin:soup:5000 --threads 1 --structure $structure -o first.accel
    expect 0 "$ACCEL_BUILD" builtin:soup:5000 --threads 1 --structure $structure -o again.accel
    expect 0 "$ACCEL_BUILD" builtin:soup:5000 --threads 3 --structure $structure -o threads.accel
    cmp first.accel again.accel || fail "$structure: the same build gives another file"
    cmp first.accel threads.accel || fail "$structure: the file depends on the number of threads"
  done
  needs_python
  expect 0 trace first.accel --check none --json -; json out 'not any("build_seconds" in b for b in j["benchmarks"])'
}

test_build_options_change_the_structure() {
  needs_python
  expect 0 build builtin:soup:5000 --structure bvh --max-leaf-size 1 --json -; json out 'len(j["benchmarks"][0]["leaf_sizes"]) == 2'
  expect 0 build builtin:soup:5000 --structure sbvh --max-duplication 0 --json -
  json out 'j["benchmarks"][0]["references"] == j["benchmarks"][0]["triangles"]'
  expect 0 build builtin:soup:5000 --structure bvh --reinsertion-rounds 2 --stats --explain --json moved.json
  says out "reinsertion: optimized in 2 rounds: "
  expect 0 build builtin:soup:5000 --structure bvh --reinsertion-rounds 0 --json unmoved.json
  json moved.json 'j["benchmarks"][0]["sah_cost"] < json.load(open("unmoved.json"))["benchmarks"][0]["sah_cost"]'
  expect 0 build builtin:soup:5000 --structure bvh8 --reinsertion-seconds 1e-6 --explain -o timed.accel
  says out "ended because time was up"
  expect 0 trace timed.accel; says out "all right"
  usage_error build builtin:soup:5000 --stats --reinsertion-rounds 1001; says err --reinsertion-rounds
  expect 0 build builtin:soup:5000 -o soup.accel
  usage_error trace soup.accel --bins 8; says err --bins
}

test_kdtrees() {
  needs_python
  expect 0 build builtin:soup:5000 --structure kdtree --stats; says out "inner nodes"; says out "a random line expects"; says out ARRAY
  says out "LEAF DEPTH"; lacks out "because"
  expect 0 build builtin:soup:5000 --structure kdtree --traversal-cost 8 --empty-bonus 0 --max-references 2 --json few.json
  expect 0 build builtin:soup:5000 --structure kdtree --json many.json
  json few.json 'j["benchmarks"][0]["inner_nodes"] < json.load(open("many.json"))["benchmarks"][0]["inner_nodes"] / 2'
  json few.json 'j["benchmarks"][0]["references"] <= 2 * 5000'
  json many.json 'set(j["benchmarks"][0]["array_bytes"]) == {"nodes", "triangles", "references"}'
  expect 0 build builtin:soup:5000 --structure kdtree --max-depth 4 --json -; json out 'j["benchmarks"][0]["depth"] == 4'
  usage_error build builtin:soup:5000 --stats --empty-bonus 1; says err --empty-bonus
  usage_error build builtin:soup:5000 --stats --max-references 0.5; says err --max-references
}

# What is left out is said; that hits are the same without it, the checks of accel-trace show.
test_explain() {
  expect 0 build builtin:soup:5000 --structure kdtree --max-references 2 --stats --explain
  says out "parents and boxes: skipped, because kdtree/stack does not read them"; says out "ropes: skipped"
  says out "splits: skipped, because they would make more references than max_references allows"
  expect 0 build builtin:soup:5000 --for kdtree/ropes --explain -o ropes.accel; says out "ropes: added, because kdtree/ropes reads them"
  expect 0 trace ropes.accel --method kdtree/ropes,kdtree/backtrack --explain --json both.json; says out "all right"
  says out "parents and boxes: added, because kdtree/backtrack reads them"; lacks out "ropes: added"
  expect 0 trace builtin:cornell --method brute/loop --explain; says out "nothing was left out"
}

test_grids() {
  needs_python
  expect 0 build builtin:soup:5000 --structure grid --stats; says out "references to 5,000 triangles"; says out "LEAF SIZE"
  expect 0 build builtin:soup:5000 --structure grid --grid-resolution 10 --json -
  json out 'j["benchmarks"][0]["resolution"] == "10 x 10 x 10"'
  expect 0 build builtin:soup:5000 --structure grid --grid-resolution 4x5x6 -o grid.accel; says out "4 x 5 x 6 cells"
  expect 0 trace grid.accel; says out grid/dda; says out "all right"
  usage_error trace builtin:soup:5000 --grid-resolution 4x5; says err NxNxN
  usage_error trace builtin:soup:5000 --grid-resolution 0; says err NxNxN
  usage_error trace builtin:soup:5000 --grid-density -1; says err --grid-density
}

test_instances() {
  expect 0 trace builtin:forest:3000 --method instances/stack,bvh8-instances/stream,sbvh/stack --rays primary,diffuse,shadow,random,edge --explain
  says out instances/stack; says out "flattened to one mesh"; says out "triangles are stored, for"
  expect 0 trace builtin:forest:3000; says out bvh8/stream
  says out "skipped: instances, because one mesh of 3,"; says out "--method bvh8-instances/stream keeps them apart"
  expect 0 trace builtin:cornell --method all --check none; says out "the scene has no instances"
  expect 0 trace builtin:cornell --method instances/stack

  printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >part.obj
  printf '{"instances": [{}, {"scale": [2, -1, 1], "rotate": [0, 1, 0, 30], "translate": [3, 0, 0]}]}' >part.json
  expect 0 trace part.obj --method all --rays primary,edge --json - --quiet; json out 'j["context"]["triangles"] == 2'
  expect 0 build part.obj --structure instances -o part.accel; expect 0 trace part.accel; says out instances/stack
  expect 0 build part.obj --structure bvh8-instances -o wide.accel; expect 0 trace wide.accel; says out bvh8-instances/stream
  expect 0 trace wide.accel --rays random --check none; says out bvh8-instances/stream
  expect 0 build part.obj --structure sbvh -o flat.accel; expect 0 trace flat.accel; says out sbvh/stack
  printf '{"instances": [{}, {"scale": 0}]}' >part.json
  input_error trace part.obj; says err "part.json: instance 2"
}

test_words_about_one() {
  printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >one.obj
  for structure in bvh kdtree grid; do
    expect 0 build one.obj --stats --structure $structure; lacks out " 1 leaves"; lacks out " 1 levels"
  done
  quad; expect 0 build quad.obj --stats --structure bvh --max-leaf-size 1; says out "1 level deep"
}

test_more_rays_than_memory() {
  expect 1 "$ACCEL_TRACE" builtin:cornell --width 65536 --height 65536 --check none; one_line_error; says err --width
}

test_corrupt_accel_files() {
  build builtin:cornell:2000 -o whole.accel --structure bvh >/dev/null || fail "no file to corrupt"
  local size offset
  size=$(stat -c %s whole.accel)
  for offset in 0 8 20 70 200 $((size / 2)) $((size - 9)); do
    cp whole.accel broken.accel
    printf '\xa5\x5a\xa5' | dd of=broken.accel bs=1 seek="$offset" conv=notrunc status=none
    cmp -s whole.accel broken.accel || { input_error trace broken.accel; says err broken.accel; }
    head -c "$offset" whole.accel >broken.accel; input_error trace broken.accel
  done
}

test_accel_build_usage() {
  quad
  usage_error build; says err scene
  usage_error build quad.obj; says err "-o"
  usage_error build quad.obj -o quad.bin; says err .accel
  usage_error build quad.obj -o quad.accel --structure bhv; says err "did you mean 'bvh'?"
  usage_error build quad.obj -o quad.accel --for bvh/stak; says err "did you mean 'bvh/stack'?"
  usage_error build quad.obj -o quad.accel --structure bvh --for brute/loop; says err contradict
  usage_error build quad.accel -o quad.accel; says err "structure already"
  expect 0 build quad.obj --stats; says out "LEAF SIZE"
}

test_accel_build_json() {
  needs_python
  expect 0 build builtin:cornell --json - ; json out 'j["benchmarks"][0]["triangles"] > 0 and j["context"]["executable"] == "accel-build"'
  expect 0 build builtin:cornell --json report.json -o c.accel; json report.json 'j["benchmarks"][0]["bytes"] > 0'
}

test_builds_are_deterministic() {
  for threads in 1 2 3; do expect 0 "$ACCEL_BUILD" builtin:soup:20000 -o $threads.accel --threads $threads; done
  # Build times are part of the files' metadata; the answers must not differ in a bit.
  for threads in 1 2 3; do expect 0 trace $threads.accel --rays random --hits-out $threads.npy --check none; done
  cmp 1.npy 2.npy && cmp 2.npy 3.npy || fail "hits depend on the number of threads"
}

# More threads than the machine has, which oneTBB warns of unless it is told.
test_many_threads() {
  expect 0 "$ACCEL_TRACE" builtin:soup:20000 --width 64 --height 64 --repeat 1 --threads 40; is_silent err; says out "40 threads"
  expect 0 "$ACCEL_BUILD" builtin:soup:20000 -o soup.accel --threads 40; is_silent err
}

test_json() {
  needs_python
  expect 0 trace builtin:cornell --method all --rays primary,shadow --json -
  json out 'set(["date", "num_cpus", "command_line", "versions", "seed", "skipped"]) <= set(j["context"])'
  json out 'all(set(["name", "method", "rays_kind", "rays", "real_time", "cpu_time", "time_unit", "mrays_per_second", "mrays_min", "mrays_max", "build_seconds", "bytes"]) <= set(b) for b in j["benchmarks"])'
  json out 'all(b["verdicts"]["miss"] == b["verdicts"]["far"] == b["verdicts"]["false"] == 0 for b in j["benchmarks"] if "verdicts" in b)'
  json out 'any("t_ulp" in b for b in j["benchmarks"])'
  json out 'j["context"]["triangle_test"] == "watertight"'
  json out '[b["method"] for b in j["benchmarks"] if b["rays_kind"] == "primary"][0] == "brute/loop"'
  if has embree; then json out 'all("ratio_to_embree" in b for b in j["benchmarks"]) and any(b["method"] == "Embree" for b in j["benchmarks"])'; fi
  expect 0 trace builtin:cornell --json report.json; says out Speed; json report.json 'len(j["benchmarks"]) >= 1'
}

checks_page() { python3 "$ACCEL_CLI_TESTS/report_page.py" "$@" >out 2>&1 || fail "the page is not as it should be"; }

test_report() {
  needs_python
  expect 0 trace builtin:cornell --method bvh/stack,grid/dda --rays primary,shadow,edge --profile simt,multipass --sort morton \
    --json run.json --report page.html
  says out Speed; is_silent err; checks_page page.html run.json
  has images && says page.html "data:image/png;base64,"
  expect 0 trace builtin:cornell --rays random --check none --report -; says out "<!DOCTYPE html>"; lacks out "Mrays/s  min"
  expect 0 trace builtin:cornell --embree all --check exact --json run.json --report page.html
  if has embree; then says page.html Embree/packet8; fi
  usage_error trace builtin:cornell --json - --report -; says err --report
}

# Names of scenes and command lines are text, whatever they look like.
test_report_of_hostile_names() {
  needs_python
  quad; mv quad.obj '"><script>alert(1)<|script>.obj'
  expect 0 trace '"><script>alert(1)<|script>.obj' --json run.json --report page.html
  lacks page.html '<script>alert'; says page.html '&quot;&gt;&lt;script&gt;alert(1)'; checks_page page.html run.json
}

# dom FILE: what a browser makes of a page, in dom.html; what its scripts complain of, among other things, in err.
dom() {
  timeout 100 chromium --headless=new --no-sandbox --disable-gpu --user-data-dir="$PWD/profile" --virtual-time-budget=20000 \
    --enable-logging=stderr --dump-dom "file://$PWD/$1" >dom.html 2>err || fail "the browser failed"
}

test_report_in_a_browser() {
  needs_python
  command -v chromium >/dev/null || skip "chromium was not found"
  expect 0 trace builtin:cornell --method bvh/stack,grid/dda,kdtree/stack --rays primary,shadow,edge --json run.json --report page.html
  sed "s/<meta charset/<meta http-equiv=\"Content-Security-Policy\" content=\"script-src 'none'\">&/" page.html >no-scripts.html
  dom no-scripts.html; says err CONSOLE
  says dom.html '<html lang="en">'; says dom.html "Plots need scripts"; says dom.html "kdtree/stack"
  "$ACCEL_TRACE" --version | grep -q "plots *Vega" || skip "no plots are built in"
  dom page.html; lacks err CONSOLE; checks_page page.html run.json dom.html
}

test_skips_are_reported() {
  expect 0 "$ACCEL_TRACE" builtin:soup:100000 --method all --width 200 --height 100 --repeat 1
  says out "skipped: brute/loop, because"
}

# It is the rays that there are whose tests are counted, whatever the picture's size.
test_skips_count_the_rays() {
  local large=("$ACCEL_TRACE" builtin:soup:1000 --method all --repeat 1 --width 640 --height 480)
  expect 0 "${large[@]}" --rays random --count 100 --rays-out rays.npy; lacks out "skipped: brute/loop"
  expect 0 "${large[@]}" --rays rays.npy; lacks out "skipped: brute/loop"
  expect 0 trace builtin:soup:30000 --method all --check none; lacks out "skipped: brute/loop"
  expect 0 trace builtin:soup:30000 --method all --check none --rays soft-shadow; says out "skipped: brute/loop"
}

test_rays_and_hits_files() {
  expect 0 trace builtin:cornell --rays diffuse --rays-out rays.npy --hits-out one.npy --check none
  expect 0 trace builtin:cornell --rays rays.npy --hits-out two.npy
  cmp one.npy two.npy || fail "the same rays have other hits"
  usage_error trace --rays-out rays.txt; says err .npy
  if python3 -c 'import numpy' 2>/dev/null; then
    python3 -c '
import numpy
rays, hits = numpy.load("rays.npy"), numpy.load("one.npy")
assert rays.shape == (len(hits), 8) and set(hits.dtype.names) == {"t", "u", "v", "prim_id"}
assert (hits["t"][hits["prim_id"] != 0xffffffff] > 0).all()' || fail "NumPy reads something else"
  fi
}

# The first of several hits is the hit that there is otherwise; a row is in order and filled up with misses.
test_several_hits_a_ray() {
  expect 0 trace builtin:soup:2000 --rays random --count 500 --hits-out one.npy --check none
  expect 0 trace builtin:soup:2000 --rays random --count 500 --hits-out four.npy --hits 4 --check none
  [ "$(wc -c <four.npy)" -gt $((500 * 4 * 16)) ] || fail "four.npy is too short"
  expect 0 trace builtin:soup:2000 --rays shadow --hits-out shadow.npy --hits 2 --check none
  usage_error trace --hits 4; says err --hits-out
  usage_error trace --hits 0 --hits-out four.npy
  if python3 -c 'import numpy' 2>/dev/null; then
    python3 -c '
import numpy
one, four = numpy.load("one.npy"), numpy.load("four.npy")
assert four.shape == (500, 4) and (four[:, 0] == one).all()
t = four["t"]
assert (t[:, 1:] >= t[:, :-1]).all() and numpy.isfinite(t[:, 3]).any() and numpy.isinf(t[four["prim_id"] == 0xffffffff]).all()
' || fail "NumPy reads something else"
  fi
}

# Shadow rays that come back from a file ask the same; of any other rays the answer is whether they hit anything.
test_query_is_the_users_choice() {
  expect 0 trace builtin:cornell --rays shadow --rays-out rays.npy --hits-out one.npy
  expect 0 trace builtin:cornell --rays rays.npy --query any --hits-out two.npy; cmp -s one.npy two.npy || fail "the answers differ"
  expect 0 trace builtin:cornell --rays rays.npy --hits-out three.npy
  ! cmp -s one.npy three.npy || fail "files are traced for closest hits unless something else is asked"
  expect 0 trace builtin:cornell --rays shadow --query closest --hits-out four.npy; cmp -s three.npy four.npy || fail "the hits differ"
}
test_query_is_in_what_is_reported() {
  needs_python
  expect 0 trace builtin:cornell --rays primary,shadow --json usual.json; lacks out "all ask for"
  json usual.json '{(r["rays_kind"], r["query"]) for r in j["benchmarks"]} == {("primary", "closest"), ("shadow", "any")}'
  expect 0 trace builtin:cornell --rays primary,shadow --query any --json any.json --report any.html; says out "all ask for any hit"
  json any.json 'all(r["query"] == "any" for r in j["benchmarks"]) and j["context"]["query"] == "any"'
  grep -q "of all rays, whether they meet anything" any.html || fail "the page does not say what is asked"
}

# Files of one name in two folders are two kinds of rays, each with its own rows.
test_rays_of_one_name() {
  needs_python
  mkdir a b
  expect 0 trace builtin:cornell --rays random --count 18 --rays-out a/x.npy --check none
  expect 0 trace builtin:cornell --rays random --count 3000 --rays-out b/x.npy --check none
  expect 0 trace builtin:cornell --rays a/x.npy,b/x.npy --method sbvh/stack --json -
  json out '{(b["rays_kind"], b["rays"]) for b in j["benchmarks"]} == {("a/x.npy", 18), ("b/x.npy", 3000)}'
  json out 'len({b["name"] for b in j["benchmarks"]}) == len(j["benchmarks"])'
  expect 0 "$ACCEL_TRACE" builtin:cornell --sweep --rays a/x.npy,random --method sbvh/stack --count 500 --repeat 1 --json -
  json out 'set(j["context"]["advice"]) == {"x.npy", "random", "edge"}'
}

test_any_hit_kinds_write_hits() { expect 0 trace builtin:cornell --rays shadow --hits-out hits.npy; [ -s hits.npy ] || fail "no hits"; }

test_pictures() {
  has images || { expect 5 trace --image view.png; one_line_error; skip "no image library"; }
  expect 0 trace builtin:cornell --image view.png --heatmap heat.png --diff diff.png
  for f in view.png heat.png diff.png; do head -c 4 $f | grep -q PNG || fail "$f is no PNG"; done
  expect 0 trace builtin:cornell --image view.exr --heatmap heat.exr --diff diff.exr --spp 3
  for f in view.exr heat.exr diff.exr; do [ "$(head -c 4 $f | od -An -tx1 | tr -d ' ')" = 762f3101 ] || fail "$f is no EXR"; done
  for name in prim_id Nx Ny Nz; do says view.exr $name; done
  says heat.exr steps
  usage_error trace --image view.bmp2; says err --image
  usage_error trace --rays random,primary --heatmap heat.png; says err --heatmap
  usage_error trace --check none --diff diff.png; says err --diff
}

test_pictures_are_deterministic() {
  has images || skip "no image library"
  for threads in 1 3; do
    expect 0 "$ACCEL_TRACE" builtin:cornell --width 40 --height 30 --spp 2 --repeat 1 --check none --threads $threads --image $threads.png
  done
  cmp 1.png 3.png || fail "the picture depends on the number of threads"
}

test_pixel_order() {
  needs_python
  ordered() { expect 0 trace builtin:cornell --spp 2 --rays primary,shadow --check none --pixel-order "$@"; }
  for order in rows z-curve; do
    ordered $order --json $order.json
    json $order.json 'j["context"]["pixel_order"] == "'$order'"'
  done
  json rows.json 'all(b[key] == c[key] for key in ("rays", "nodes_per_ray", "triangle_tests_per_ray")
    for b, c in zip(j["benchmarks"], json.load(open("z-curve.json"))["benchmarks"], strict=True))'
  ordered z-curve; says out "along a Z-curve"
  usage_error trace --rays random --pixel-order z-curve; says err "--pixel-order"
  has images || return 0
  for order in rows z-curve; do ordered $order --heatmap $order.png; done
  cmp rows.png z-curve.png || fail "the heat map depends on the order of its pixels"
}

test_simt_profile() {
  needs_python
  for schedule in while-while if-if speculative persistent; do
    expect 0 trace builtin:cornell --profile simt --schedule $schedule; says out "SIMT profile"
  done
  expect 0 trace builtin:cornell --profile simt --json -
  json out 'all(0 < b["simt"]["efficiency"] <= 1 for b in j["benchmarks"] if b["method"] != "Embree")'
}

test_sorted_rays() {
  for sort in ray-hash morton; do
    expect 0 trace builtin:cornell --method bvh/stack,brute/loop --rays primary,shadow --sort $sort
    says out "Sorted by $sort"; says out "the same"
  done
  expect 0 trace builtin:cornell --rays diffuse --sort ray-hash --cell-fraction 0.1 --json -
  says out '"sort": "ray-hash"'; says out '"different_answers": 0'
}

test_packets() {
  for packets in "--packet-size 1" "--packet-size 512 --packet-block 700 --cell-fraction 0.5"; do
    expect 0 trace builtin:cornell --method sbvh/stack,sbvh/breadth-first --rays primary,shadow $packets --json -
    says out '"max_size"'
  done
  expect 0 trace builtin:cornell --method sbvh/breadth-first --packet-size 33 --check none --hits-out packets.npy
  expect 0 trace builtin:cornell --method sbvh/stack --check none --hits-out single.npy
  cmp packets.npy single.npy || fail "hits depend on packets"
  usage_error trace builtin:cornell --packet-size 513; says err "from 1 to 512"
  usage_error trace builtin:cornell --packet-block 0; says err "--packet-block"
}

test_multipass_profile() {
  needs_python
  for schedule in delany largest-first drain; do
    expect 0 trace builtin:cornell --profile multipass --schedule $schedule; says out "Multipass profile ($schedule"
  done
  fits_100_columns out
  expect 0 trace builtin:cornell --profile multipass --compact; says out " 100 %"; lacks out "e+02"
  expect 0 trace builtin:cornell --profile simt,multipass --schedule if-if,drain --batch 100 --compact --json -
  json out 'all("simt" in b and b["multipass"]["batches"] == 8 for b in j["benchmarks"] if b["method"] != "Embree")'
  json out 'all(b["multipass"]["kernels"]["initialize"]["rays"] == 768 for b in j["benchmarks"] if b["method"] != "Embree")'
  json out 'all(b["multipass"]["utilisation"] == 1 for b in j["benchmarks"] if b["method"] != "Embree")'
}

test_heatmaps_of_counters() {
  has images || skip "no image library"
  for counter in steps down up leaves triangles boxes; do
    expect 0 trace builtin:cornell --heatmap heat-$counter.exr --heatmap-of $counter; [ -s heat-$counter.exr ] || fail "no picture of $counter"
  done
  cmp -s heat-down.exr heat-triangles.exr && fail "two counters have the same picture"
  usage_error trace --heatmap heat.png --heatmap-of triangels; says err "did you mean 'triangles'?"
}

test_judge_limit_is_reported() {
  expect 0 trace builtin:cornell --check exact --judge-limit 10
  says out "--judge-limit left"; says out "right so far"; says out "every ray is judged"; lacks out witness
}

# What the limit left out says nothing of how often hits are wrong, nor do rays that are not there.
test_rates_are_of_what_was_decided() {
  needs_python
  expect 0 trace builtin:soup --rays edge --count 20000 --test moeller-trumbore --method bvh8/ordered --check exact --judge-limit 200 --json -
  json out 'j["benchmarks"][0]["unjudged"] == 19800 and j["benchmarks"][0]["wrong_per_million_bound95"] == 15000'
  printf 'v 0 0 0\n' >empty.obj; expect 0 trace empty.obj --rays edge --check exact --report page.html; says out "–"
  expect 0 trace empty.obj --rays edge --check exact --json -; json out 'j["benchmarks"][0]["wrong_per_million_bound95"] is None'
}

test_cuda_without_device() {
  "$ACCEL_TRACE" builtin:cornell --device cuda --width 8 --height 8 --repeat 1 >out 2>err
  case $? in 0) skip "there is a device" ;; 5) one_line_error; says err cuda ;; *) fail "neither 0 nor 5" ;; esac
}

test_unwritable_outputs() {
  # Found before any work is done: before the scene, which is not there either, is looked for.
  for flag in --json --report --rays-out --hits-out; do
    expect 1 trace nothing.ply $flag no/such/folder/file.npy; one_line_error; says err no/such/folder
  done
  expect 1 build nothing.ply -o no/such/folder/file.accel; one_line_error; says err no/such/folder
  if has images; then expect 1 trace builtin:cornell --image no/such/folder/view.png; one_line_error; fi
}

test_full_disk_and_closed_pipe() {
  [ -w /dev/full ] || skip "no /dev/full"
  trace builtin:cornell >/dev/full 2>err; [ $? -eq 1 ] || fail "a full disk is no error"
  : >out; one_line_error; says err "standard output"
  { trace builtin:cornell 2>err; echo $? >status; } | true
  case "$(cat status)" in 0 | 1) ;; *) fail "a closed pipe ends with status $(cat status)" ;; esac
}

test_what_is_printed_is_not_replaced() {
  echo precious >log
  trace builtin:cornell --check none --json /dev/stdout >>log 2>err; [ $? -eq 1 ] || fail "standard output was replaced"
  : >out; one_line_error; says err "prints to"; says log precious
  trace builtin:cornell --check none --json ./log >log 2>err; [ $? -eq 1 ] || fail "standard output was replaced"
  trace builtin:cornell --check none --json /dev/stdout | grep -q benchmarks || fail "a pipe is written"
}

test_outputs_are_replaced_whole() {
  echo before >rays.npy
  expect 0 trace builtin:cornell --rays-out rays.npy
  head -c 6 rays.npy | grep -q NUMPY || fail "the file was not replaced"
  [ "$(ls -A | sort | tr '\n' ' ')" = "err out rays.npy " ] || fail "something was left behind: $(ls -A)"
}

# interrupted_by SIGNAL STATUS COMMAND...: a run that would take minutes ends at once with the signal's status and says why. The
# signal is sent when the program has had a second of work after setting its handlers: before that, however slow the machine is,
# a shell's background job ignores SIGINT.
interrupted_by() {
  local signal=$1 expected=$2 pid status caught=0
  shift 2
  "$@" >out 2>err &
  pid=$!
  while [ $((caught & 0x4002)) -ne $((0x4002)) ]; do
    sleep 0.1
    caught=0x$(awk '$1 == "SigCgt:" { print $2 }' /proc/$pid/status) || fail "it ended by itself"
  done
  sleep 1
  kill -"$signal" $pid
  wait $pid
  status=$?
  [ $status -eq "$expected" ] || fail "status $status instead of $expected"
  one_line_error; says err interrupted; is_silent out
}
interrupted_trace() {
  echo before >hits.npy
  interrupted_by "$@" "$ACCEL_TRACE" builtin:soup:50000 --method brute/loop --rays random --count 2000000 --hits-out hits.npy --check none
  [ "$(cat hits.npy)" = before ] || fail "an output was touched"
  [ "$(ls -A | sort | tr '\n' ' ')" = "err hits.npy out " ] || fail "something was left behind: $(ls -A)"
}
# In the second kind of rays, when the first kind's files are ready.
test_interrupt_leaves_all_outputs() {
  echo before >hits.npy; echo before >rays.npy
  interrupted_by INT 130 "$ACCEL_TRACE" builtin:soup:50000 --method brute/loop --rays primary,random --width 8 --height 8 --count 2000000 \
    --hits-out hits.npy --rays-out rays.npy --check none
  [ "$(cat hits.npy rays.npy)" = "$(printf 'before\nbefore')" ] || fail "an output was touched"
  [ "$(ls -A | sort | tr '\n' ' ')" = "err hits.npy out rays.npy " ] || fail "something was left behind: $(ls -A)"
}
test_interrupt_is_130() { interrupted_trace INT 130; }
test_terminate_is_143() { interrupted_trace TERM 143; }

# The signal is sent when a profile's first part is done.
test_interrupted_profiles() {
  local profile pid
  for profile in simt "multipass --batch 16384"; do
    : >err
    "$ACCEL_TRACE" builtin:soup:2000 --method bvh8/ordered --rays random --count 2000000 --repeat 1 --threads 1 --check none \
      --profile $profile --progress always >out 2>err &
    pid=$!
    until grep -qE "simulating warps|running passes" err; do kill -0 $pid 2>/dev/null || fail "it ended by itself"; sleep 0.05; done
    kill -TERM $pid
    wait $pid
    [ $? -eq 143 ] || fail "not status 143"
    says err interrupted; is_silent out
  done
}

test_interrupted_build_leaves_nothing() {
  interrupted_by TERM 143 "$ACCEL_BUILD" builtin:soup:4000000 -o soup.accel
  [ "$(ls -A | sort | tr '\n' ' ')" = "err out " ] || fail "something was left behind: $(ls -A)"
}

stress() { "$ACCEL_TRACE" stress --threads 2 "$@"; }

test_stress_list() {
  expect 0 stress --list; says out leaks/1e4; says out "  -> no leak"; says out laws/scale; is_silent err
  cp out list
  expect 0 stress --help; says out --resume; says out "Exit status:"
  [ "$(cat list out | awk '{ if (length($0) > most) most = length($0) } END { print most + 0 }')" -le 100 ] || fail "a line is too long"
}

test_stress_table() {
  expect 0 stress --case rays/vertices,geometry/empty,laws/any,leaks --method bvh8/ordered,kdtree/stack --rays 600
  for text in rays/vertices geometry/empty laws/any leaks/1e6 "2 methods" "no leak" measured ok; do says out "$text"; done
  lacks out FAIL; is_silent err
  ! has embree || says out "Embree robust"
  [ "$(awk '{ if (length($0) > most) most = length($0) } END { print most }' out)" -le 100 ] || fail "the table is wider than 100 columns"
  expect 0 stress --case rays/edges --method bvh/stack,sbvh/stack --rays 300 --witness none --verbose
  lacks out Embree; says out sbvh/stack; says out bvh/stack
}

# What is wrong where nothing is promised is worth a bundle, and no failure.
test_stress_measured_is_no_failure() {
  expect 0 stress --case rays/farther-away --method kdtree/stack --rays 20000
  lacks out "NOT AS EXPECTED"; says out "Wrong where it is measured, and nothing is promised"; says out "to reproduce: accel-stress-"
}

# Rounds depend on the seed alone: a run that goes on counts what one in one go does.
test_stress_resumes() {
  needs_python
  expect 0 stress --case leaks/1,rays/edges --method best --rays 5120 --json whole.json
  expect 0 stress --case leaks/1,rays/edges --method best --rays 1024 --resume state
  expect 0 stress --case leaks/1,rays/edges --method best --rays 5120 --resume state --json parts.json
  json parts.json 'j["stress"] == json.load(open("whole.json"))["stress"] and len(j["stress"]) >= 2'
  json parts.json 'all(r["rounds"] == 2 and r["rays"] >= 5000 for r in j["stress"] if r["engine"] == "bvh8/ordered")'
  expect 0 stress --case leaks/1,rays/edges --method best --rays 5120 --resume state --json -
  json out 'j["context"]["executable"] == "accel-trace stress" and all(r["ok"] for r in j["stress"] if "ok" in r)'
  input_error stress --case leaks/1 --rays 1024 --seed 7 --resume state; says err "seed 1"
  echo nonsense >state; input_error stress --case leaks/1 --rays 1024 --resume state; says err "state"
  echo '{"format": "accel-trace stress, 2", "seed": 1}' >state; input_error stress --case leaks/1 --resume state; says err "damaged"
}

test_stress_interrupted_leaves_a_state() {
  needs_python
  interrupted_by INT 130 "$ACCEL_TRACE" stress --case leaks --method brute/loop --rays 1e9 --resume state
  says err "--resume state"
  json state 'j["seed"] == 1 and sum(e["rays"] for e in j["entries"]) > 0'
  [ "$(ls -A | sort | tr '\n' ' ')" = "err out state " ] || fail "something was left behind: $(ls -A)"
}

test_stress_hours_end() {
  expect 0 stress --case rays/edges --method bvh/stack --hours 0.0003; says out "ok"
}

# A state in which a run has counted a failure stays one that has failed, with a status that says so.
test_stress_failure_is_status_3() {
  needs_python
  expect 0 stress --case rays/edges --method bvh/stack --rays 500 --resume state
  python3 -c 'import json; j = json.load(open("state")); j["entries"][-1]["miss"] = 2; json.dump(j, open("state", "w"))'
  expect 3 stress --case rays/edges --method bvh/stack --rays 500 --resume state
  one_line_error; says err "not as expected"; says out FAIL
  [ "$(head -n 1 out)" = "NOT AS EXPECTED" ] || fail "failures do not come first"
}

test_stress_usage() {
  usage_error stress --case leeks; says err "did you mean 'leaks'?"
  usage_error stress --method bvh/stak; says err "did you mean 'bvh/stack'?"
  usage_error stress --rays 1.5; says err --rays
  usage_error stress --rays many; says err --rays
  usage_error stress --hours 0; says err --hours
  usage_error stress --witness judge; says err --witness
  usage_error stress quad.obj; says err quad.obj
  # Only the first argument is a command; a scene of this name is a file like any other.
  quad; cp quad.obj stress.obj
  expect 0 trace ./stress.obj; says out "2 triangles"
  input_error trace ./stress; says err "./stress"
}

test_progress() {
  expect 0 trace builtin:cornell --progress always; says err "%"
  expect 0 trace builtin:cornell --progress never; is_silent err
  expect 0 trace builtin:cornell; is_silent err
}

test_color() {
  expect 0 trace builtin:cornell --color always; grep -q $'\x1b\\[' out || fail "no colour"
  expect 0 trace builtin:cornell; ! grep -q $'\x1b' out || fail "colour in a file"
}

test_quiet_and_verbose() {
  expect 0 trace builtin:cornell --verbose; [ -s err ] || fail "--verbose says nothing"
  expect 0 trace builtin:cornell --quiet; is_silent err
}

test_seed_decides_rays() {
  for seed in 1 1 2; do expect 0 trace builtin:cornell --rays random --seed $seed --rays-out $seed-$RANDOM.npy --check none; done
  [ "$(cat 1-*.npy | md5sum)" != "" ] && set -- 1-*.npy && cmp "$1" "$2" || fail "the same seed gives other rays"
  set -- 1-*.npy 2-*.npy; ! cmp -s "$1" "$3" || fail "another seed gives the same rays"
}

test_zstd_and_ply() {
  command -v zstd >/dev/null || skip "zstd was not found"
  quad; zstd -q quad.obj; rm quad.obj
  expect 0 trace quad.obj.zst; says out "2 triangles"
}

test_gltf() {
  cat >quad.gltf <<'JSON'
    {"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0.5, 0.5, 3]}],
     "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5}}],
     "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 6}]}],
     "accessors": [{"bufferView": 0, "componentType": 5121, "count": 4, "type": "VEC3"}],
     "bufferViews": [{"buffer": 0, "byteLength": 12}],
     "buffers": [{"byteLength": 12, "uri": "data:application/octet-stream;base64,AAAAAQAAAQEAAAEA"}]}
JSON
  expect 0 trace quad.gltf; says out "2 triangles"; says out "camera 'camera 1' at (0.50 0.50 3.00)"
  sed 's/"buffers": .*/"buffers": [{"byteLength": 12, "uri": "quad.bin"}]}/' quad.gltf >lost.gltf
  expect 1 trace lost.gltf; says err "lost.gltf: buffers[0].uri: quad.bin: cannot open: No such file or directory"
}

folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
: >out; : >err
"test_$1"
