# SPDX-License-Identifier: Apache-2.0
# Runs statics on three bars. Would catch a static solution that is another, a default that is further
# from it than it is today, and stiffness at rest that depends on the step or on the number of sweeps.
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")
run_table(statics 0 --quick)

set(cases
  "hanging bar, 20 kPa"
  "square bar of 1:6 and 20 kPa, twisted, 2 cells across"
  "standing column of 20 kPa, Poisson's ratio 0")
# row by row, of steps of 0.2 ms and else of 5 ms; the first six and the last two are within 2 % of the
# static solution
set(rows
  "default|vertex blocks"
  "default|vertex blocks"
  "half the default's sweeps|vertex blocks"
  "the default's sweeps|vertex blocks"
  "twice the default's sweeps|vertex blocks"
  "four times the default's sweeps|vertex blocks"
  "small steps, 10 x 1|projections"
  "vertex blocks, 1 x 10|vertex blocks"
  "coarse correction, 1 x 2|vertex blocks"
  "coarse correction, 4 x 2|vertex blocks")
string(JSON count LENGTH "${json}" statics)
expect("rows" "${count}" 30)
set(row 0)
foreach(case IN LISTS cases)
  set(number 0)
  foreach(text IN LISTS rows)
    expect_positive(statics ${row} step_ms seconds substeps sweeps value expected)
    string(JSON name GET "${json}" statics ${row} case)
    expect("case of row ${row}" "${name}" "${case}")
    string(JSON options GET "${json}" statics ${row} options)
    string(JSON method GET "${json}" statics ${row} method)
    expect("row ${row}" "${options}|${method}" "${text}")
    string(JSON step GET "${json}" statics ${row} step_ms)
    if((number EQUAL 0 AND NOT step LESS 1) OR (number GREATER 0 AND NOT step EQUAL 5))
      message(SEND_ERROR "row ${row} is of steps of ${step} ms")
    endif()
    string(JSON error GET "${json}" statics ${row} error_percent)
    if((number LESS 6 OR number GREATER 7) AND (error LESS -2 OR error GREATER 2))
      message(SEND_ERROR "${case}, ${text} is ${error} % off the static solution")
    endif()
    math(EXPR row "${row} + 1")
    math(EXPR number "${number} + 1")
  endforeach()
endforeach()

# rho g L^2 / 2E is 0.883 mm; the end that is held takes some percent off
string(JSON expected GET "${json}" statics 0 expected)
if(expected LESS 0.82 OR expected GREATER 0.883)
  message(FATAL_ERROR "the static solution sags by ${expected} mm")
endif()
string(JSON type TYPE "${json}" statics 0 closed_form)
expect("closed form of a bar whose end is held" "${type}" "NULL")
# two cells across are stiffer than the bar, by more than the 38 % of four; a column without
# transverse strain is exact on any mesh
string(JSON error GET "${json}" statics 10 mesh_percent)
if(error LESS 40 OR error GREATER 200)
  message(SEND_ERROR "a mesh of two cells is ${error} % stiffer in torsion")
endif()
string(JSON error GET "${json}" statics 20 mesh_percent)
if(error LESS -0.2 OR error GREATER 0.2)
  message(SEND_ERROR "a column is ${error} % off rho g L^2 / 2E")
endif()
foreach(check "in steps of 0.2 to 16 ms" "for half to four times the default's sweeps")
  if(NOT out MATCHES "met: stiffness at rest is the same within 2 % ${check}")
    message(SEND_ERROR "no word, or a bad one, on stiffness ${check}")
  endif()
endforeach()
