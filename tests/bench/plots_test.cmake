# SPDX-License-Identifier: Apache-2.0
# Plots what other tests left in the folders of their tables.
cmake_minimum_required(VERSION 3.24)  # for IN_LIST
file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}")
foreach(table IN LISTS TABLES)
  file(GLOB files "${TABLES_FOLDER}/${table}/*.csv" "${TABLES_FOLDER}/${table}/*.png")
  file(COPY ${files} DESTINATION "${FOLDER}")
endforeach()

# run_plots(status folder...): sets out and error.
function(run_plots status)
  execute_process(COMMAND "${SCRIPT}" ${ARGN}
    RESULT_VARIABLE result OUTPUT_VARIABLE out ERROR_VARIABLE error)
  if(NOT result EQUAL status)
    message(FATAL_ERROR "scripts/plots ${ARGN} ended with ${result}, not ${status}: ${out} ${error}")
  endif()
  foreach(variable out error)
    set(${variable} "${${variable}}" PARENT_SCOPE)
  endforeach()
endfunction()

run_plots(0 "${FOLDER}")
if(out MATCHES "no plots: gnuplot is not installed")
  message("${out}")  # skips the test
  return()
endif()
if(NOT error STREQUAL "")
  message(SEND_ERROR "gnuplot complains: ${error}")
endif()

# expect_picture(name width height least_bytes): would catch a picture that is missing, cut off or empty.
function(expect_picture name width height least_bytes)
  if(NOT EXISTS "${FOLDER}/${name}")
    message(FATAL_ERROR "there is no ${name}: ${out}")
  endif()
  file(READ "${FOLDER}/${name}" head LIMIT 24 HEX)
  string(REGEX MATCH "^89504e470d0a1a0a0000000d49484452(........)(........)$" matched "${head}")
  math(EXPR actual_width "0x${CMAKE_MATCH_1}")
  math(EXPR actual_height "0x${CMAKE_MATCH_2}")
  file(SIZE "${FOLDER}/${name}" bytes)
  if(NOT actual_width EQUAL width OR NOT actual_height EQUAL height OR bytes LESS least_bytes)
    message(SEND_ERROR "${name} is ${actual_width} x ${actual_height} in ${bytes} bytes; \
${width} x ${height} and ${least_bytes} bytes or more are due")
  endif()
endfunction()
foreach(dt 1 2 5)
  expect_picture(convergence_${dt}ms.png 1900 640 40000)
endforeach()
foreach(away 0 1)
  expect_picture(accuracy_organ_of_10_kPa_table2_2_${away}_0.png 2200 640 20000)
endforeach()
expect_picture(table1_hollow.png 1900 640 40000)
expect_picture(figure12.png 1500 640 10000)
if(EXISTS "${FOLDER}/figure8_pictures.csv")  # where this machine can draw
  expect_picture(figure8_hollow.png 2400 2384 40000)
endif()
if(EXISTS "${FOLDER}/figure4_pictures.csv")
  expect_picture(figure4.png 2880 1664 40000)
endif()

# refuse(what folder): with a message that says what.
function(refuse what)
  run_plots(1 ${ARGN})
  if(NOT error MATCHES "${what}")
    message(SEND_ERROR "scripts/plots ${ARGN} says '${error}', not '${what}'")
  endif()
endfunction()
refuse("expected one folder")
refuse("nowhere: is no folder" "${FOLDER}/nowhere")
refuse("convergence.csv: is no folder" "${FOLDER}/convergence.csv")

# refuse_table(what name text): a folder with this table alone.
function(refuse_table what name text)
  file(REMOVE_RECURSE "${FOLDER}/bad")
  file(WRITE "${FOLDER}/bad/${name}" "${text}")
  refuse("${what}" "${FOLDER}/bad")
  file(GLOB pictures "${FOLDER}/bad/*.png*")
  if(pictures)
    message(SEND_ERROR "of a bad ${name} it draws ${pictures}")
  endif()
endfunction()
set(header "dt_ms,curve,method,best,ms,residual")
refuse_table("convergence.csv: has no column tip_error" convergence.csv "${header}\n1,step,sweeps,,1,1\n")
refuse_table("convergence.csv: has no rows" convergence.csv "${header},tip_error\n")
refuse_table("convergence.csv: line 2 has 3 fields; expected 7" convergence.csv "${header},tip_error\n1,step,sweeps\n")
refuse_table("table1_colors.csv: has no column kind" table1_colors.csv "rank,size\n1,2\n")
refuse_table("figure12_stages.csv: has no column paper_ms" figure12_stages.csv "stage,online,ms\nheat,true,1\n")
refuse_table("figure8_pictures.csv names gone.png" figure8_pictures.csv
  "figure,row,column,picture,caption\nfigure8_hollow,0,0,gone.png,greedy\n")

# A folder without tables is none to complain about.
file(REMOVE_RECURSE "${FOLDER}/bad")
file(MAKE_DIRECTORY "${FOLDER}/bad")
run_plots(0 "${FOLDER}/bad")
