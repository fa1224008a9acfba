# SPDX-License-Identifier: Apache-2.0
# Compile settings shared by all of our own targets. Private and never exported.

add_library(pbdsurg_build_flags INTERFACE)
target_compile_options(pbdsurg_build_flags INTERFACE
  # No fused multiply-add behind our back: the same source gives the same bits on every optimisation
  # level, which is what makes the serial backend a reference.
  $<$<COMPILE_LANGUAGE:CXX>:-ffp-contract=off>
  "$<$<COMPILE_LANGUAGE:CXX>:-Wall;-Wextra;-Wpedantic;-Wshadow>"
  $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<BOOL:${PBDSURG_WARNINGS_AS_ERRORS}>>:-Werror>)
if(PBDSURG_SANITIZE)
  target_compile_options(pbdsurg_build_flags INTERFACE
    "$<$<COMPILE_LANGUAGE:CXX>:-fsanitize=${PBDSURG_SANITIZE};-fno-sanitize-recover=all;-fno-omit-frame-pointer>")
  target_link_options(pbdsurg_build_flags INTERFACE -fsanitize=${PBDSURG_SANITIZE})
endif()

# Programs of every folder end up side by side.
if(PROJECT_IS_TOP_LEVEL)
  set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
endif()

# pbdsurg_add_program(name sources...): one of our own executables.
function(pbdsurg_add_program name)
  add_executable(${name} ${ARGN})
  target_link_libraries(${name} PRIVATE pbdsurg::core pbdsurg_build_flags)
endfunction()

# pbdsurg_add_test(room sources...): the tests of one room, as the executable <room>_tests.
function(pbdsurg_add_test room)
  pbdsurg_add_program(${room}_tests ${ARGN})
  target_include_directories(${room}_tests PRIVATE "${PROJECT_SOURCE_DIR}/tests")
  target_link_libraries(${room}_tests PRIVATE pbdsurg_test_main)
  add_test(NAME ${room} COMMAND ${room}_tests)
endfunction()
