# SPDX-License-Identifier: Apache-2.0
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/pbdsurg")
install(TARGETS pbdsurg_core EXPORT pbdsurgCoreTargets FILE_SET HEADERS)
install(EXPORT pbdsurgCoreTargets NAMESPACE pbdsurg:: DESTINATION "${package_dir}")
if(PBDSURG_HAS_CUDA)
  # an export set of its own, so that asking for core never needs the toolkit
  install(TARGETS pbdsurg_cuda EXPORT pbdsurgCudaTargets FILE_SET HEADERS)
  install(EXPORT pbdsurgCudaTargets NAMESPACE pbdsurg:: DESTINATION "${package_dir}")
endif()

configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/pbdsurgConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/pbdsurgConfig.cmake" INSTALL_DESTINATION "${package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/pbdsurgConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/pbdsurgConfig.cmake"
              "${PROJECT_BINARY_DIR}/pbdsurgConfigVersion.cmake" DESTINATION "${package_dir}")
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")
