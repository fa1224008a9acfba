# SPDX-License-Identifier: Apache-2.0
# Runs accuracy on one organ for 4 ms. Would catch a reference of another energy or time, and a solver
# that moves otherwise than it: the organ moves by a millimetre.
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")
run_table(accuracy 0 --quick --executor threads:1)

string(JSON count LENGTH "${json}" accuracy)
expect("rows" "${count}" 34)
foreach(row RANGE 33)
  expect_positive(accuracy ${row} step_ms ms error_mm tip_mm energy)
  string(JSON error GET "${json}" accuracy ${row} error_mm)
  if(error GREATER 0.4)
    message(SEND_ERROR "row ${row} is ${error} mm off")
  endif()
endforeach()
string(JSON error GET "${json}" accuracy 0 error_mm)
if(error GREATER 0.2)
  message(SEND_ERROR "the default is ${error} mm off after 4 ms of steps of 0.2 ms")
endif()
