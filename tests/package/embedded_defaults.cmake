# SPDX-License-Identifier: Apache-2.0
# add_subdirectory(pbdsurg) with nothing set: what belongs to pbdsurg's own developers, and CUDA,
# which would ask a host project for a toolkit, stay off.
include("${CMAKE_CURRENT_LIST_DIR}/common.cmake")
set(build "${WORK_DIR}/consumer_defaults")
file(REMOVE_RECURSE "${build}")
execute_process(COMMAND ${CMAKE_COMMAND} -S "${CONSUMER_DIR}" -B "${build}" -G "${GENERATOR}"
    -D CMAKE_CXX_COMPILER=${COMPILER} -D HELLO_SOURCE=${SOURCE_DIR}/examples/hello_tissue.cpp
    -D PBDSURG_SOURCE_DIR=${SOURCE_DIR} -D CONSUMER_LIBRARY=pbdsurg::pbdsurg
  RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE errors)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "configuring failed: ${output}${errors}")
endif()
foreach(part CUDA tests benchmarks applications)
  if(NOT output MATCHES "--   ${part}: off: PBDSURG_[A-Z_]+=OFF")
    message(FATAL_ERROR "${part} is not off in a host project that did not ask for it: ${output}")
  endif()
endforeach()
