# SPDX-License-Identifier: Apache-2.0
# Compile settings shared by all of our own targets. Private and never exported.

add_library(pbdsurg_build_flags INTERFACE)
# Includes of what is not public name files from the root of the repository.
target_include_directories(pbdsurg_build_flags INTERFACE "${PROJECT_SOURCE_DIR}")
# No fused multiply-add behind our back: the same source gives the same bits on every optimisation
# level, which is what makes the serial backend a reference.
set(flags -ffp-contract=off -Wall -Wextra -Wshadow)
# __FILE__ names no folder of the build machine
list(APPEND flags "-fmacro-prefix-map=${PROJECT_SOURCE_DIR}/=")
if(PBDSURG_WARNINGS_AS_ERRORS)
  list(APPEND flags -Werror)
endif()
list(JOIN flags "," host_flags)
target_compile_options(pbdsurg_build_flags INTERFACE
  # GCC 12 misreads std::string's operator+ as an overlapping copy (its bug 105651).
  "$<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-restrict>"
  # of unity builds, where a source file is included
  "$<$<AND:$<COMPILE_LANG_AND_ID:CXX,GNU>,$<BOOL:${CMAKE_UNITY_BUILD}>>:-Wno-subobject-linkage>"
  # nvcc's own output is not pedantic C++
  "$<$<COMPILE_LANGUAGE:CXX>:${flags};-Wpedantic>"
  # CMake learnt of nvcc's C++20 in 3.26, so it is not asked for as a feature
  "$<$<COMPILE_LANGUAGE:CUDA>:-std=c++20;-Xcompiler=${host_flags}>"
  $<$<AND:$<COMPILE_LANGUAGE:CUDA>,$<BOOL:${PBDSURG_WARNINGS_AS_ERRORS}>>:-Werror=all-warnings>)
if(PBDSURG_SANITIZE)
  target_compile_options(pbdsurg_build_flags INTERFACE
    "$<$<COMPILE_LANGUAGE:CXX>:-fsanitize=${PBDSURG_SANITIZE};-fno-sanitize-recover=all;-fno-omit-frame-pointer>")
  if(PBDSURG_SANITIZE MATCHES "address")  # which finds what these would, in a third less to compile
    target_compile_options(pbdsurg_build_flags INTERFACE
      "$<$<COMPILE_LANGUAGE:CXX>:-fno-sanitize=null,alignment,object-size,vptr>")
  endif()
  target_link_options(pbdsurg_build_flags INTERFACE -fsanitize=${PBDSURG_SANITIZE})
endif()

# pbdsurg_link_private(library targets...): dependencies that a library's own sources alone see. A
# static library passes them on to its users' linker, so the package finds them again; a shared one
# keeps them to itself, and its users need not have them.
function(pbdsurg_link_private library)
  get_target_property(type ${library} TYPE)
  foreach(dependency IN LISTS ARGN)
    if(type STREQUAL "STATIC_LIBRARY")
      target_link_libraries(${library} PRIVATE ${dependency})
    else()
      target_link_libraries(${library} PRIVATE $<BUILD_INTERFACE:${dependency}>)
    endif()
  endforeach()
endfunction()

# Programs of every folder end up side by side.
if(PROJECT_IS_TOP_LEVEL)
  set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
endif()

# pbdsurg_add_program(name sources...): one of our own executables.
function(pbdsurg_add_program name)
  add_executable(${name} ${ARGN})
  target_link_libraries(${name} PRIVATE pbdsurg::core pbdsurg_build_flags)
endfunction()

# pbdsurg_install_program(name): for users, beside a shared library where that is what was built.
function(pbdsurg_install_program name)
  if(PBDSURG_INSTALL)
    include(GNUInstallDirs)
    file(RELATIVE_PATH libraries "${CMAKE_INSTALL_FULL_BINDIR}" "${CMAKE_INSTALL_FULL_LIBDIR}")
    set_target_properties(${name} PROPERTIES INSTALL_RPATH "$ORIGIN/${libraries}")
    install(TARGETS ${name} COMPONENT programs)
  endif()
endfunction()

# pbdsurg_add_test(name [PARTS tags... SOURCES] sources...): the executable <name>_tests. The tests of a module
# link it and what it uses, and nothing else; others link the whole library. A part is what has a tag
# and may be skipped on some machines: ctest has an entry of its own for it. Sanitized, those tagged
# [long] and [validation] are left out: minutes of arithmetic whose code shorter tests run, too.
function(pbdsurg_add_test name)
  cmake_parse_arguments(TEST "" "" "PARTS;SOURCES" ${ARGN})
  add_executable(${name}_tests ${TEST_SOURCES} ${TEST_UNPARSED_ARGUMENTS})
  target_link_libraries(${name}_tests PRIVATE
    pbdsurg_test_main $<IF:$<TARGET_EXISTS:pbdsurg_${name}>,pbdsurg_${name},pbdsurg::core>
    pbdsurg_build_flags)
  set(long "")
  if(PBDSURG_SANITIZE)
    set(long "~[long]~[validation]")
  endif()
  set(others "~[.]${long}")  # exclusions alone would select hidden tests
  foreach(part IN LISTS TEST_PARTS)
    string(APPEND others "~[${part}]")
    add_test(NAME ${name}_${part} COMMAND ${name}_tests "[${part}]${long}")
    set_tests_properties(${name}_${part} PROPERTIES SKIP_RETURN_CODE 77)
  endforeach()
  add_test(NAME ${name} COMMAND ${name}_tests ${others})
endfunction()

# pbdsurg_add_bench(name sources...): the program <name>_bench, which scripts/tables runs.
function(pbdsurg_add_bench name)
  pbdsurg_add_program(${name}_bench ${ARGN})
  target_link_libraries(${name}_bench PRIVATE benchmark::benchmark)
endfunction()
