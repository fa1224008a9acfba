# SPDX-License-Identifier: Apache-2.0
# Finds HD, the device layer of the OpenHaptics SDK, and defines OpenHaptics::HD. Neither HL nor HDU is
# looked for. The SDK is where OpenHaptics_ROOT says, or the environment's OH_SDK_BASE or 3DTOUCH_BASE,
# or in /opt, or among the system's headers and libraries, where its installer for Linux puts copies.
file(GLOB OpenHaptics_folders LIST_DIRECTORIES TRUE "/opt/OpenHaptics/Developer/*")
list(SORT OpenHaptics_folders COMPARE NATURAL ORDER DESCENDING)
set(OpenHaptics_hints "$ENV{OH_SDK_BASE}" "$ENV{3DTOUCH_BASE}")

find_path(OpenHaptics_INCLUDE_DIR HD/hd.h
  HINTS ${OpenHaptics_hints} PATHS ${OpenHaptics_folders} PATH_SUFFIXES include)
find_library(OpenHaptics_HD_LIBRARY NAMES HD hd
  HINTS ${OpenHaptics_hints} PATHS ${OpenHaptics_folders}
  PATH_SUFFIXES lib64 lib lib/x64/Release lib/x64 lib/win32/Release lib/win32)
mark_as_advanced(OpenHaptics_INCLUDE_DIR OpenHaptics_HD_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenHaptics
  REQUIRED_VARS OpenHaptics_HD_LIBRARY OpenHaptics_INCLUDE_DIR)

if(OpenHaptics_FOUND AND NOT TARGET OpenHaptics::HD)
  add_library(OpenHaptics::HD UNKNOWN IMPORTED)
  set_target_properties(OpenHaptics::HD PROPERTIES
    IMPORTED_LOCATION "${OpenHaptics_HD_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${OpenHaptics_INCLUDE_DIR}")
endif()
