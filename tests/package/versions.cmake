# SPDX-License-Identifier: Apache-2.0
# Which requests for a version the installed package meets.
include("${CMAKE_CURRENT_LIST_DIR}/common.cmake")

function(expect_version is_met request)
  set(build "${WORK_DIR}/consumer_versions")
  file(REMOVE_RECURSE "${build}")
  execute_process(
    COMMAND ${CMAKE_COMMAND} -S "${CONSUMER_DIR}" -B "${build}" -G "${GENERATOR}"
            -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_PREFIX_PATH=${WORK_DIR}/installed
            -D HELLO_SOURCE=${SOURCE_DIR}/examples/hello_tissue.cpp -D CONSUMER_VERSION=${request}
            -D CONSUMER_COMPONENTS=core -D CONSUMER_LIBRARY=pbdsurg::core
    RESULT_VARIABLE status OUTPUT_QUIET ERROR_VARIABLE errors)
  if(is_met AND NOT status EQUAL 0 OR NOT is_met AND NOT errors MATCHES "version")
    message(FATAL_ERROR "version ${VERSION} and a request for ${request}: ${status} ${errors}")
  endif()
endfunction()

string(REGEX MATCH "^([0-9]+)\\.([0-9]+)" minor "${VERSION}")
math(EXPR next "${CMAKE_MATCH_2} + 1")
math(EXPR after_next "${CMAKE_MATCH_2} + 2")
set(next "${CMAKE_MATCH_1}.${next}")
set(after_next "${CMAKE_MATCH_1}.${after_next}")
expect_version(TRUE "${minor}")
expect_version(TRUE "${VERSION}")
expect_version(TRUE "${minor}...<${after_next}")
expect_version(TRUE "0.0...${VERSION}")
expect_version(FALSE "${next}")
expect_version(FALSE "${next}...<${after_next}")
expect_version(FALSE "0.0...<${VERSION}")
