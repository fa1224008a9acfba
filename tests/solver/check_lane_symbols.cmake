# SPDX-License-Identifier: Apache-2.0
# Usage: cmake -D NM=nm "-D OBJECTS=a.o;b.o" -P check_lane_symbols.cmake
#
# Would catch a function that the objects of several instruction sets share: the linker keeps one of
# them, and a processor without that set meets instructions that it does not know.
foreach(object IN LISTS OBJECTS)
  execute_process(COMMAND "${NM}" --demangle --defined-only "${object}"
                  OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCH "(lanes_[a-z0-9]+_(fast|strict))" set "${object}")
  if(NOT set)
    message(FATAL_ERROR "${object} names no instruction set")
  endif()
  string(REPLACE "\n" ";" symbols "${symbols}")
  list(FILTER symbols INCLUDE REGEX " [WVuT] ")
  list(FILTER symbols EXCLUDE REGEX "${set}")
  if(symbols)
    list(JOIN symbols "\n  " text)
    message(FATAL_ERROR "${object} shares symbols with others:\n  ${text}")
  endif()
endforeach()
