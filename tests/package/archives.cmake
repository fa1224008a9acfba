# SPDX-License-Identifier: Apache-2.0
# The packages of cpack, unpacked elsewhere: programs run there and name this build, a user's program
# links the library, and Debian is told what it needs.
include("${CMAKE_CURRENT_LIST_DIR}/common.cmake")
find_program(DPKG_DEB dpkg-deb)
find_program(DPKG_SHLIBDEPS dpkg-shlibdeps)
if(NOT DPKG_DEB OR NOT DPKG_SHLIBDEPS)
  message("skipped: dpkg-dev is not installed")
  return()
endif()
set(packages "${WORK_DIR}/packages")
set(unpacked "${WORK_DIR}/unpacked")
file(REMOVE_RECURSE "${packages}" "${unpacked}")
run(${CMAKE_CPACK_COMMAND} --config "${BUILD_DIR}/CPackConfig.cmake" -B "${packages}")

# run_programs(folder): those in folder/bin say which build they are, and work.
function(run_programs folder)
  if(NOT HAS_PROGRAMS)
    return()
  endif()
  foreach(program pbdsurg cholecystectomy)
    execute_process(COMMAND "${folder}/bin/${program}" --version
      OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
    if(NOT text MATCHES "pbdsurg ${VERSION} [(]commit [0-9a-z-]+, ${BUILD_TYPE}, ")
      message(FATAL_ERROR "${program} --version says '${text}'")
    endif()
  endforeach()
  run("${folder}/bin/pbdsurg" mesh info "${CONSUMER_DIR}/two.vtk")
  run("${folder}/bin/cholecystectomy" --headless --no-pictures --time-scale 0.05 --out "${WORK_DIR}/demo")
endfunction()

file(GLOB archive "${packages}/pbdsurg-${VERSION}-*.tar.gz")
file(ARCHIVE_EXTRACT INPUT "${archive}" DESTINATION "${unpacked}/archive")
file(GLOB folder "${unpacked}/archive/*")
run_programs("${folder}")
build_and_run_consumer(archive -D CMAKE_PREFIX_PATH=${folder}
  -D CONSUMER_COMPONENTS=core -D CONSUMER_LIBRARY=pbdsurg::core)

file(GLOB debs "${packages}/*.deb")
foreach(deb IN LISTS debs)
  execute_process(COMMAND "${DPKG_DEB}" --field "${deb}" Package Version Depends
    OUTPUT_VARIABLE fields COMMAND_ERROR_IS_FATAL ANY)
  message("${fields}")
  if(NOT fields MATCHES "Version: ${VERSION}" OR
     NOT fields MATCHES "Package: (libpbdsurg-dev.*Depends:.*libeigen3-dev|pbdsurg.*Depends:.*libc6)")
    message(FATAL_ERROR "${deb} says ${fields}")
  endif()
  run("${DPKG_DEB}" --extract "${deb}" "${unpacked}/debian")
endforeach()
run_programs("${unpacked}/debian/usr")
build_and_run_consumer(debian -D CMAKE_PREFIX_PATH=${unpacked}/debian/usr
  -D CONSUMER_COMPONENTS=core -D CONSUMER_LIBRARY=pbdsurg::core)
