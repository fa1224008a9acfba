# SPDX-License-Identifier: Apache-2.0
# Runs `pbdsurg mesh ...` as a user does: exit status, what is printed where, and the JSON keys that
# scripts rely on.
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

set(nodes "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 90 0 0\n3 0 90 0\n4 0 0 90\n"
          "5 1 1 1\n$EndNodes\n$Elements\n1\n")
string(CONCAT nodes ${nodes})
file(WRITE "${FOLDER}/good.msh" "${nodes}1 4 2 0 1 1 2 3 4\n$EndElements\n")
file(WRITE "${FOLDER}/flat.msh" "${nodes}1 4 2 0 1 1 2 3 3\n$EndElements\n")
file(WRITE "${FOLDER}/cut.msh" "${nodes}1 4 2 0 1 1 2")

run(0 "vertices +4 \\(4 on the boundary\\), 1 points" "^$" mesh info good.msh --unit mm)
set(taken_for_mm "coordinates taken for mm: the longest side is then 90 mm; --unit[^\n]+\n$")
run(0 "\"tets\": 1" "^pbdsurg: good.msh: ${taken_for_mm}" mesh info good.msh --unit auto --json)
foreach(key vertices edges tets boundary_triangles components euler volume_m3 min_dihedral_deg
            max_dihedral_deg inverted unreferenced max_tets_per_vertex)
  string(JSON value ERROR_VARIABLE missing GET "${out}" ${key})
  if(missing)
    message(SEND_ERROR "mesh info --json: ${missing}")
  endif()
endforeach()
string(JSON volume GET "${out}" volume_m3)
if(NOT volume MATCHES "^0\\.00012149999|^0\\.0001215|^0\\.000121500")
  message(SEND_ERROR "volume_m3 is ${volume}; 0.0001215 is due")
endif()

run(0 "note: points that no element uses: 1 \\(4\\)" "^$" mesh check good.msh --unit mm)
run(1 "error: tets that use a vertex twice: 1 \\(0\\)" "^$" mesh check flat.msh --unit mm)
run(1 "\"ok\": false" "${taken_for_mm}" mesh check --json flat.msh)
run(2 "^$" "^pbdsurg: cut.msh:14: the file ends where a node id should be\n$" mesh info cut.msh)
run(2 "^$" "^pbdsurg: none.msh: no such file\n$" mesh check none.msh)
run(2 "^$" "^pbdsurg: --unit: 'inch' is none of auto\\|mm\\|cm\\|dm\\|m; [^\n]+--scale[^\n]+0.0254\\)\n$"
    mesh info good.msh --unit inch)
run(2 "^$" "^pbdsurg: --unit: '1' is none of [^\n]+\n$" mesh info good.msh --unit 1)
run(2 "^$" "^pbdsurg: a subcommand is missing; the subcommands of mesh are info, check, convert, make\n$" mesh)
run(2 "^$" "^pbdsurg: there is no subcommand 'bogus'; the subcommands of pbdsurg are mesh, color\n$" bogus)
run(2 "^$" "^pbdsurg: there is no option '--bogus'; the subcommands of pbdsurg are mesh, color\n$" --bogus)
run(2 "^$" "^pbdsurg: ./good.msh: is the mesh that is read; name another file to write\n$"
    mesh convert good.msh ./good.msh --unit mm)
run(2 "^$" "^pbdsurg: there is no subcommand 'chek'; the subcommands of mesh are [^\n]+\n$" mesh chek a.msh)
run(0 "mesh" "^$" --help)

run(0 "^$" "^$" mesh convert good.msh out.vtu --unit mm --ascii)
run(0 "\"volume_m3\": 0.00012[^\n]+\n" "^$" mesh info out.vtu --json)
run(0 "0 of 1 tets were inverted" "^$" mesh convert good.msh out.msh --format-version 4.1 --orient
    --unit mm)
run(0 "Gmsh MSH 4.1, binary" "^$" mesh info out.msh)
run(2 "^$" "^pbdsurg: [^\n]+\n$" mesh convert good.msh out.xyz --unit mm)

# surface(FILE SIZE [FACES]): a box of SIZE x SIZE x SIZE, of all faces or of those that are named.
function(surface file size)
  set(faces "f 1 3 4 2" "f 5 6 8 7" "f 1 2 6 5" "f 3 7 8 4" "f 1 5 7 3" "f 2 4 8 6")
  if(ARGN)
    set(faces ${ARGN})
  endif()
  string(REPLACE ";" "\n" faces "${faces}")
  file(WRITE "${FOLDER}/${file}" "v 0 0 0\nv ${size} 0 0\nv 0 ${size} 0\nv ${size} ${size} 0\n"
    "v 0 0 ${size}\nv ${size} 0 ${size}\nv 0 ${size} ${size}\nv ${size} ${size} ${size}\n${faces}\n")
endfunction()

# An artery of 12 mm must not become one of 12 cm; what is asked for is done as asked.
surface(artery.obj 12)
surface(liver.obj 190)
surface(huge.obj 190000)
surface(small.obj 0.1)
foreach(command info check)
  run(2 "^$" "^pbdsurg: artery.obj: the longest side of 12 is 12 mm if in mm, 120 mm if in cm: give --unit\n$"
      mesh ${command} artery.obj)
endforeach()
run(2 "^$" "artery.obj: the longest side of 12 is 12 mm if in mm" mesh convert artery.obj a.vtu)
run(2 "^$" "artery.obj: the longest side of 12 is 12 mm if in mm" mesh make artery.obj a.vtu)
run(0 "longest side +12 mm" "^$" mesh info artery.obj --unit mm)
run(0 "longest side +120 mm" "^$" mesh info artery.obj --unit cm)
run(0 "coordinates in dm.*longest side +1200 mm" "^$" mesh info artery.obj --unit dm)
run(0 "in units of 0.0254 m.*longest side +304.8 mm" "^$" mesh info artery.obj --scale 0.0254)
run(0 "\"unit\": null,[^\"]+\"metres_per_unit\": 0.0254" "^$"
    mesh info artery.obj --scale 0.0254 --json)
run(2 "^$" "^pbdsurg: --[^\n]+excludes[^\n]+\n$" mesh info artery.obj --scale 1 --unit mm)
foreach(bad nan inf 0 -1 1e999 1e-999 2mm)
  run(2 "^$" "^pbdsurg: --scale: '${bad}' is no positive, finite number\n$"
      mesh info artery.obj "--scale=${bad}")
endforeach()
run(2 "^$" "1e.308; point [0-9]+ would be no longer finite\n$" mesh info artery.obj --scale 1e308)
# two of one scan share the unit that suits both
run(0 "side +12 mm.*side +190 mm" "artery.obj: coordinates taken for mm.*liver.obj: coordinates [^\n]+ mm"
    mesh check artery.obj liver.obj)
run(2 "^$" "huge.obj: the longest side of 190000 is 190 m if in mm[^\n]+: give --unit or --scale\n$"
    mesh check huge.obj)
run(2 "^$" "no unit makes all files organs[^\n]+small.obj is 0.1, that of liver.obj 190; "
    mesh check liver.obj small.obj)
# a liver of 190 m is something to remark, whatever was asked for
run(0 "warning: the longest side of 190 m is not that of an organ[^\n]+190 mm if in mm: see --unit\n" "^$"
    mesh check liver.obj --unit m)
run(0 "warning: the longest side of 3 mm is not that of" "^$" mesh check artery.obj --scale 0.00025)
run(0 "tets" "liver.obj: the longest side of 190 m is not that of an organ" mesh make liver.obj big.vtu
    --unit m --vertices 500)
# what the tool itself wrote needs no guess, whatever its size
run(0 "" "^$" mesh convert artery.obj tenth.vtk --scale 0.0001)
run(0 "longest side +1.2 mm" "^$" mesh info tenth.vtk)
run(0 "warning: the longest side of 190 m" "^$" mesh check big.vtu)

# One bad file does not keep the others from being checked.
run(2 "good.msh: Gmsh.*liver.obj: Wavefront" "^pbdsurg: none.msh: no such file\n$"
    mesh check good.msh none.msh liver.obj --unit mm)
run(2 "" "^pbdsurg: none.msh: no such file\n$" mesh check flat.msh none.msh --unit mm --json)
string(JSON second GET "${out}" 1 error)
string(JSON first GET "${out}" 0 file)
if(NOT "${first} ${second}" STREQUAL "flat.msh none.msh: no such file")
  message(SEND_ERROR "mesh check --json: the entries are ${first} and ${second}")
endif()

# Filling says what it changes, and nothing of a surface that it follows.
set(taken "coordinates taken for mm[^\n]+\n")
run(0 "tets" "^pbdsurg: liver.obj: ${taken}$" mesh make liver.obj cube.vtu --vertices 800)
surface(open.obj 190 "f 1 3 4 2" "f 5 6 8 7" "f 1 2 6 5" "f 3 7 8 4" "f 1 5 7 3")
run(0 "\"surface\": {[^}]+\"open_edges\": 4[^}]+}.*\"boundary\": {[^}]+\"open_edges\": 0"
    "open.obj: the surface is not closed: it has 4 open edges, [^\n]+\n.*1 part of Euler characteristic 1; [^\n]+, 1 shell with 0 handles\n$"
    mesh make open.obj filled.vtu --vertices 800 --json)
file(READ "${FOLDER}/liver.obj" two)
file(APPEND "${FOLDER}/two.obj" "${two}v 300 0 0\nv 330 0 0\nv 300 30 0\nv 300 0 30\n"
  "f 9 11 10\nf 9 10 12\nf 10 11 12\nf 9 12 11\n")
run(0 "tets" "of the surface, 2 shells with 0 handles; of the tets' boundary, 1 shell with 0 handles\n$"
    mesh make two.obj one.vtu --spacing 10)
surface(sheet.obj 190 "f 1 3 4 2")
run(2 "^$" "pbdsurg: sheet.obj: the surface encloses nothing" mesh make sheet.obj none.vtu)
foreach(bad nan inf 0 -3 1e400)
  run(2 "^$" "^pbdsurg: --spacing: '${bad}' is no positive, finite number\n$"
      mesh make liver x.vtu --spacing=${bad})
  run(2 "^$" "^pbdsurg: --vertices: '${bad}' is no whole number from 1 to 2147483647\n$"
      mesh make liver x.vtu --vertices=${bad})
endforeach()
run(2 "^$" "^pbdsurg: --unit and --scale are for surface files only\n$" mesh make liver x.vtu --unit mm)

# Tets that a format cannot hold are not left out without a word, and nothing is no mesh.
run(0 "^$" "^pbdsurg: cube.stl: holds triangles alone: [1-9][0-9]* tets are left out, their boundary is written\n$"
    mesh convert cube.vtu cube.stl)
run(0 "^$" "^$" mesh convert cube.vtu cube.msh)
run(0 "tets" "^pbdsurg: liver.stl: holds triangles alone[^\n]+\n$" mesh make liver liver.stl --spacing 15)
file(WRITE "${FOLDER}/points.obj" "v 0 0 0\nv 90 0 0\n")
run(2 "^$" "points.obj: has points but neither tetrahedra nor triangles; nothing is written\n$"
    mesh convert points.obj points.vtu --unit mm)
if(EXISTS "${FOLDER}/points.vtu")
  message(SEND_ERROR "mesh convert wrote a mesh without elements")
endif()

# Messages about inverted tets name their repair, and that works.
string(REPLACE "$Elements\n1\n" "$Elements\n2\n" half "${nodes}")
string(REPLACE "5 1 1 1" "5 -90 0 0" half "${half}")
file(WRITE "${FOLDER}/half.msh" "${half}1 4 2 0 1 1 2 3 4\n2 4 2 0 1 1 5 3 4\n$EndElements\n")
run(1 "error: inverted tets: 1 \\(1\\).*note: [^\n]+--orient" "^$" mesh check half.msh --unit mm)
run(2 "^$" "half.msh: tet 1 [^\n]+of 2 tets, 1 have negative volume: pbdsurg mesh convert --orient turns them\n$"
    color half.msh --constraints volume --unit mm)
run(0 "^$" "half.msh: 1 of 2 tets are inverted; --orient would turn them\n$"
    mesh convert half.msh kept.msh --unit mm)
run(0 "1 of 2 tets were inverted and are turned" "^$"
    mesh convert half.msh turned.msh --orient --unit mm)
run(0 "inverted, flat +0, 0" "^$" mesh check turned.msh)
