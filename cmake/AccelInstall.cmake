# Installation and the package config: find_package(libaccel) gives accel::accel, with COMPONENTS cuda also accel::cuda.
option(ACCEL_INSTALL "Install the library, its headers and its package config" ${PROJECT_IS_TOP_LEVEL})
if(NOT ACCEL_INSTALL)
  return()
endif()

include(CMakePackageConfigHelpers)
set(accel_package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/libaccel")

install(TARGETS accel_accel EXPORT libaccel-targets)
install(TARGETS accel_cuda EXPORT libaccel-cuda-targets)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/libaccel" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" FILES_MATCHING PATTERN "*.h")
foreach(export libaccel-targets libaccel-cuda-targets)
  install(EXPORT ${export} NAMESPACE accel:: DESTINATION "${accel_package_dir}")
endforeach()

configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/libaccel-config.cmake.in" "${PROJECT_BINARY_DIR}/libaccel-config.cmake"
  INSTALL_DESTINATION "${accel_package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/libaccel-config-version.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/libaccel-config.cmake" "${PROJECT_BINARY_DIR}/libaccel-config-version.cmake"
  DESTINATION "${accel_package_dir}")
