# SPDX-License-Identifier: Apache-2.0
# Installs the build tree, and looks for the build machine in what was installed.
include("${CMAKE_CURRENT_LIST_DIR}/common.cmake")
set(prefix "${WORK_DIR}/installed")
file(REMOVE_RECURSE "${prefix}")
run(${CMAKE_COMMAND} --install "${BUILD_DIR}" --prefix "${prefix}")

file(GLOB_RECURSE files "${prefix}/*")
set(headers ${files})
list(FILTER headers INCLUDE REGEX "\\.h$")
list(LENGTH headers header_count)
if(header_count LESS 5)
  message(FATAL_ERROR "only ${header_count} headers were installed")
endif()
foreach(file IN LISTS files)
  # debug information names its sources; only a build without it is free of paths
  if(file MATCHES "\\.(a|so|so\\..*)$" AND NOT BUILD_TYPE STREQUAL "Release")
    continue()
  endif()
  file(STRINGS "${file}" found REGEX "${SOURCE_DIR}" LIMIT_COUNT 1)
  if(found)
    message(FATAL_ERROR "${file} names the folder it was built from: ${found}")
  endif()
endforeach()
