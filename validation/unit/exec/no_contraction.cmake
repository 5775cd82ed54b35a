# Fails if the device code in the file PTX contracts a multiply and an add, which the watertight test does not survive.
#
# Divisions are instructions of their own in PTX (div.rn), so no fused operation is innocent here.
file(READ "${PTX}" code)
string(REGEX MATCHALL "(mul|add|sub)\\.rn\\.f32" separate "${code}")
list(LENGTH separate separate_count)
if(separate_count EQUAL 0)
  message(FATAL_ERROR "${PTX} has no single-precision arithmetic: is this device code?")
endif()
string(REGEX MATCHALL "(fma|mad)\\.[a-z.]*f(32|64)" fused "${code}")
list(LENGTH fused fused_count)
if(NOT fused_count EQUAL 0)
  message(FATAL_ERROR "${PTX} contracts ${fused_count} operations: is -fmad=false missing?")
endif()
message(STATUS "${separate_count} separate multiplications and additions, none contracted")
