# SPDX-License-Identifier: Apache-2.0
# An export set for each component, so that asking for core never needs the CUDA toolkit.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME development)

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
configure_file("${PROJECT_SOURCE_DIR}/cmake/pbdsurgConfigVersion.cmake.in"
  "${PROJECT_BINARY_DIR}/pbdsurgConfigVersion.cmake" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/pbdsurgConfig.cmake"
              "${PROJECT_BINARY_DIR}/pbdsurgConfigVersion.cmake" DESTINATION "${package_dir}")

# For build systems other than CMake. A static library leaves its dependencies to the user's linker.
# Paths are relative to the file, so that the installation can be moved.
function(pbdsurg_install_pkgconfig name)
  configure_file("${PROJECT_SOURCE_DIR}/cmake/${name}.pc.in" "${PROJECT_BINARY_DIR}/${name}.pc" @ONLY)
  install(FILES "${PROJECT_BINARY_DIR}/${name}.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
endfunction()
file(RELATIVE_PATH PBDSURG_TO_PREFIX "${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig" "${CMAKE_INSTALL_PREFIX}")
set(PBDSURG_PC_REQUIRES "")
set(PBDSURG_PC_LIBRARIES "")
set(PBDSURG_PC_CUDA_LIBRARIES "-lpbdsurg_cuda")
if(PBDSURG_IS_STATIC)
  set(PBDSURG_PC_REQUIRES "zlib libhwy")
  if(PBDSURG_HAS_METIS)
    string(APPEND PBDSURG_PC_LIBRARIES "-lmetis ")
  endif()
  string(APPEND PBDSURG_PC_LIBRARIES "-lpthread")
  string(APPEND PBDSURG_PC_CUDA_LIBRARIES
    " -L${CUDAToolkit_LIBRARY_DIR} -lcudart_static -ldl -lrt -lpthread")
endif()
pbdsurg_install_pkgconfig(pbdsurg)
if(PBDSURG_HAS_CUDA)
  pbdsurg_install_pkgconfig(pbdsurg-cuda)
endif()
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" "${PROJECT_SOURCE_DIR}/README.md" "${PROJECT_SOURCE_DIR}/CHANGELOG.md"
  DESTINATION "${CMAKE_INSTALL_DOCDIR}")
