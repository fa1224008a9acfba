# SPDX-License-Identifier: Apache-2.0
# Finds METIS 5, the graph partitioner, and defines METIS::METIS. Linking needs the library alone;
# with COMPONENTS headers, which compiling needs, metis.h must be there too. Installed with the
# package, so that users of a static pbdsurg find what it was linked with.
find_library(METIS_LIBRARY NAMES metis libmetis.so.5)
find_path(METIS_INCLUDE_DIR metis.h)
mark_as_advanced(METIS_LIBRARY METIS_INCLUDE_DIR)
if(METIS_INCLUDE_DIR)
  set(METIS_headers_FOUND TRUE)
  file(STRINGS "${METIS_INCLUDE_DIR}/metis.h" METIS_VERSION REGEX "METIS_VER_(MAJOR|MINOR|SUBMINOR)[ \t]+[0-9]")
  list(TRANSFORM METIS_VERSION REPLACE ".*[ \t]([0-9]+).*" "\\1")
  list(JOIN METIS_VERSION "." METIS_VERSION)
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
