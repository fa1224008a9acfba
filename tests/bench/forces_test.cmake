# SPDX-License-Identifier: Apache-2.0
# Runs forces on one thread. Would catch a force, a gravity or a lumen's pressure that tissue answers
# otherwise than a static solution or a closed form does, by any method.
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")
run_table(forces 0 --quick)

string(JSON count LENGTH "${json}" forces)
expect("rows" "${count}" 52)

# expect_within(percent first last): of rows of values; the others are times
function(expect_within percent first last)
  foreach(row RANGE ${first} ${last})
    string(JSON error GET "${json}" forces ${row} error_percent)
    if(error GREATER percent OR error LESS -${percent})
      message(SEND_ERROR "row ${row} is off by ${error} %, more than ${percent}")
    endif()
  endforeach()
endfunction()
foreach(row RANGE 51)
  expect_positive(forces ${row} value expected)
endforeach()
expect_within(1 0 14)
expect_within(3.5 25 28)  # by a mesh of 4 mm beside a closed form
expect_within(1 29 43)
expect_within(0.1 44 47)
