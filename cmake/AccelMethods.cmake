# accel_method_sources(<variable> <header> <function> <extension>): sources that instantiate <function><i>() of <header>, one for
# each method i of libaccel/registry/methods.h, so that the methods compile in parallel.
function(accel_method_sources variable header function extension)
  set(list "${PROJECT_SOURCE_DIR}/libaccel/registry/methods.h")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${list}")
  file(STRINGS "${list}" methods REGEX "^ +Method<")
  list(LENGTH methods count)
  set(sources)
  math(EXPR last "${count} - 1")
  foreach(index RANGE ${last})
    set(source "${CMAKE_CURRENT_BINARY_DIR}/methods/method_${index}.${extension}")
    file(CONFIGURE OUTPUT "${source}" @ONLY CONTENT [[
#include "@header@"
static_assert(accel::Methods::size == @count@, "each method stands on a line of its own: cmake/AccelMethods.cmake counts lines");
template @function@<@index@>();
]])
    list(APPEND sources "${source}")
  endforeach()
  set(${variable} "${sources}" PARENT_SCOPE)
endfunction()
