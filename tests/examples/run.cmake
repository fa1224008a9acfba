# SPDX-License-Identifier: Apache-2.0
# Runs PROGRAM with ARGUMENTS and looks for EXPECTED, a list of regular expressions, in what it prints.
execute_process(COMMAND "${PROGRAM}" ${ARGUMENTS}
  RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE error)
message("${output}${error}")
if(NOT status EQUAL 0)
  message(FATAL_ERROR "ended with ${status}")
endif()
set(pattern "")
foreach(expected IN LISTS EXPECTED)
  string(APPEND pattern "${expected}.*")
  if(NOT output MATCHES "${pattern}")
    message(FATAL_ERROR "prints nothing that matches '${expected}', or not in its place")
  endif()
endforeach()
