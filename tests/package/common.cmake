# SPDX-License-Identifier: Apache-2.0
# Shared by the scripts of this folder.
cmake_minimum_required(VERSION 3.24)

# run(command...): stops the test unless the command succeeds.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "failed with ${status}: ${command}")
  endif()
endfunction()

# build_and_run_consumer(name arguments...): the user's program from an empty folder, and a look at
# how it was compiled.
function(build_and_run_consumer name)
  set(build "${WORK_DIR}/consumer_${name}")
  file(REMOVE_RECURSE "${build}")
  run(${CMAKE_COMMAND} -S "${CONSUMER_DIR}" -B "${build}" -G "${GENERATOR}"
      -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}
      -D CMAKE_EXPORT_COMPILE_COMMANDS=ON -D HELLO_SOURCE=${SOURCE_DIR}/examples/hello_tissue.cpp
      ${ARGN})
  set(programs consumer backend backend_through_library)
  if("CONSUMER_OWN_CUDA=ON" IN_LIST ARGN)
    list(APPEND programs own_cuda)
  endif()
  run(${CMAKE_COMMAND} --build "${build}" --target hello all_headers ${programs} --parallel 2)
  foreach(program IN LISTS programs)
    run("${build}/${program}")
  endforeach()
  run("${build}/hello" "${CONSUMER_DIR}/two.vtk")

  file(STRINGS "${build}/compile_commands.json" command REGEX "\"command\".*consumer/main\\.cpp")
  if(NOT command)
    message(FATAL_ERROR "no compile command of the consumer found")
  endif()
  if(command MATCHES " (-W[a-z]|-ffp-contract|-f[a-z]+-prefix-map|-fsanitize|-DPBDSURG)")
    message(FATAL_ERROR "a private flag reaches users: ${command}")
  endif()
endfunction()
