# Installs the build tree without the component mpi, which the foreign project beside this file must miss by name, then
# with it; moves the install, builds the project against it, and runs it on two ranks.
#
#   cmake -D build_dir=… -D work_dir=… -D build_type=… -D generator=… -D compiler=… -D mpirun=… -P run.cmake
file(REMOVE_RECURSE ${work_dir})

function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()
function(install_component component)
  run(${CMAKE_COMMAND} --install ${build_dir} --prefix ${work_dir}/installed --config ${build_type}
    --component ${component})
endfunction()

install_component(runtime)
install_component(development)
set(configure ${CMAKE_COMMAND} -G ${generator} -S ${CMAKE_CURRENT_LIST_DIR} -D CMAKE_CXX_COMPILER=${compiler}
  -D CMAKE_BUILD_TYPE=${build_type})
execute_process(COMMAND ${configure} -B ${work_dir}/without -D CMAKE_PREFIX_PATH=${work_dir}/installed
  RESULT_VARIABLE code ERROR_VARIABLE message OUTPUT_QUIET)
if(code EQUAL 0 OR NOT message MATCHES "this installation of tanor has no\n? *component mpi")
  message(FATAL_ERROR "without the component find_package ended with ${code} and said:\n${message}")
endif()

install_component(mpi)
file(RENAME ${work_dir}/installed ${work_dir}/moved)
run(${configure} -B ${work_dir}/build -D CMAKE_PREFIX_PATH=${work_dir}/moved)
run(${CMAKE_COMMAND} --build ${work_dir}/build --config ${build_type})
run(${mpirun} -n 2 ${work_dir}/build/spread_host)
