# SPDX-License-Identifier: Apache-2.0
# Runs `pbdsurg color ...` as a user does: exit status, what is printed where, the JSON keys that
# scripts rely on, and the files of colours.
file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}")

# run(status stdout-pattern stderr-pattern arguments...)
function(run status out_pattern error_pattern)
  execute_process(COMMAND "${PROGRAM}" ${ARGN} WORKING_DIRECTORY "${FOLDER}"
    RESULT_VARIABLE result OUTPUT_VARIABLE out ERROR_VARIABLE error)
  if(NOT result STREQUAL status OR NOT out MATCHES "${out_pattern}"
     OR NOT error MATCHES "${error_pattern}")
    message(SEND_ERROR "pbdsurg ${ARGN}\nexit ${result} (wanted ${status})\nstdout (wanted "
                       "'${out_pattern}'):\n${out}\nstderr (wanted '${error_pattern}'):\n${error}")
  endif()
  set(out "${out}" PARENT_SCOPE)
endfunction()

# expect(what value wanted)
function(expect what value wanted)
  if(NOT value STREQUAL wanted)
    message(SEND_ERROR "${what}: ${value}; ${wanted} is due")
  endif()
endfunction()

run(0 "\"tets\"" "^$" mesh make table2:1 organ.msh --json)
string(JSON vertices GET "${out}" vertices)
string(JSON edges GET "${out}" edges)
string(JSON tets GET "${out}" tets)

# One colour a line for every constraint; the keys in their order.
set(first constraints colors clique_bound rsd top10 mid80 last10 ms valid max_over_mean overflow
    algorithm order executor seed)
foreach(kind distance volume joint vertex)
  run(0 "\"valid\": true" "^$" color organ.msh --constraints ${kind} --algorithm greedy
      --order saturation --output ${kind}.txt --json)
  string(REGEX MATCHALL "\"[a-z0-9_]+\":" keys "${out}")
  string(REGEX REPLACE "[\":]" "" keys "${keys}")
  set(wanted ${first})
  if(kind STREQUAL joint)
    list(APPEND wanted max_owned)
    string(JSON owned GET "${out}" max_owned)
    expect("edges of one tet" "${owned}" 2)
  endif()
  expect("keys for ${kind}" "${keys}" "${wanted}")
  set(count ${tets})
  if(kind STREQUAL distance)
    set(count ${edges})
  elseif(kind STREQUAL vertex)
    set(count ${vertices})
  endif()
  string(JSON constraints GET "${out}" constraints)
  expect("${kind} constraints" "${constraints}" "${count}")
  file(STRINGS "${FOLDER}/${kind}.txt" lines)
  list(LENGTH lines line_count)
  expect("lines of ${kind}.txt" "${line_count}" "${count}")
  list(SORT lines COMPARE NATURAL)
  list(GET lines 0 lowest)
  list(GET lines -1 highest)
  string(JSON colors GET "${out}" colors)
  math(EXPR last "${colors} - 1")
  expect("colours in ${kind}.txt" "${lowest} to ${highest}" "0 to ${last}")
endforeach()
file(STRINGS "${FOLDER}/volume.txt" volume)
file(STRINGS "${FOLDER}/joint.txt" joint)
expect("joint colours" "${joint}" "${volume}")

# No number of threads changes a byte, whatever is asked for.
foreach(algorithm greedy luby jones_plassmann random_disc)
  foreach(threads 1 2 5)
    run(0 "\"executor\": \"${threads} threads?\"" "^$" color organ.msh --constraints volume
        --algorithm ${algorithm} --repair --balance --seed 7 --executor threads:${threads}
        --output ${algorithm}-${threads}.txt --json)
    file(SHA256 "${FOLDER}/${algorithm}-${threads}.txt" hash_${threads})
  endforeach()
  expect("${algorithm} on 2 threads" "${hash_2}" "${hash_1}")
  expect("${algorithm} on 5 threads" "${hash_5}" "${hash_1}")
  if(NOT algorithm STREQUAL greedy)
    string(FIND "${out}" "\"order\"" order)
    expect("order of ${algorithm}" "${order}" -1)
  endif()
endforeach()

# Whoever reads the graph and the colours of a small mesh can check the one by the other.
run(0 "\"tets\"" "^$" mesh make cystic_duct small.msh --vertices 120 --json)
foreach(kind distance volume joint vertex)
  run(0 "\"valid\": true" "^$" color small.msh --constraints ${kind} --repair --graph ${kind}.mtx
      --output small-${kind}.txt --json)
  string(JSON constraints GET "${out}" constraints)
  file(STRINGS "${FOLDER}/small-${kind}.txt" colors)
  file(STRINGS "${FOLDER}/${kind}.mtx" lines)
  list(POP_FRONT lines banner comment size)
  expect("banner of ${kind}.mtx" "${banner}" "%%MatrixMarket matrix coordinate pattern symmetric")
  if(NOT comment MATCHES "^% ${kind} constraints of small.msh: ")
    message(SEND_ERROR "comment of ${kind}.mtx: ${comment}")
  endif()
  list(LENGTH lines entries)
  expect("size of ${kind}.mtx" "${size}" "${constraints} ${constraints} ${entries}")
  if(entries LESS constraints)
    message(SEND_ERROR "${kind}.mtx: ${entries} conflicts among ${constraints} constraints")
  endif()
  foreach(line IN LISTS lines)
    string(REPLACE " " ";" ids "${line}")
    list(GET ids 0 row)
    list(GET ids 1 column)
    math(EXPR row "${row} - 1")
    math(EXPR column "${column} - 1")
    list(GET colors ${row} first)
    list(GET colors ${column} second)
    if(column GREATER_EQUAL row OR first STREQUAL second)
      message(SEND_ERROR "${kind}.mtx: ${line}, of colours ${first} and ${second}")
    endif()
  endforeach()
endforeach()

# What a limit leaves over is counted and marked.
run(0 "\"colors\": 20" "^$" color organ.msh --constraints volume --max-colors 20
    --output limited.txt --json)
string(JSON overflow GET "${out}" overflow)
file(STRINGS "${FOLDER}/limited.txt" left_over REGEX "^-1$")
list(LENGTH left_over left_over)
expect("left over" "${left_over}" "${overflow}")
if(overflow EQUAL 0)
  message(SEND_ERROR "20 colours cannot hold all tets")
endif()

run(0 "${tets} volume constraints\n +colours +[0-9]+" "^$" color organ.msh --constraints volume
    --algorithm random_disc --palette conflicts --shrink 2.5)

# What cannot be done is refused in one line that names it.
run(2 "^$" "^pbdsurg: [^\n]+\n$" color organ.msh)
run(2 "^$" "^pbdsurg: none.msh: no such file\n$" color none.msh --constraints volume)
file(WRITE "${FOLDER}/surface.obj" "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
run(2 "^$" "^pbdsurg: surface.obj: is a surface of 1 triangles without tetrahedra[^\n]*\n$"
    color surface.obj --constraints distance --unit m)
file(WRITE "${FOLDER}/artery.obj" "v 0 0 0\nv 12 0 0\nv 0 1 0\nf 1 2 3\n")
run(2 "^$" "^pbdsurg: artery.obj: the longest side of 12 is 12 mm if in mm[^\n]*: give --unit\n$"
    color artery.obj --constraints distance)
run(2 "^$" "^pbdsurg: no-folder/colours.txt: cannot be written: [^\n]+\n$"
    color organ.msh --constraints volume --output no-folder/colours.txt)

# The file of colours is put in place at once, through a link; a device is written to.
file(CREATE_LINK volume.txt "${FOLDER}/link.txt" SYMBOLIC)
file(SHA256 "${FOLDER}/distance.txt" distance_hash)
run(0 "distance constraints" "^$" color organ.msh --constraints distance --algorithm greedy
    --order saturation --output link.txt)
file(SHA256 "${FOLDER}/volume.txt" hash)
expect("what the link names" "${hash}" "${distance_hash}")
if(NOT IS_SYMLINK "${FOLDER}/link.txt" OR EXISTS "${FOLDER}/volume.txt.part")
  message(SEND_ERROR "--output link.txt: the link is gone, or a part is left")
endif()
run(0 "0\n.*[1-9]\n" "^$" color organ.msh --constraints volume --output /dev/stdout)

run(2 "^$" "^pbdsurg: no-folder/graph.mtx: cannot be written: [^\n]*\n$"
    color organ.msh --constraints volume --graph no-folder/graph.mtx)
run(2 "^$" "^pbdsurg: organ.msh: is the mesh that is read; name another file to write\n$"
    color organ.msh --constraints volume --output organ.msh)
run(2 "^$" "^pbdsurg: --graph and --output both name one.txt\n$"
    color organ.msh --constraints volume --graph one.txt --output one.txt)
# refuse(pattern arguments...)
function(refuse pattern)
  run(2 "^$" "^pbdsurg: [^\n]*${pattern}[^\n]*\n$" color organ.msh ${ARGN})
endfunction()
refuse("'bending' is none of distance.volume.joint.vertex" --constraints bending)
set(tets_by --constraints volume --algorithm)
refuse("'best' is none of greedy.luby" ${tets_by} best)
refuse("'1' is none of greedy.luby" ${tets_by} 1)
refuse("'random' is none of natural" ${tets_by} greedy --order random)
refuse("--order natural is for --algorithm greedy only" ${tets_by} luby --order natural)
refuse("--palette conflicts is for --algorithm random_disc only" ${tets_by} luby
       --palette conflicts)
refuse("--shrink 3 is for" ${tets_by} random_disc --shrink 3)
refuse("shrink is 0.5" ${tets_by} random_disc --palette conflicts --shrink 0.5)
refuse("'-1' is no whole number from 0 to 18446744073709551615" ${tets_by} luby --seed -1)
refuse("'18446744073709551616' is no" ${tets_by} luby --seed 18446744073709551616)
foreach(name threads:-2 threads:4294967297 threads:1.5 threads: threads:2x thread cuda:x tpu)
  refuse("no executor '${name}'" ${tets_by} luby --executor ${name})
endforeach()
refuse("'0' is no whole number from 1" ${tets_by} luby --max-colors 0)
refuse("'1e20' is no whole number" ${tets_by} luby --seed 1e20)
refuse("shrink is nan" ${tets_by} random_disc --palette conflicts --shrink nan)
refuse("'inch' is none of" ${tets_by} luby --unit inch)
if(NOT HAS_CUDA)
  refuse("this build has no CUDA" ${tets_by} luby --executor cuda)
endif()
