# SPDX-License-Identifier: Apache-2.0
# Runs statics on one bar. Would catch a static solution that is another, and a default that is further
# from it than it is today.
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")
run_table(statics 0 --quick)

string(JSON count LENGTH "${json}" statics)
expect("rows" "${count}" 3)
foreach(row RANGE 2)
  expect_positive(statics ${row} step_ms value expected)
endforeach()
string(JSON options GET "${json}" statics 0 options)
expect("options of the first row" "${options}" "default")
# rho g L^2 / 2E is 0.883 mm; the end that is held takes some percent off
string(JSON expected GET "${json}" statics 0 expected)
if(expected LESS 0.82 OR expected GREATER 0.883)
  message(FATAL_ERROR "the static solution sags by ${expected} mm")
endif()
string(JSON error GET "${json}" statics 0 error_percent)
if(error LESS -2 OR error GREATER 2)
  message(FATAL_ERROR "the default is ${error} % off the static solution")
endif()
