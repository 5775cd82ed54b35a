# How the project's targets are compiled and linked. Exported targets carry no flags that would change a user's code.

# Flags for code of this project: C++20, warnings, and no contraction of a * b + c into a fused operation, which would break the
# watertight predicates (see libaccel/geometry/watertight.h).
function(accel_compile_settings target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-ffp-contract=off -Wall -Wextra -Wshadow -Wno-missing-field-initializers>
    # GCC 12 sees overlapping copies, and copies beyond the end, in std::string that are none (its bugs 105651 and 105329).
    $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<CXX_COMPILER_ID:GNU>>:-Wno-restrict -Wno-stringop-overflow -Wno-stringop-overread -Wno-array-bounds>)
  if(ACCEL_WERROR)
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Werror>)
  endif()
  if(ACCEL_SANITIZE)
    # Programs end at the first error: code that could go on takes a quarter longer to compile. So do UBSan's checks of pointers,
    # which find little here: AddressSanitizer sees null pointers where they are used, and there are next to no virtual functions.
    set(unchecked)
    if(ACCEL_SANITIZE MATCHES "undefined")
      set(unchecked -fno-sanitize=null,object-size,vptr)
    endif()
    target_compile_options(${target} PUBLIC
      "$<$<COMPILE_LANGUAGE:CXX>:-fsanitize=${ACCEL_SANITIZE};${unchecked};-fno-sanitize-recover=all;-fno-omit-frame-pointer>")
    target_link_options(${target} PUBLIC -fsanitize=${ACCEL_SANITIZE})
  endif()
  # Programs load the libraries that they call, not all that any part of ours could.
  target_link_options(${target} PRIVATE LINKER:--as-needed)
  if(ACCEL_HAVE_MOLD)
    target_link_options(${target} PRIVATE -fuse-ld=mold)
  endif()
endfunction()

# Lets a target parse the headers of the standard library and oneTBB once, instead of in every source. Targets whose code is
# generated alike, libraries or programs, share the result: the first of each kind makes it.
function(accel_precompile target kind)
  if(NOT ACCEL_PRECOMPILE_ENABLED)
    return()
  endif()
  get_property(first GLOBAL PROPERTY accel_precompiled_${kind})
  if(first)
    target_precompile_headers(${target} REUSE_FROM ${first})
  else()
    set_property(GLOBAL PROPERTY accel_precompiled_${kind} ${target})
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

set(accel_common_headers <algorithm> <array> <chrono> <cstdint> <filesystem> <functional> <map> <memory> <optional> <span> <sstream>
  <string> <vector> <tbb/blocked_range.h> <tbb/combinable.h> <tbb/parallel_for.h> <tbb/parallel_sort.h> <tbb/task_arena.h> <tbb/task_group.h>)

# For the library and the tests of its vector code, in which each of Highway's targets is compiled for itself. Processors with SSSE3
# and without SSE4, the last from 2007, run the scalar code. What sanitizers look for hardly depends on the target, and each takes
# its time to compile: with them there is AVX2, beside the scalar code.
set(accel_highway_definitions "HWY_DISABLED_TARGETS=(HWY_SSSE3)")
if(ACCEL_SANITIZE)
  set(accel_highway_definitions "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4|HWY_AVX3)")
endif()

# accel_library(<name> [sources...]): a static library with the alias accel::<name>.
function(accel_library name)
  add_library(accel_${name} STATIC ${ARGN})
  add_library(accel::${name} ALIAS accel_${name})
  set_target_properties(accel_${name} PROPERTIES EXPORT_NAME ${name} OUTPUT_NAME accel_${name})
  accel_compile_settings(accel_${name})
  # What is compiled with macros of Highway's package is of no use to those who lack them.
  set(kind libraries)
  if(name MATCHES "^(accel|cuda)$")
    set(kind core)
  endif()
  accel_precompile(accel_${name} ${kind} ${accel_common_headers})
endfunction()

# What CUDA sources are compiled with, beside the above. No contraction, on either side: the predicates need every rounding
# (libaccel/geometry/watertight.h). Pipelines are written with lambdas for the device (libaccel/exec/cuda/cuda_primitives.cuh). The
# standard is given as an option since CMake 3.25 does not know CUDA_STANDARD 20.
function(accel_cuda_settings target)
  set_target_properties(${target} PROPERTIES CUDA_SEPARABLE_COMPILATION OFF)
  target_compile_options(${target} PRIVATE
    "$<$<COMPILE_LANGUAGE:CUDA>:-std=c++20;-fmad=false;--expt-relaxed-constexpr;--extended-lambda;-Xcompiler=-ffp-contract=off,-Wall,-Wno-psabi>")
  target_link_libraries(${target} PRIVATE CUDA::cudart_static)
endfunction()

# accel_gtest(<name> SOURCES <sources...> LIBS <targets...>): a test program; every TEST becomes a ctest entry. With sanitizers a
# program takes longer to start than most tests to run: there every eighth test makes an entry together, a shard.
function(accel_gtest name)
  cmake_parse_arguments(arg "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  accel_compile_settings(${name})
  if(ACCEL_UNITY_TESTS)
    set_target_properties(${name} PROPERTIES UNITY_BUILD ON)
  endif()
  target_compile_definitions(${name} PRIVATE ACCEL_SOURCE_DIR="${PROJECT_SOURCE_DIR}" ${accel_highway_definitions})
  target_link_libraries(${name} PRIVATE ${arg_LIBS} GTest::gtest_main GTest::gmock)
  if(arg_SOURCES MATCHES "\\.cu$")
    accel_cuda_settings(${name})
  else()
    accel_precompile(${name} tests <gmock/gmock.h> <gtest/gtest.h> ${accel_common_headers})
  endif()
  if(NOT ACCEL_SANITIZE)
    gtest_discover_tests(${name} TEST_PREFIX "${name}." DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300)
    return()
  endif()
  foreach(shard RANGE 7)
    add_test(NAME ${name}.shard${shard} COMMAND ${name} --gtest_brief=1)
    set_tests_properties(${name}.shard${shard} PROPERTIES TIMEOUT 1200 ENVIRONMENT "GTEST_TOTAL_SHARDS=8;GTEST_SHARD_INDEX=${shard}")
  endforeach()
endfunction()
