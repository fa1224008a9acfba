# SPDX-License-Identifier: Apache-2.0
# find_package(pbdsurg) from what lies under PREFIX.
include("${CMAKE_CURRENT_LIST_DIR}/common.cmake")
set(prefix "${WORK_DIR}/${PREFIX}")
build_and_run_consumer(${NAME} -D CMAKE_PREFIX_PATH=${prefix}
  -D CONSUMER_COMPONENTS=core -D CONSUMER_LIBRARY=pbdsurg::core)
build_and_run_consumer(${NAME}_all -D CMAKE_PREFIX_PATH=${prefix}
  -D CONSUMER_LIBRARY=pbdsurg::pbdsurg)
if(HAS_CUDA)
  # the project enables no CUDA language
  build_and_run_consumer(${NAME}_cuda -D CMAKE_PREFIX_PATH=${prefix}
    -D CONSUMER_COMPONENTS=cuda -D CONSUMER_LIBRARY=pbdsurg::cuda)
endif()
