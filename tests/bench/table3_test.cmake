# SPDX-License-Identifier: Apache-2.0
# Runs table3 on the smallest scene and reads what it leaves behind. (A step that ends otherwise than
# it must fails the run itself.)
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")
run_table(table3 0 --quick --threads 3)

string(JSON count LENGTH "${json}" table3)
expect("rows" "${count}" 1)
foreach(key method paper_liver_tets paper_gallbladder_tets paper_fps liver_tets threads plan backend)
  string(JSON ${key} GET "${json}" table3 0 ${key})
endforeach()
expect("method" "${method}" "Kim et al.")
expect("the printed liver" "${paper_liver_tets}" 518)
expect("the printed gallbladder" "${paper_gallbladder_tets}" 108)
expect("the liver" "${liver_tets}" 519)
expect("threads" "${threads}" 3)
foreach(key gallbladder_tets membrane_links colors steps serial_ms serial_p99_ms cpu_1thread_ms cpu_ms
    cpu_p99_ms vertex_1thread_ms vertex_ms serial_steps_per_second cpu_steps_per_second)
  string(JSON value GET "${json}" table3 0 ${key})
  if(NOT value GREATER 0)
    message(SEND_ERROR "${key} is '${value}'")
  endif()
endforeach()
expect_gpu_columns(table3 0)

file(STRINGS "${FOLDER}/table3.csv" csv)
list(LENGTH csv count)
expect("lines of CSV" "${count}" 2)
