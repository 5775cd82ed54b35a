# Every public header compiles by itself, and twice: one translation unit a header.
file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE "${PROJECT_SOURCE_DIR}" "${PROJECT_SOURCE_DIR}/libaccel/*.h")

set(units)
foreach(header IN LISTS headers)
  string(REPLACE "/" "." unit "${header}")
  set(unit "${CMAKE_CURRENT_BINARY_DIR}/headers/${unit}.cpp")
  file(CONFIGURE OUTPUT "${unit}" CONTENT "#include \"@header@\"\n#include \"@header@\"\n" @ONLY)
  list(APPEND units "${unit}")
endforeach()

add_library(accel_header_checks OBJECT ${units})
set_target_properties(accel_header_checks PROPERTIES UNITY_BUILD OFF)
accel_compile_settings(accel_header_checks)
target_link_libraries(accel_header_checks PRIVATE accel::accel)
