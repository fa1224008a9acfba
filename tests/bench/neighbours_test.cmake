# SPDX-License-Identifier: Apache-2.0
# Runs neighbours on the smallest mesh and reads what it leaves behind. How busy the machine is
# decides the times, so none is compared.
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")
run_table(neighbours 0 --quick)

string(JSON count LENGTH "${json}" neighbours)
expect("rows" "${count}" 3)
foreach(row RANGE 2)
  string(JSON neighbours GET "${json}" neighbours ${row} neighbours)
  expect("neighbours" "${neighbours}" ${row})
  expect_positive(neighbours ${row} tets one_ms one_p99_ms chosen_ms chosen_p99_ms all_ms all_p99_ms
    ratio ratio_p99 steps)
endforeach()

file(STRINGS "${FOLDER}/neighbours.csv" csv)
list(LENGTH csv count)
expect("lines of CSV" "${count}" 4)
