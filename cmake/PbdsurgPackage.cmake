# SPDX-License-Identifier: Apache-2.0
# Packages, by cpack from a build folder: an archive of library, tool and demo; and for Debian
# libpbdsurg-dev with the library, pbdsurg with the programs.
set(CPACK_PACKAGE_NAME pbdsurg)
set(CPACK_PACKAGE_VENDOR pbdsurg)
set(CPACK_PACKAGE_CONTACT "The pbdsurg maintainers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_FILE_NAME "pbdsurg-${PROJECT_VERSION}-${CMAKE_SYSTEM_NAME}-${CMAKE_SYSTEM_PROCESSOR}")
set(CPACK_PACKAGE_DIRECTORY "${PROJECT_BINARY_DIR}/packages")
set(CPACK_RESOURCE_FILE_LICENSE "${PROJECT_SOURCE_DIR}/LICENSE")
set(CPACK_GENERATOR TGZ DEB)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL development)
if(PBDSURG_BUILD_APPS)
  list(APPEND CPACK_COMPONENTS_ALL programs)
endif()

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libpbdsurg-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Library, headers, and files of CMake and pkg-config")
set(depends "libeigen3-dev")
if(PBDSURG_IS_STATIC)  # what it leaves to its user's linker
  string(APPEND depends ", zlib1g-dev, libhwy-dev")
  if(PBDSURG_HAS_METIS)
    string(APPEND depends ", libmetis-dev")
  endif()
else()
  set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${PROJECT_BINARY_DIR}/lib")
  set(CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS "libpbdsurg-dev (= ${PROJECT_VERSION})")
endif()
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${depends}")

set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME pbdsurg)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_RECOMMENDS "libegl1, libgl1, libgl1-mesa-dri")  # pictures
set(CPACK_COMPONENT_PROGRAMS_DESCRIPTION "The tool pbdsurg and the demo cholecystectomy")
include(CPack)
