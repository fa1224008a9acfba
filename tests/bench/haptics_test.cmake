# SPDX-License-Identifier: Apache-2.0
# The servo on one tissue. Would catch a plant that does not settle, and rows that lack what the
# full table has. Times are no gate.
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")
run_table(haptics 0 --quick)

string(JSON count LENGTH "${json}" haptics)
expect("rows" "${count}" 6)
foreach(row RANGE 3)
  string(JSON metric GET "${json}" haptics ${row} metric)
  string(JSON ok GET "${json}" haptics ${row} ok)
  expect("${metric} within its limit" "${ok}" ON)
endforeach()
expect_positive(haptics 0 value limit)
expect_positive(haptics 4 value limit)
