# Fails if the device code in one of the files PTX contracts a multiply and an add, which the watertight test does not survive.
#
# Operations without a rounding mode (mul.f32) may be contracted by the assembler; divisions are instructions of their own (div.rn). So
# neither fused operations nor free ones are innocent here.
foreach(file IN LISTS PTX)
  file(READ "${file}" code)
  string(REGEX MATCHALL "(fma|mad)\\.[a-z.]*f(32|64)|(mul|add|sub)\\.f(32|64)" contracted "${code}")
  list(LENGTH contracted contracted_count)
  if(NOT contracted_count EQUAL 0)
    message(FATAL_ERROR "${file}: ${contracted_count} operations are contracted, or may be: is -fmad=false missing?")
  endif()
  string(REGEX MATCHALL "(mul|add|sub)\\.rn\\.f32" rounded "${code}")
  list(LENGTH rounded rounded_count)
  if(rounded_count EQUAL 0)
    message(FATAL_ERROR "${file} has no single-precision arithmetic: is this device code?")
  endif()
  message(STATUS "${file}: ${rounded_count} multiplications and additions, each rounded on its own")
endforeach()
if(NOT PTX)
  message(FATAL_ERROR "no device code to look at")
endif()
