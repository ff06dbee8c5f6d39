# Configures a tree in which Python, MPI and the page cannot be found, as before scripts/test has installed them, and then
# the same tree where they can: they are looked for again. Under CI the tests are not configured without them.
#
#   cmake -D source=… -D work=… -D compiler=… -D generator=… -P configure_again.cmake
file(REMOVE_RECURSE ${work})
file(MAKE_DIRECTORY ${work})
set(parts tanor_python tanor_mpi html_page_template)
set(hidden -D CMAKE_DISABLE_FIND_PACKAGE_pybind11=ON -D CMAKE_DISABLE_FIND_PACKAGE_MPI=ON -D CMAKE_DISABLE_FIND_PACKAGE_ZLIB=ON)
set(shown -U CMAKE_DISABLE_FIND_PACKAGE_*)

function(configure result)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env ${ARGN} -G ${generator} -S ${source} -B ${work} -D CMAKE_BUILD_TYPE=Release
    -D CMAKE_CXX_COMPILER=${compiler} -D TANOR_BUILD_BENCH=OFF RESULT_VARIABLE code OUTPUT_VARIABLE out ERROR_VARIABLE err)
  set(${result} ${code} PARENT_SCOPE)
  set(said "${out}${err}" PARENT_SCOPE)
endfunction()

# Configures a tree without tests where CI is not set.
function(expect_parts wanted)
  configure(failed --unset=CI ${CMAKE_COMMAND} ${ARGN} -D TANOR_BUILD_TESTS=OFF)
  if(failed)
    message(FATAL_ERROR "${said}")
  endif()
  file(READ ${work}/build.ninja rules)
  foreach(part IN LISTS parts)
    string(FIND "${rules}" ${part} place)
    if((place EQUAL -1 AND wanted) OR (NOT place EQUAL -1 AND NOT wanted))
      message(FATAL_ERROR "${part}: wanted ${wanted}\n${said}")
    endif()
  endforeach()
endfunction()

expect_parts(OFF ${hidden})

configure(failed CI=true ${CMAKE_COMMAND} -D TANOR_BUILD_TESTS=ON)
if(NOT failed OR NOT said MATCHES "pybind11-dev" OR NOT said MATCHES "libopenmpi-dev" OR NOT said MATCHES "npm")
  message(FATAL_ERROR "under CI the tests were configured without parts:\n${said}")
endif()

expect_parts(ON ${shown})
expect_parts(OFF -D TANOR_AUTO=OFF)
