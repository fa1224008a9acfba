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
run(0 "\"tets\": 1" "good.msh: coordinates taken for mm: the longest side is then 0.09 m\n$"
    mesh info good.msh --unit auto --json)
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

run(0 "note: points that no element uses: 1 \\(4\\)" "^$" mesh check good.msh)
run(1 "error: tets that use a vertex twice: 1 \\(0\\)" "^$" mesh check flat.msh)
run(1 "\"ok\": false" "^$" mesh check --json flat.msh)
run(2 "^$" "^pbdsurg: cut.msh:14: the file ends where a node id should be\n$" mesh info cut.msh)
run(2 "^$" "^pbdsurg: none.msh: no such file\n$" mesh check none.msh)
run(2 "^$" "^pbdsurg: --unit: 'inch' is none of auto\\|mm\\|cm\\|m\n$" mesh info good.msh --unit inch)
run(2 "^$" "^pbdsurg: --unit: '1' is none of [^\n]+\n$" mesh info good.msh --unit 1)
run(2 "^$" "^pbdsurg: [^\n]+\n$" mesh)
run(0 "mesh" "^$" --help)

run(0 "^$" "^$" mesh convert good.msh out.vtu --unit mm --ascii)
run(0 "\"volume_m3\": 0.00012[^\n]+\n" "^$" mesh info out.vtu --json)
run(0 "0 of 1 tets were inverted" "^$" mesh convert good.msh out.msh --format-version 4.1 --orient)
run(0 "Gmsh MSH 4.1, binary" "^$" mesh info out.msh)
run(2 "^$" "^pbdsurg: [^\n]+\n$" mesh convert good.msh out.xyz)
