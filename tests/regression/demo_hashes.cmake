# SPDX-License-Identifier: Apache-2.0
# Runs the demo as a sketch and compares its last states with demo_hashes.txt. The demo steps in fast
# mode, whose bits follow from compiler, instruction set and the processor's estimates of reciprocals;
# where one of these is not that of the file, nothing is compared, and the last line says so.
#
# With -D WRITE=ON it writes the file anew, from a build that COMPILER names:
#   cmake -D WRITE=ON -D PROGRAM=build/ci/bin/cholecystectomy -D "COMPILER=GNU 12.2.0 Release" \
#     -D FOLDER=/tmp/demo -P tests/regression/demo_hashes.cmake
cmake_minimum_required(VERSION 3.24)
set(file "${CMAKE_CURRENT_LIST_DIR}/demo_hashes.txt")
cmake_host_system_information(RESULT processor QUERY PROCESSOR_DESCRIPTION)
string(REGEX MATCH "AMD|Intel" processor "${processor}")

# run(name arguments...): appends the run's line to `actual` and leaves its executor in `backend`.
set(actual "")
function(run name)
  execute_process(
    COMMAND "${PROGRAM}" --headless --no-pictures --executor threads --time-scale 0.05 --out "${FOLDER}/${name}" ${ARGN}
    COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET ERROR_QUIET)
  file(READ "${FOLDER}/${name}/report.json" report)
  string(JSON hash GET "${report}" state_hash)
  string(JSON backend GET "${report}" backend)
  string(REGEX REPLACE ".*threads?, " "" backend "${backend}")
  set(backend "${backend}" PARENT_SCOPE)
  set(actual "${actual}${name} ${hash}\n" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE "${FOLDER}")
run(paper --seed 3 --paper)
run(seed-3 --seed 3)
run(seed-4 --seed 4)
set(machine "compiler ${COMPILER}\nprocessor ${processor}\nbackend ${backend}\n")

if(WRITE)
  file(WRITE "${file}" "# state hashes of the demo: see demo_hashes.cmake\n${machine}${actual}")
  return()
endif()
file(READ "${file}" expected)
string(REGEX REPLACE "#[^\n]*\n" "" expected "${expected}")
string(FIND "${expected}" "${machine}" place)
if(NOT place EQUAL 0)
  message("left out, since these are not those of demo_hashes.txt:\n${machine}")
  return()
endif()
if(NOT expected STREQUAL "${machine}${actual}")
  message(FATAL_ERROR "the demo ends with\n${actual}in place of\n${expected}")
endif()
