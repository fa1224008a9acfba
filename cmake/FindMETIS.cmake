# SPDX-License-Identifier: Apache-2.0
# Finds METIS 5, the graph partitioner, and defines METIS::METIS. Linking needs the library alone;
# with COMPONENTS headers, which compiling needs, metis.h must be there too. Installed with the
# package, so that users of a static pbdsurg find what it was linked with.
find_library(METIS_LIBRARY NAMES metis libmetis.so.5)
find_path(METIS_INCLUDE_DIR metis.h)
mark_as_advanced(METIS_LIBRARY METIS_INCLUDE_DIR)
if(METIS_INCLUDE_DIR)
  set(METIS_headers_FOUND TRUE)
  file(READ "${METIS_INCLUDE_DIR}/metis.h" text)
  foreach(part MAJOR MINOR SUBMINOR)
    string(REGEX MATCH "METIS_VER_${part}[ \t]+([0-9]+)" match "${text}")
    list(APPEND version "${CMAKE_MATCH_1}")
  endforeach()
  list(JOIN version "." METIS_VERSION)
  unset(version)
  unset(text)
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(METIS REQUIRED_VARS METIS_LIBRARY
  VERSION_VAR METIS_VERSION HANDLE_COMPONENTS)

if(METIS_FOUND AND NOT TARGET METIS::METIS)
  add_library(METIS::METIS UNKNOWN IMPORTED)
  set_target_properties(METIS::METIS PROPERTIES IMPORTED_LOCATION "${METIS_LIBRARY}")
  if(METIS_INCLUDE_DIR)
    target_include_directories(METIS::METIS INTERFACE "${METIS_INCLUDE_DIR}")
  endif()
endif()
