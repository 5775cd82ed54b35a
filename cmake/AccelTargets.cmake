# How the project's targets are compiled. Exported targets carry no flags that would change a user's code.

# Flags for code of this project: C++20, warnings, and no contraction of a * b + c into a fused operation, which would break the
# watertight predicates (see libaccel/geometry/watertight.h).
function(accel_compile_settings target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-ffp-contract=off -Wall -Wextra -Wshadow -Wno-missing-field-initializers>
    # GCC 12 sees overlapping copies in std::string that are none (its bug 105651).
    $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<CXX_COMPILER_ID:GNU>>:-Wno-restrict>)
  if(ACCEL_WERROR)
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Werror>)
  endif()
  if(ACCEL_SANITIZE)
    target_compile_options(${target} PUBLIC $<$<COMPILE_LANGUAGE:CXX>:-fsanitize=${ACCEL_SANITIZE} -fno-omit-frame-pointer>)
    target_link_options(${target} PUBLIC -fsanitize=${ACCEL_SANITIZE})
  endif()
endfunction()

# accel_library(<name> [sources...]): a static library with the alias accel::<name>.
function(accel_library name)
  add_library(accel_${name} STATIC ${ARGN})
  add_library(accel::${name} ALIAS accel_${name})
  set_target_properties(accel_${name} PROPERTIES EXPORT_NAME ${name} OUTPUT_NAME accel_${name})
  accel_compile_settings(accel_${name})
endfunction()

# accel_gtest(<source> LIBS <targets...> [PREFIX <prefix>]): one test program a source file; every TEST becomes a ctest entry.
function(accel_gtest source)
  cmake_parse_arguments(arg "" "PREFIX" "LIBS;LABELS" ${ARGN})
  file(RELATIVE_PATH relative "${PROJECT_SOURCE_DIR}" "${source}")
  string(REGEX REPLACE "^validation/|\\.cpp$" "" name "${relative}")
  string(REPLACE "/" "." name "${name}")
  add_executable(${name} "${source}")
  accel_compile_settings(${name})
  target_compile_definitions(${name} PRIVATE ACCEL_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(${name} PRIVATE ${arg_LIBS} GTest::gtest_main GTest::gmock)
  gtest_discover_tests(${name} TEST_PREFIX "${name}." DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300 LABELS "${arg_LABELS}")
endfunction()
