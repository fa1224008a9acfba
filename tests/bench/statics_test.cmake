# SPDX-License-Identifier: Apache-2.0
# Runs statics as a sketch. What would it catch: a static solution that is not found, a table without
# rows or errors, and a default further from its static solution than it is today.
# Variables: PROGRAM, FOLDER, IS_SANITIZED.
cmake_minimum_required(VERSION 3.24)
execute_process(COMMAND "${PROGRAM}" --quick --out "${FOLDER}" RESULT_VARIABLE status OUTPUT_QUIET ERROR_QUIET)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "statics ended with ${status}")
endif()
file(READ "${FOLDER}/tables.json" tables)
string(JSON count LENGTH "${tables}" statics)
if(NOT count EQUAL 2)
  message(FATAL_ERROR "statics has ${count} rows, not 2")
endif()
string(JSON options GET "${tables}" statics 0 options)
string(JSON expected GET "${tables}" statics 0 expected)
string(JSON error GET "${tables}" statics 0 error_percent)
# rho g L^2 / 2E is 0.883 mm; ends that are held take some percent off
if(NOT options STREQUAL "default" OR expected LESS 0.82 OR expected GREATER 0.883)
  message(FATAL_ERROR "the first row is of ${options}, with a static solution of ${expected} mm")
endif()
if(error LESS -8 OR error GREATER 8)
  message(FATAL_ERROR "the default is ${error} % off the static solution")
endif()
