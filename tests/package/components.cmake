# SPDX-License-Identifier: Apache-2.0
# A component that is not there gives a message that names it.
include("${CMAKE_CURRENT_LIST_DIR}/common.cmake")

function(expect_refusal component message)
  set(build "${WORK_DIR}/consumer_refused")
  file(REMOVE_RECURSE "${build}")
  execute_process(
    COMMAND ${CMAKE_COMMAND} -S "${CONSUMER_DIR}" -B "${build}" -G "${GENERATOR}"
            -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_PREFIX_PATH=${WORK_DIR}/installed
            -D CONSUMER_COMPONENTS=${component} -D CONSUMER_LIBRARY=pbdsurg::core
    RESULT_VARIABLE status OUTPUT_QUIET ERROR_VARIABLE errors)
  string(REGEX REPLACE "[ \n]+" " " errors "${errors}")
  if(status EQUAL 0 OR NOT errors MATCHES "${message}")
    message(FATAL_ERROR "component ${component}: expected '${message}', got ${status}: ${errors}")
  endif()
endfunction()

expect_refusal(viewer "there is no component viewer; the components of pbdsurg are core and cuda")
if(NOT HAS_CUDA)
  expect_refusal(cuda "component cuda: this pbdsurg was built without CUDA")
endif()
