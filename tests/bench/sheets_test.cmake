# SPDX-License-Identifier: Apache-2.0
# Runs sheets on one thread. Would catch a sheet that comes to rest elsewhere than a closed form says, by
# either method.
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")
run_table(sheets 0 --quick)

string(JSON count LENGTH "${json}" sheets)
expect("rows" "${count}" 18)
foreach(row RANGE 17)
  expect_positive(sheets ${row} value expected)
  string(JSON error GET "${json}" sheets ${row} error_percent)
  if(error GREATER 5 OR error LESS -5)
    message(SEND_ERROR "row ${row} is off by ${error} %")
  endif()
endforeach()

# Would catch a cost that is no time: of sweeps that a step leaves out, or without tetrahedra.
string(JSON count LENGTH "${json}" sheet_cost)
expect("rows" "${count}" 2)
foreach(row RANGE 1)
  expect_positive(sheet_cost ${row} tetrahedron_ns triangle bent damped without_hinge)
endforeach()
