# One source a method, or a few methods: the list in libaccel/registry/methods.h is read, and its lines are instantiated in files
# that include what these methods need and nothing of the others. So methods compile in parallel, and a changed traverser
# recompiles its own methods, and those that share their sources.

# accel_find_declaration(<variable> <name> <headers...>): the header that declares a type or an alias.
function(accel_find_declaration variable name)
  foreach(header IN LISTS ARGN)
    file(STRINGS "${PROJECT_SOURCE_DIR}/${header}" found REGEX "^(struct|class|using) ${name}( |$)")
    if(found)
      set(${variable} "${header}" PARENT_SCOPE)
      return()
    endif()
  endforeach()
  message(FATAL_ERROR "libaccel/registry/methods.h includes no header of build/, trace/ or packet/ that declares ${name}")
endfunction()

# accel_method_sources(<variable> <header> <function> <extension> <most>): sources that instantiate the function template of the
# header for every method; the function is given as "<return type> <name>". A source has so many methods at most, which share
# the time to read the headers; those that ask for fused operations have one each, for tests read the text of the others.
function(accel_method_sources variable header function extension most)
  set(list "${PROJECT_SOURCE_DIR}/libaccel/registry/methods.h")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${list}")
  file(STRINGS "${list}" headers REGEX "^#include \"libaccel/(build|trace|packet)/")
  list(TRANSFORM headers REPLACE "^#include \"(.*)\".*" "\\1")
  file(STRINGS "${list}" lines REGEX "^ +Method<")
  set(firsts)  # of each source: its name
  set(count 0)
  foreach(line IN LISTS lines)
    if(NOT line MATCHES "^ +Method<([A-Za-z0-9_]+), ([A-Za-z0-9_]+)>")
      message(FATAL_ERROR "libaccel/registry/methods.h: '${line}' is not Method<Builder, Traverser>, alone on its line")
    endif()
    set(builder "${CMAKE_MATCH_1}")
    set(traverser "${CMAKE_MATCH_2}")
    accel_find_declaration(builder_header ${builder} ${headers})
    accel_find_declaration(traverser_header ${traverser} ${headers})
    string(FIND "${traverser}" "Fused" fused)
    if(count EQUAL most OR (NOT fused EQUAL -1))
      set(count 0)
    endif()
    if(count EQUAL 0)
      set(first ${builder}_${traverser})
      list(APPEND firsts ${first})
    endif()
    string(APPEND content_${first} "#include \"${builder_header}\"\n#include \"${traverser_header}\"\n#include \"${header}\"\n"
      "template ${function}<accel::Method<accel::${builder}, accel::${traverser}>>();\n")
    math(EXPR count "${count} + 1")
    if(NOT fused EQUAL -1)
      set(count ${most})
    endif()
  endforeach()
  set(sources)
  foreach(first IN LISTS firsts)
    set(source "${CMAKE_CURRENT_BINARY_DIR}/methods/${first}.${extension}")
    file(CONFIGURE OUTPUT "${source}" @ONLY CONTENT "${content_${first}}")
    list(APPEND sources "${source}")
  endforeach()
  set(${variable} "${sources}" PARENT_SCOPE)
endfunction()
