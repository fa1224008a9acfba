# SPDX-License-Identifier: Apache-2.0
# Builds the driver against a folder that is laid out as OpenHaptics is, with the emulator's header in
# it: cmake/FindOpenHaptics.cmake finds it, and the driver's path for the SDK compiles without warnings.
set(sdk "${WORK_DIR}/sdk")
file(REMOVE_RECURSE "${WORK_DIR}")
file(COPY "${SOURCE_DIR}/apps/hdapi_emulator/HD" DESTINATION "${sdk}/include")
file(MAKE_DIRECTORY "${sdk}/lib")
file(COPY_FILE "${LIBRARY}" "${sdk}/lib/libHD.a")

execute_process(COMMAND "${CMAKE_COMMAND}" -S "${SOURCE_DIR}/tests/hdapi/sdk" -B "${WORK_DIR}/build"
  -G "${GENERATOR}" -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}
  -D SOURCE_DIR=${SOURCE_DIR} -D OpenHaptics_ROOT=${sdk}
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${CMAKE_COMMAND}" --build "${WORK_DIR}/build" COMMAND_ERROR_IS_FATAL ANY)
