# Installs the build tree, moves the install, builds the foreign project beside this file against it, and runs it.
#
#   cmake -D build_dir=… -D work_dir=… -D build_type=… -D generator=… -D compiler=…
#         -D readelf=… [-D flags=…] [-D shared=ON] [-D program=ON] -P run.cmake
file(REMOVE_RECURSE ${work_dir})

function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# A tree that was moved shows any absolute path left in it.
run(${CMAKE_COMMAND} --install ${build_dir} --prefix ${work_dir}/installed --config ${build_type})
file(RENAME ${work_dir}/installed ${work_dir}/moved)
set(prefix ${work_dir}/moved)

run(${CMAKE_COMMAND} -G ${generator} -S ${CMAKE_CURRENT_LIST_DIR} -B ${work_dir}/build
  -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_CXX_COMPILER=${compiler} -D CMAKE_BUILD_TYPE=${build_type}
  "-DCMAKE_CXX_FLAGS=${flags}" "-DCMAKE_C_FLAGS=${flags}")
run(${CMAKE_COMMAND} --build ${work_dir}/build --config ${build_type})
run(${work_dir}/build/chain_host)
run(${work_dir}/build/host)
run(${work_dir}/build/pendulum_host)

if(program)
  run(${prefix}/bin/tanor --version)
endif()

if(NOT shared)
  return()
endif()

# The same by hand, the way other build systems do it.
find_program(pkg_config NAMES pkg-config pkgconf REQUIRED)
file(GLOB_RECURSE pc_file ${prefix}/tanor.pc)
get_filename_component(pc_dir ${pc_file} DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${pc_dir})
execute_process(COMMAND ${pkg_config} --cflags --libs tanor
  OUTPUT_VARIABLE options OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(options UNIX_COMMAND "${options} ${flags}")
run(${compiler} -std=c++20 ${CMAKE_CURRENT_LIST_DIR}/chain_host.cpp -o ${work_dir}/chain_host_by_hand ${options})
find_program(c_compiler NAMES cc gcc clang REQUIRED)
run(${c_compiler} -std=c11 ${CMAKE_CURRENT_LIST_DIR}/pendulum_host.c -o ${work_dir}/pendulum_host_by_hand ${options} -lm)

# The host needs libtanor itself, not what libtanor is made of.
execute_process(COMMAND ${readelf} -d ${work_dir}/build/chain_host ${work_dir}/chain_host_by_hand
  ${work_dir}/build/pendulum_host ${work_dir}/pendulum_host_by_hand
  OUTPUT_VARIABLE needed COMMAND_ERROR_IS_FATAL ANY)
if(NOT needed MATCHES "NEEDED[^\n]*libtanor\\.so" OR needed MATCHES "NEEDED[^\n]*(cholmod|spqr|metis|gomp|blas)")
  message(FATAL_ERROR "chain_host should need libtanor.so and the standard libraries only:\n${needed}")
endif()
