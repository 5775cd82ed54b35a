# Fails if the device code in one of the files OBJECTS, which has it as text beside machine code, contracts a multiply and an add: the
# watertight test does not survive that.
#
# Operations without a rounding mode (mul.f32) may be contracted by the assembler; divisions are instructions of their own (div.rn). So
# neither fused operations nor free ones are innocent here.
foreach(file IN LISTS OBJECTS)
  file(STRINGS "${file}" contracted REGEX "(fma|mad)\\.[a-z.]*f(32|64)|(mul|add|sub)\\.f(32|64)")
  list(LENGTH contracted contracted_count)
  if(NOT contracted_count EQUAL 0)
    message(FATAL_ERROR "${file}: ${contracted_count} operations are contracted, or may be: is -fmad=false missing?")
  endif()
  file(STRINGS "${file}" rounded REGEX "(mul|add|sub)\\.rn\\.f32")
  list(LENGTH rounded rounded_count)
  if(rounded_count EQUAL 0)
    message(FATAL_ERROR "${file} has no text of single-precision arithmetic: is this device code, and not compressed?")
  endif()
  message(STATUS "${file}: ${rounded_count} multiplications and additions, each rounded on its own")
endforeach()
if(NOT OBJECTS)
  message(FATAL_ERROR "no device code to look at")
endif()
