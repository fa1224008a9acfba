# SPDX-License-Identifier: Apache-2.0
# Runs the demo as a sketch (a twentieth of its length) and reads what it leaves behind.
file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}")

# run_to(status name arguments...): the demo into FOLDER/name, which must end with a status.
function(run_to expected name)
  execute_process(COMMAND "${PROGRAM}" --headless --time-scale 0.05 --out "${FOLDER}/${name}" ${ARGN}
    RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE error)
  if(NOT status EQUAL expected)
    message(FATAL_ERROR "the demo ended with ${status}, not ${expected}: ${error}")
  endif()
  if(NOT output MATCHES "report.json")
    message(FATAL_ERROR "the last line does not name the report: ${output}")
  endif()
endfunction()

# run(name arguments...): the same, which must succeed.
function(run)
  run_to(0 ${ARGV})
endfunction()

# refuse(message arguments...): the demo must stop with status 2 and a message.
function(refuse message)
  execute_process(COMMAND "${PROGRAM}" --headless --out "${FOLDER}/refused" ${ARGN}
    RESULT_VARIABLE status OUTPUT_QUIET ERROR_VARIABLE error)
  if(NOT status EQUAL 2 OR NOT error MATCHES "${message}")
    message(FATAL_ERROR "expected status 2 and '${message}', got ${status} and '${error}'")
  endif()
endfunction()

# refuse_out(message folder): the demo must stop so for its --out, before any mesh is made.
function(refuse_out message folder)
  execute_process(COMMAND "${PROGRAM}" --headless --out "${folder}"
    RESULT_VARIABLE status OUTPUT_QUIET ERROR_VARIABLE error)
  if(NOT status EQUAL 2 OR NOT error MATCHES "${message}" OR error MATCHES "tetrahedra")
    message(FATAL_ERROR "expected status 2 and '${message}', got ${status} and '${error}'")
  endif()
endfunction()

# read_report(name variable): report.json without the times, which alone may differ.
function(read_report name variable)
  file(READ "${FOLDER}/${name}/report.json" report)
  string(JSON report REMOVE "${report}" stages_ms)
  set(${variable} "${report}" PARENT_SCOPE)
endfunction()

# expect_warnings(report code...): each code is in the report's warnings, with a text.
function(expect_warnings report)
  foreach(code ${ARGN})
    if(NOT report MATCHES "\"code\" : \"${code}\",[ \n]*\"text\" : \"[^\"]+\",[ \n]*\"value\" : [0-9]")
      message(FATAL_ERROR "no warning '${code}' in ${report}")
    endif()
  endforeach()
endfunction()

# write_box(name x y z sizes...): FOLDER/name, a box as a surface with its corner at x, y, z.
function(write_box name x y z dx dy dz)
  math(EXPR x2 "${x} + ${dx}")
  math(EXPR y2 "${y} + ${dy}")
  math(EXPR z2 "${z} + ${dz}")
  set(text "")
  foreach(cz ${z} ${z2})
    foreach(cy ${y} ${y2})
      foreach(cx ${x} ${x2})
        string(APPEND text "v ${cx} ${cy} ${cz}\n")
      endforeach()
    endforeach()
  endforeach()
  string(APPEND text "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n")
  file(WRITE "${FOLDER}/${name}" "${text}")
endfunction()

run(first --seed 3)
read_report(first first)
# Would catch anything in the result that depends on time, on addresses or on leftovers. Sanitized,
# one run is long enough.
if(NOT IS_SANITIZED)
  run(second --seed 3 --no-pictures)
  run(other --seed 4 --no-pictures)
  read_report(second second)
  read_report(other other)
  string(JSON first_rest REMOVE "${first}" files)  # all but the pictures
  string(JSON second_rest REMOVE "${second}" files)
  if(NOT first_rest STREQUAL second_rest)
    message(FATAL_ERROR "the same seed gave two reports:\n${first}\n${second}")
  endif()
  string(JSON hash GET "${first}" state_hash)
  string(JSON other_hash GET "${other}" state_hash)
  if(hash STREQUAL other_hash)
    message(FATAL_ERROR "another seed gave the same state, ${hash}")
  endif()
endif()
foreach(key tets_deleted links_cut)
  string(JSON count GET "${first}" ${key})
  if(count EQUAL 0)
    message(FATAL_ERROR "the sketch has ${key} = 0: hook or grasper missed")
  endif()
endforeach()

# what others rely on
foreach(key bodies tets_deleted links_cut energy_in_j residual_max colors plan backend seed)
  string(JSON value ERROR_VARIABLE missing GET "${first}" ${key})
  if(missing)
    message(FATAL_ERROR "report.json has no ${key}")
  endif()
endforeach()
foreach(expected "0 gallbladder 22611" "1 liver 19729")
  separate_arguments(expected)
  list(GET expected 0 index)
  list(GET expected 1 name)
  list(GET expected 2 least)
  string(JSON actual GET "${first}" bodies ${index} name)
  string(JSON tets GET "${first}" bodies ${index} tets)
  if(NOT actual STREQUAL name OR tets LESS least)
    message(FATAL_ERROR "body ${index} is ${actual} with ${tets} tets; expected ${name}, ${least}")
  endif()
endforeach()
string(JSON steps GET "${first}" steps)
file(STRINGS "${FOLDER}/first/force.csv" rows)
list(LENGTH rows count)
math(EXPR expected "2 * ${steps} + 1")
list(GET rows 0 header)
if(NOT count EQUAL expected OR NOT header STREQUAL "t_s,tool,fx_n,fy_n,fz_n")
  message(FATAL_ERROR "force.csv has ${count} rows after '${header}'; expected ${expected}")
endif()
# Would catch numbers that are only there: tissue pulls on the grasper, comes back, and takes up what
# the hook delivers.
string(REGEX MATCHALL "grasper,[^;]*[1-9]" pulls "${rows}")
if(NOT pulls)
  message(FATAL_ERROR "force.csv knows no force on the grasper")
endif()
string(JSON dragged GET "${first}" recovery_mm 0)
string(JSON left GET "${first}" recovery_mm end)
if(dragged LESS 10 OR NOT left LESS dragged)
  message(FATAL_ERROR "dragged by ${dragged} mm, ${left} mm left: expected some 20 mm, and less")
endif()
file(STRINGS "${FOLDER}/first/recovery.csv" back)
list(POP_FRONT back header release)
string(REGEX MATCH "^[0-9]+" dragged_mm "${dragged}")
if(NOT header STREQUAL "t_ms,distance_mm" OR NOT release MATCHES "^0,${dragged_mm}" OR NOT back)
  message(FATAL_ERROR "recovery.csv begins with ${header}, ${release}; the report says ${dragged} mm at release")
endif()
string(JSON in GET "${first}" energy_ledger in_j)
string(JSON error GET "${first}" energy_ledger error_j)
if(in LESS 20 OR error GREATER 2e-8 OR error LESS -2e-8)  # 1e-9 of what came in
  message(FATAL_ERROR "of ${in} J, ${error} J are unaccounted for")
endif()
file(STRINGS "${FOLDER}/first/cautery.csv" burns)
list(GET burns -1 last)
string(JSON deleted GET "${first}" tets_deleted)
string(JSON cut GET "${first}" links_cut)
if(NOT last MATCHES ",${deleted},${cut}$")
  message(FATAL_ERROR "cautery.csv ends with ${last}; the report says ${deleted}, ${cut}")
endif()
file(GLOB pictures "${FOLDER}/first/*.png")
list(LENGTH pictures count)
if(HAS_PICTURES AND count EQUAL 0)
  message(WARNING "no pictures: this machine can create no OpenGL context")
endif()

string(JSON warnings LENGTH "${first}" warnings)
if(NOT warnings EQUAL 0)
  message(FATAL_ERROR "the built-in operation draws warnings: ${first}")
endif()

# A user's own organ, with a tenth of the built-in one's vertices. Would catch links that follow
# vertices (118 in place of 1443), and a neighbour that is out of reach without a word.
execute_process(COMMAND "${TOOL}" mesh make gallbladder "${FOLDER}/own.msh" --spacing 7
  COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
file(WRITE "${FOLDER}/own/run.part/thesis.txt" "mine")
file(WRITE "${FOLDER}/own/notes.csv" "mine")
run(own --organ "gallbladder=${FOLDER}/own.msh" --no-pictures)
read_report(own own)
string(JSON tets GET "${own}" bodies 0 tets)
string(JSON default_tets GET "${first}" bodies 0 tets)
if(tets EQUAL default_tets)
  message(FATAL_ERROR "--organ changed nothing")
endif()
string(JSON fibres GET "${own}" joints 0 fibres)
if(fibres LESS 1200 OR fibres GREATER 1700)
  message(FATAL_ERROR "a coarse gallbladder hangs on ${fibres} fibres; the built-in one on 1443")
endif()
expect_warnings("${own}" apart)

# Would catch pictures of one run beside the report of another, and files of the user's that go: a
# second run into the same folder leaves its own alone, those of the user's apart.
if(NOT IS_SANITIZED)
  file(COPY "${FOLDER}/first/" DESTINATION "${FOLDER}/again")
  file(WRITE "${FOLDER}/again/00_mine.png" "mine")
  run(again --seed 4 --no-pictures)
  file(GLOB present RELATIVE "${FOLDER}/again" "${FOLDER}/again/*")
  read_report(again again)
  string(JSON count LENGTH "${again}" files)
  list(REMOVE_ITEM present 00_mine.png)
  list(LENGTH present present_count)
  if(NOT present_count EQUAL count OR present MATCHES "png"
     OR NOT EXISTS "${FOLDER}/again/00_mine.png")
    message(FATAL_ERROR "a second run left ${present}; its report lists ${count} files")
  endif()
endif()

# Would catch files of the user's that are deleted or replaced.
file(READ "${FOLDER}/own/run.part/thesis.txt" thesis)
file(GLOB parts "${FOLDER}/own/*.part")
if(NOT thesis STREQUAL "mine" OR NOT EXISTS "${FOLDER}/own/notes.csv"
   OR NOT parts STREQUAL "${FOLDER}/own/run.part")
  message(FATAL_ERROR "a run beside the user's run.part left ${parts}")
endif()
foreach(name force.csv series_000003.vtu 07_burn_end.png report.json)
  file(REMOVE_RECURSE "${FOLDER}/taken")
  file(WRITE "${FOLDER}/taken/${name}" "mine")
  refuse_out("${name} is no file of an earlier run.*--out" "${FOLDER}/taken")
  file(READ "${FOLDER}/taken/${name}" content)
  if(NOT content STREQUAL "mine")
    message(FATAL_ERROR "the user's ${name} is gone")
  endif()
endforeach()
file(RENAME "${FOLDER}/own/report.json" "${FOLDER}/elsewhere.json")
file(CREATE_LINK "${FOLDER}/elsewhere.json" "${FOLDER}/own/report.json" SYMBOLIC)
refuse_out("report.json is no file of an earlier run" "${FOLDER}/own")

# Would catch a folder that is found useless after minutes, and a message that names no option.
file(CREATE_LINK "${FOLDER}/nowhere" "${FOLDER}/dangling" SYMBOLIC)
refuse_out("--out '': expected" "")
refuse_out("--out '.*own.msh': is no folder" "${FOLDER}/own.msh")
refuse_out("--out '/dev/full': is no folder" /dev/full)
refuse_out("--out '.*dangling': is no folder" "${FOLDER}/dangling")
refuse_out("--out '/proc/demo': cannot be written to" /proc/demo)

# A signal in the middle, and another at once. Would catch a folder without a report, or a report that
# passes for whole.
execute_process(
  COMMAND sh -c "\"$0\" --headless --no-pictures --out \"$1\" &
    while kill -0 $! && ! [ -s \"$1/run.part/force.csv\" ]; do sleep 0.1; done
    kill -HUP $!; kill -TERM $!; wait $!" "${PROGRAM}" "${FOLDER}/interrupted"
  RESULT_VARIABLE status OUTPUT_QUIET ERROR_QUIET)
if(NOT status EQUAL 130)
  message(FATAL_ERROR "interrupted, the demo ended with ${status}, not 130")
endif()
read_report(interrupted interrupted)
string(JSON steps GET "${interrupted}" steps)
string(JSON time GET "${interrupted}" interrupted_at_s)
file(STRINGS "${FOLDER}/interrupted/cautery.csv" rows)
list(LENGTH rows count)
math(EXPR count "${count} - 1")
if(NOT count EQUAL steps OR time LESS 0.005 OR EXISTS "${FOLDER}/interrupted/run.part")
  message(FATAL_ERROR "interrupted at ${time} s: ${steps} steps, ${count} rows in cautery.csv")
endif()

# Would catch a liver that is filled at the default resolution whatever its tetrahedra.
if(NOT IS_SANITIZED)
  execute_process(COMMAND "${TOOL}" mesh make liver "${FOLDER}/coarse.msh" --vertices 1200
    COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
  run(coarse --organ "liver=${FOLDER}/coarse.msh" --no-pictures)
  read_report(coarse coarse)
  string(JSON vertices GET "${coarse}" bodies 1 vertices)
  if(vertices LESS 1000 OR vertices GREATER 1400)
    message(FATAL_ERROR "a liver of 1200 vertices was filled with ${vertices}")
  endif()
endif()

# Surfaces that are not what they seem. Would catch gaps that are filled over without a word, and a
# gallbladder of which half is dropped.
write_box(open.obj 0 0 0 80 30 30)
file(READ "${FOLDER}/open.obj" box)
string(REPLACE "f 2 4 8 6\n" "" open "${box}")
file(WRITE "${FOLDER}/open.obj" "${open}")
run(open --no-pictures --organ "gallbladder=${FOLDER}/open.obj" --unit mm)
read_report(open open)
expect_warnings("${open}" gaps_filled)
write_box(part.obj 0 0 0 40 30 30)
write_box(other_part.obj 60 0 0 30 30 30)
file(READ "${FOLDER}/part.obj" part)
file(READ "${FOLDER}/other_part.obj" other_part)
string(REGEX REPLACE "f [^v]*" "" other_part "${other_part}")
file(WRITE "${FOLDER}/parts.obj" "${part}${other_part}f 9 11 12 10\nf 13 14 16 15\nf 9 10 14 13\n"
  "f 11 15 16 12\nf 9 13 15 11\nf 10 12 16 14\n")
refuse("gallbladder of .*parts.obj is lost in part.* x .* mm in the scene become .*--spacing"
  --organ "gallbladder=${FOLDER}/parts.obj" --unit mm)

# Two organs of one scan that lie a metre apart, so that neither is where it should be. Would catch
# places that are not kept, and an operation on nothing that ends like one.
write_box(far_gallbladder.obj 0 0 0 80 30 30)
write_box(far_fat.obj 1000 0 0 40 25 20)
run_to(1 far --no-pictures --keep-placement --organ "gallbladder=${FOLDER}/far_gallbladder.obj"
  --organ "calot_fat=${FOLDER}/far_fat.obj")
read_report(far far)
expect_warnings("${far}" unit_guessed apart ended_early never_touched nothing_burnt organ_lost)
string(JSON first_note GET "${far}" organ_files 0)
string(JSON second_note GET "${far}" organ_files 1)
string(REGEX MATCH "turned by.*" first_turn "${first_note}")
string(REGEX MATCH "turned by.*" second_turn "${second_note}")
if(first_turn STREQUAL "" OR NOT first_turn STREQUAL second_turn)
  message(FATAL_ERROR "organs of one scan are moved apart: ${first_note}; ${second_note}")
endif()

# A third of a gallbladder. Would catch one that falls off, and a run that ends as if it had not.
if(NOT IS_SANITIZED)
  write_box(small.obj 0 0 0 30 11 11)
  run_to(1 small --no-pictures --organ "gallbladder=${FOLDER}/small.obj" --unit mm)
  read_report(small small)
  expect_warnings("${small}" few_links apart organ_lost)
endif()

run(paper --paper --no-pictures)
refuse("'nan' is no number from 0.01 to 10" --time-scale nan)
refuse("'1e20' is no whole number" --seed 1e20)
refuse("'-1' is no whole number" --seed -1)
refuse("'inch' is none of auto.mm.cm.dm.m" --unit inch)
# a vessel in the wrong unit, told before it is filled
write_box(vessel.obj 0 0 0 12 3 3)
refuse("cystic_artery of .*vessel.obj takes about [0-9]+ tetrahedra; --max-tets allows 300000"
  --organ "cystic_artery=${FOLDER}/vessel.obj" --unit cm)
refuse("--max-tets needs --organ" --max-tets 1000)
refuse("--keep-placement needs --organ" --keep-placement)
refuse("gallbladder of .*own.msh takes about [0-9]+ tetrahedra; --max-tets allows 1000"
  --organ "gallbladder=${FOLDER}/own.msh" --max-tets 1000)
# files of two units, of which one would pass alone
write_box(large.obj 0 0 0 80000 30000 30000)
refuse("no one unit.*vessel.obj would be 12 mm if in mm"
  --organ "gallbladder=${FOLDER}/large.obj" --organ "cystic_artery=${FOLDER}/vessel.obj")
# a sheet that no lattice of the organ's spacing fills
write_box(sheet.obj 0 0 0 400 300 3)
refuse("calot_fat of .*sheet.obj cannot be filled.*--unit"
  --organ "calot_fat=${FOLDER}/sheet.obj" --scale 0.0001)
# tetrahedra that share no point, and such that are turned one by one
set(nodes "")
set(loose "")
foreach(i RANGE 3)
  math(EXPR x "20 * ${i}")
  math(EXPR x2 "${x} + 20")
  math(EXPR a "4 * ${i} + 1")
  math(EXPR b "${a} + 1")
  math(EXPR c "${a} + 2")
  math(EXPR d "${a} + 3")
  string(APPEND nodes "${a} ${x} 0 0\n${b} ${x2} 0 0\n${c} ${x} 30 0\n${d} ${x} 0 30\n")
  string(APPEND loose "${a} 4 2 1 1 ${a} ${b} ${c} ${d}\n")
endforeach()
set(head "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n16\n${nodes}$EndNodes\n$Elements\n")
file(WRITE "${FOLDER}/loose.msh" "${head}4\n${loose}$EndElements\n")
refuse("gallbladder of .*loose.msh is in 4 parts.* 1 of 4 tetrahedra.*mesh check"
  --organ "gallbladder=${FOLDER}/loose.msh" --unit mm)
file(WRITE "${FOLDER}/turned.msh" "${head}3\n1 4 2 1 1 1 2 3 4\n2 4 2 1 1 1 2 8 3\n3 4 2 1 1 1 3 4 8\n$EndElements\n")
refuse("turned.msh: .*pbdsurg mesh convert .*--orient"
  --organ "gallbladder=${FOLDER}/turned.msh" --unit mm)
refuse("no organ 'spleen'" --organ "spleen=${FOLDER}/own.msh")
refuse("NAME=FILE" --organ gallbladder)
refuse("nowhere.vtk" --organ "gallbladder=${FOLDER}/nowhere.vtk")
refuse("unit" --organ "gallbladder=${FOLDER}/own.msh" --unit mm)
file(WRITE "${FOLDER}/broken.msh" "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n7\n1 0 0\n")
refuse("broken.msh" --organ "liver=${FOLDER}/broken.msh")
