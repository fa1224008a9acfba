# SPDX-License-Identifier: Apache-2.0
# Runs forces on one thread. Would catch a force or a gravity that tissue answers otherwise than a static
# solution or a closed form does, by any method.
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")
run_table(forces 0 --quick)

string(JSON count LENGTH "${json}" forces)
expect("rows" "${count}" 25)
foreach(row RANGE 14)  # the others are times
  expect_positive(forces ${row} value expected)
  string(JSON error GET "${json}" forces ${row} error_percent)
  if(error GREATER 1 OR error LESS -1)
    message(SEND_ERROR "row ${row} is off by ${error} %")
  endif()
endforeach()
foreach(row RANGE 15 24)
  expect_positive(forces ${row} value expected)
endforeach()
