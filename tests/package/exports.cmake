# SPDX-License-Identifier: Apache-2.0
# What the installed shared library shows: its interface, and not what is behind it.
find_program(NM nm REQUIRED)
file(GLOB_RECURSE library "${WORK_DIR}/installed_shared/*/libpbdsurg.so")
execute_process(COMMAND "${NM}" --dynamic --defined-only --demangle "${library}"
  OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
foreach(name "pbdsurg::Solver::step" "pbdsurg::read_mesh" "pbdsurg::Cautery::update" "typeinfo for pbdsurg::InvalidArgument")
  string(FIND "${symbols}" "${name}" place)
  if(place EQUAL -1)
    message(FATAL_ERROR "${library} hides ${name}, which its users need")
  endif()
endforeach()
foreach(name "pbdsurg::parse_msh" "pbdsurg::lanes_" "pbdsurg::CutPlanner" "Eigen::internal")
  string(FIND "${symbols}" "${name}" place)
  if(NOT place EQUAL -1)
    message(FATAL_ERROR "${library} shows ${name}, which is private")
  endif()
endforeach()
