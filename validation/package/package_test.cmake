# Builds a user's project around the example of the README, and runs it. MODE is find_package or add_subdirectory; of the latter, the
# user's part is built.
cmake_minimum_required(VERSION 3.25)

# The ```cpp block of the README is the program.
file(READ "${SOURCE_DIR}/README.md" readme)
string(REGEX MATCH "```cpp\n(.*)" example "${readme}")
string(FIND "${CMAKE_MATCH_1}" "```" end)
if(end EQUAL -1)
  message(FATAL_ERROR "README.md has no C++ example")
endif()
string(SUBSTRING "${CMAKE_MATCH_1}" 0 ${end} example)
file(REMOVE_RECURSE "${WORK_DIR}")
file(WRITE "${WORK_DIR}/example.cpp" "${example}")

if(MODE STREQUAL "find_package")
  execute_process(COMMAND "${CMAKE_COMMAND}" --install "${BUILD_DIR}" --prefix "${WORK_DIR}/prefix"
    OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  set(how -D "CMAKE_PREFIX_PATH=${WORK_DIR}/prefix" -D "LIBACCEL_VERSION=${VERSION}")
else()
  set(how -D "LIBACCEL_SOURCE=${SOURCE_DIR}")
endif()
execute_process(COMMAND "${CMAKE_COMMAND}" -S "${CMAKE_CURRENT_LIST_DIR}/consumer" -B "${WORK_DIR}/build" -G "${GENERATOR}"
  -D "CMAKE_CXX_COMPILER=${CXX}" -D "CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}" -D CMAKE_BUILD_TYPE=Debug -D CMAKE_CXX_FLAGS_DEBUG=-O0
  -D ACCEL_WITH_CUDA=OFF -D "EXAMPLE=${WORK_DIR}/example.cpp" ${how} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
# As a subdirectory the library would be compiled once more, which takes minutes and tells nothing: the user's sources are, and the
# rest is proved to be buildable.
if(MODE STREQUAL "add_subdirectory")
  execute_process(COMMAND "${CMAKE_COMMAND}" --build "${WORK_DIR}/build" --target user_objects COMMAND_ERROR_IS_FATAL ANY)
  # Not ninja -n: it may stop at checking globs, for it does not do what it would go on from.
  if(GENERATOR MATCHES "Ninja")
    execute_process(COMMAND "${CMAKE_COMMAND}" --build "${WORK_DIR}/build" -- -t commands OUTPUT_VARIABLE plan COMMAND_ERROR_IS_FATAL ANY)
    foreach(program device example)
      if(NOT plan MATCHES "-o ${program} ")
        message(FATAL_ERROR "the build has no plan for the user's program ${program}:\n${plan}")
      endif()
    endforeach()
  endif()
  return()
endif()
execute_process(COMMAND "${CMAKE_COMMAND}" --build "${WORK_DIR}/build" COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${WORK_DIR}/build/example" OUTPUT_VARIABLE output COMMAND_ERROR_IS_FATAL ANY)

# What the README says that the example prints.
string(REGEX MATCH "prints `([^`]*)`" stated "${readme}")
string(STRIP "${output}" output)
if(NOT output STREQUAL CMAKE_MATCH_1)
  message(FATAL_ERROR "the example prints '${output}', but README.md says '${CMAKE_MATCH_1}'")
endif()

# accel::cuda is there too, in either form, and tells the device or the reason.
execute_process(COMMAND "${WORK_DIR}/build/device" OUTPUT_VARIABLE device COMMAND_ERROR_IS_FATAL ANY)
if(NOT device MATCHES "[a-zA-Z]")
  message(FATAL_ERROR "accel::cuda does not tell the device, or why there is none")
endif()
