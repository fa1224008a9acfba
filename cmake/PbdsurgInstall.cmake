# SPDX-License-Identifier: Apache-2.0
# An export set for each component, so that asking for core never needs the CUDA toolkit.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/pbdsurg")
get_target_property(library_type pbdsurg_core TYPE)
string(COMPARE EQUAL "${library_type}" "STATIC_LIBRARY" PBDSURG_IS_STATIC)

install(TARGETS pbdsurg_core EXPORT pbdsurgCoreTargets FILE_SET HEADERS)
install(EXPORT pbdsurgCoreTargets NAMESPACE pbdsurg:: DESTINATION "${package_dir}")
if(PBDSURG_HAS_CUDA)
  install(TARGETS pbdsurg_cuda EXPORT pbdsurgCudaTargets FILE_SET HEADERS)
  install(EXPORT pbdsurgCudaTargets NAMESPACE pbdsurg:: DESTINATION "${package_dir}")
endif()
if(PBDSURG_IS_STATIC AND PBDSURG_HAS_METIS)
  install(FILES "${PROJECT_SOURCE_DIR}/cmake/FindMETIS.cmake" DESTINATION "${package_dir}")
endif()

configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/pbdsurgConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/pbdsurgConfig.cmake" INSTALL_DESTINATION "${package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/pbdsurgConfigVersion.cmake"
  VERSION "${PROJECT_VERSION}" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/pbdsurgConfig.cmake"
              "${PROJECT_BINARY_DIR}/pbdsurgConfigVersion.cmake" DESTINATION "${package_dir}")
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")
