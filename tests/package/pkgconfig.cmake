# SPDX-License-Identifier: Apache-2.0
# The README's program and one that takes the best executor, built with pkg-config alone from what
# lies under PREFIX.
include("${CMAKE_CURRENT_LIST_DIR}/common.cmake")
set(prefix "${WORK_DIR}/${PREFIX}")
find_program(PKG_CONFIG pkg-config REQUIRED)
file(GLOB_RECURSE found "${prefix}/*/pbdsurg.pc")
cmake_path(GET found PARENT_PATH folder)
cmake_path(GET folder PARENT_PATH libraries)
set(ENV{PKG_CONFIG_PATH} "${folder}:$ENV{PKG_CONFIG_PATH}")
set(ENV{LD_LIBRARY_PATH} "${libraries}:$ENV{LD_LIBRARY_PATH}")  # of a shared library

# build(program source package definitions...): compiles and links one source.
function(build program source package)
  execute_process(COMMAND "${PKG_CONFIG}" --cflags --libs ${package}
    OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  run(${COMPILER} -std=c++20 ${ARGN} "${source}" -o "${WORK_DIR}/${program}" ${flags})
endfunction()

build(hello_${PREFIX} "${SOURCE_DIR}/examples/hello_tissue.cpp" pbdsurg)
run("${WORK_DIR}/hello_${PREFIX}" "${CONSUMER_DIR}/two.vtk")
build(backend_${PREFIX} "${CONSUMER_DIR}/backend.cpp" pbdsurg -D CONSUMER_HAS_CUDA=0)
run("${WORK_DIR}/backend_${PREFIX}")
if(HAS_CUDA)
  build(cuda_${PREFIX} "${CONSUMER_DIR}/backend.cpp" pbdsurg-cuda -D CONSUMER_HAS_CUDA=1)
  run("${WORK_DIR}/cuda_${PREFIX}")
endif()
