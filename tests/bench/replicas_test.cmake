# SPDX-License-Identifier: Apache-2.0
# Runs replicas on the smallest mesh and reads what it leaves behind. How busy the machine is decides
# the rates, so none is compared.
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")
run_table(replicas 0 --quick --threads 2)

string(JSON count LENGTH "${json}" replicas)
expect("rows" "${count}" 2)
foreach(row RANGE 1)
  foreach(key tets copies threads threads_per_s processes_per_s ratio)
    string(JSON value GET "${json}" replicas ${row} ${key})
    if(NOT value GREATER 0)
      message(SEND_ERROR "${key} is '${value}'")
    endif()
  endforeach()
endforeach()
