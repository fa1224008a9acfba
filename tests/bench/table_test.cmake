# SPDX-License-Identifier: Apache-2.0
# The head of each table's test: an empty FOLDER, and what the tests check with.
cmake_minimum_required(VERSION 3.24)  # for IN_LIST
file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}")

# expect(what value wanted)
function(expect what value wanted)
  if(NOT value STREQUAL wanted)
    message(SEND_ERROR "${what}: ${value}; ${wanted} is due")
  endif()
endfunction()

# run_table(table status arguments...): the program into FOLDER; sets out and error. Where it must
# succeed, also json, and checks that another table in tables.json stays and that the Markdown on
# stdout is that of the file.
function(run_table table status)
  if(status EQUAL 0)  # tables share the file: others stay, this one is replaced
    file(WRITE "${FOLDER}/tables.json" "{\"other\": [1], \"${table}\": [2]}")
  endif()
  execute_process(COMMAND "${PROGRAM}" ${ARGN} --out "${FOLDER}"
    RESULT_VARIABLE result OUTPUT_VARIABLE out ERROR_VARIABLE error)
  if(NOT result EQUAL status)
    message(FATAL_ERROR "${table} ended with ${result}, not ${status}: ${error}")
  endif()
  if(status EQUAL 0)
    file(READ "${FOLDER}/tables.json" json)
    string(JSON other GET "${json}" other 0)
    expect("another table" "${other}" 1)
    file(READ "${FOLDER}/${table}.md" markdown)
    expect("Markdown on stdout" "${out}" "${markdown}")
  endif()
  foreach(variable out error json)
    set(${variable} "${${variable}}" PARENT_SCOPE)
  endforeach()
endfunction()

# expect_positive(table row keys...): numbers above zero.
function(expect_positive table row)
  foreach(key IN LISTS ARGN)
    string(JSON value GET "${json}" ${table} ${row} ${key})
    if(NOT value GREATER 0)
      message(SEND_ERROR "${key} in row ${row} is '${value}'")
    endif()
  endforeach()
endfunction()

# expect_gpu_columns(table row): keys of a device are there: all filled, or none and the table says
# why. Bytes may lack on a device, too.
function(expect_gpu_columns table row)
  set(filled 0)
  set(keys gpu_ms gpu_p99_ms gpu_copy_ms gpu_copy_p99_ms gpu_stream_ms gpu_stream_p99_ms gpu_plan
    gpu_strategy gpu_is_automatic gpu_backend gpu_colors gpu_stream_colors gpu_steps gpu_watched
    gpu_from_strict stream_over_gpu cpu_over_gpu serial_over_gpu gpu_steps_per_second rate_steps
    rate_missed_1ms rate_ms rate_p99_ms rate_max_ms)
  foreach(key IN LISTS keys ITEMS gpu_gb gpu_gb_per_s)
    string(JSON type ERROR_VARIABLE missing TYPE "${json}" ${table} ${row} ${key})
    if(missing)
      message(SEND_ERROR "row ${row} has no ${key}")
    elseif(key IN_LIST keys AND NOT type STREQUAL "NULL")
      math(EXPR filled "${filled} + 1")
    endif()
  endforeach()
  list(LENGTH keys all)
  if(filled EQUAL 0)
    if(NOT out MATCHES "- no gpu columns: [a-zA-Z]")
      message(SEND_ERROR "no word on why the columns of a gpu are empty")
    endif()
  else()
    expect("columns of the gpu in row ${row}" ${filled} ${all})
  endif()
endfunction()
