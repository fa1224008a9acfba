# SPDX-License-Identifier: Apache-2.0
# Writes FILE, a header that says which build this is, if it would change: cmake -D SOURCE_DIR=...
# -D FILE=... -D VERSION=... -D BUILD=... -P. Run by every build, since a commit configures nothing.
set(commit "unknown")
find_program(GIT git)
if(GIT)
  execute_process(COMMAND "${GIT}" -C "${SOURCE_DIR}" rev-parse --show-toplevel
    OUTPUT_VARIABLE top OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  file(REAL_PATH "${SOURCE_DIR}" source)
  if(top STREQUAL source)  # and not the checkout of a project that contains this one
    execute_process(COMMAND "${GIT}" -C "${SOURCE_DIR}" describe --always --dirty --abbrev=12 --exclude=*
      OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(NOT commit)  # there is none yet
      set(commit "unknown")
    endif()
  endif()
endif()
set(text "#define PBDSURG_VERSION \"${VERSION}\"\n#define PBDSURG_COMMIT \"${commit}\"\n")
string(APPEND text "#define PBDSURG_BUILD \"${BUILD}\"\n")
if(EXISTS "${FILE}")
  file(READ "${FILE}" before)
endif()
if(NOT text STREQUAL before)
  file(WRITE "${FILE}" "${text}")
endif()
