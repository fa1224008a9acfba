# SPDX-License-Identifier: Apache-2.0
# Runs replicas on the smallest mesh and reads what it leaves behind. How busy the machine is decides
# the rates, so none is compared.
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")
run_table(replicas 0 --quick --threads 2)

string(JSON count LENGTH "${json}" replicas)
expect("rows" "${count}" 2)
foreach(row RANGE 1)
  expect_positive(replicas ${row} tets copies threads threads_per_s processes_per_s ratio)
endforeach()
