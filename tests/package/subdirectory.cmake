# SPDX-License-Identifier: Apache-2.0
# add_subdirectory(pbdsurg), as a shared library without its optional parts; then its installation.
include("${CMAKE_CURRENT_LIST_DIR}/common.cmake")
build_and_run_consumer(subdirectory -D PBDSURG_SOURCE_DIR=${SOURCE_DIR}
  -D CONSUMER_LIBRARY=pbdsurg::pbdsurg -D BUILD_SHARED_LIBS=ON -D PBDSURG_INSTALL=ON
  -D PBDSURG_ENABLE_CUDA=OFF -D CMAKE_DISABLE_FIND_PACKAGE_METIS=ON)
file(REMOVE_RECURSE "${WORK_DIR}/installed_shared")
run(${CMAKE_COMMAND} --install "${WORK_DIR}/consumer_subdirectory"
    --prefix "${WORK_DIR}/installed_shared")
