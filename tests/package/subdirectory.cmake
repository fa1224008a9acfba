# SPDX-License-Identifier: Apache-2.0
# add_subdirectory(pbdsurg), as a shared library without METIS, and with CUDA if this build has it, in
# a project with CUDA code of its own; then its installation.
include("${CMAKE_CURRENT_LIST_DIR}/common.cmake")
set(cuda_options -D PBDSURG_ENABLE_CUDA=OFF)
if(HAS_CUDA)
  set(cuda_options -D PBDSURG_ENABLE_CUDA=ON -D CONSUMER_OWN_CUDA=ON -D CMAKE_CUDA_COMPILER=${CUDA_COMPILER}
      -D CMAKE_CUDA_ARCHITECTURES=${CUDA_ARCHITECTURE})
endif()
build_and_run_consumer(subdirectory -D PBDSURG_SOURCE_DIR=${SOURCE_DIR}
  -D CONSUMER_LIBRARY=pbdsurg::pbdsurg -D BUILD_SHARED_LIBS=ON -D PBDSURG_INSTALL=ON -D PBDSURG_BUILD_APPS=ON
  -D CMAKE_UNITY_BUILD=${UNITY_BUILD} ${cuda_options} -D CMAKE_DISABLE_FIND_PACKAGE_METIS=ON)
# programs need all that they call to be in the shared library, and find it where they are installed
run(${CMAKE_COMMAND} --build "${WORK_DIR}/consumer_subdirectory" --target pbdsurg cholecystectomy --parallel 2)
file(REMOVE_RECURSE "${WORK_DIR}/installed_shared")
run(${CMAKE_COMMAND} --install "${WORK_DIR}/consumer_subdirectory"
    --prefix "${WORK_DIR}/installed_shared")
run("${WORK_DIR}/installed_shared/bin/cholecystectomy" --version)
run("${WORK_DIR}/installed_shared/bin/pbdsurg" mesh info "${CONSUMER_DIR}/two.vtk")
