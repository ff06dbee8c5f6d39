# The house itself: the rooms' arrows, what the shared library shows, and a foreign project on the install tree.
add_test(NAME house/rooms COMMAND ${PROJECT_SOURCE_DIR}/scripts/check_rooms.py)
add_test(NAME house/rooms_self_test COMMAND ${PROJECT_SOURCE_DIR}/scripts/check_rooms.py --self-test)

if(TANOR_SHARED)
  add_test(NAME house/exports COMMAND ${PROJECT_SOURCE_DIR}/scripts/check_exports.py
    $<TARGET_FILE:tanor> ${PROJECT_SOURCE_DIR}/include ${CMAKE_NM})
  add_test(NAME house/licence COMMAND ${PROJECT_SOURCE_DIR}/scripts/check_licence.py $<TARGET_FILE:tanor>
    $<IF:$<BOOL:${TANOR_GPL}>,ON,OFF> ${CMAKE_NM})
  add_test(NAME house/licence_self_test COMMAND ${PROJECT_SOURCE_DIR}/scripts/check_licence.py --self-test)
  add_test(NAME house/exports_self_test COMMAND ${PROJECT_SOURCE_DIR}/scripts/check_exports.py --self-test)
endif()

if(TANOR_INSTALL)
  set(package_flags)
  if(TANOR_SANITIZE)
    set(package_flags -fsanitize=${TANOR_SANITIZE})
  endif()
  add_test(NAME package/foreign_project COMMAND ${CMAKE_COMMAND}
    -D build_dir=${PROJECT_BINARY_DIR} -D work_dir=${CMAKE_CURRENT_BINARY_DIR}/package
    -D build_type=$<CONFIG> -D generator=${CMAKE_GENERATOR} -D compiler=${CMAKE_CXX_COMPILER} -D flags=${package_flags}
    -D readelf=${CMAKE_READELF} -D shared=${TANOR_SHARED} -D program=${TANOR_BUILD_PROGRAM}
    -P ${CMAKE_CURRENT_SOURCE_DIR}/package/run.cmake)
  set_tests_properties(package/foreign_project PROPERTIES TIMEOUT 300 COST 12)
endif()

# The archive for other systems, which scripts/package --portable makes.
find_program(PATCHELF patchelf)
if(TANOR_INSTALL AND TANOR_SHARED AND PATCHELF AND TARGET tanor_python AND TARGET tanor_cli AND NOT TANOR_SANITIZE)
  add_test(NAME package/portable COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/package/check_portable.py
    ${PROJECT_BINARY_DIR} ${CMAKE_CURRENT_BINARY_DIR}/portable)
  set_tests_properties(package/portable PROPERTIES TIMEOUT 600 COST 60)
endif()

# Projects that contain tanor; only configured, for scripts/check.sh builds them.
foreach(by add_subdirectory FetchContent)
  add_test(NAME package/${by} COMMAND ${CMAKE_COMMAND} -G ${CMAKE_GENERATOR} --fresh
    -S ${CMAKE_CURRENT_SOURCE_DIR}/package/subproject -B ${CMAKE_CURRENT_BINARY_DIR}/package-${by}
    -D by=${by} -D tanor_source=${PROJECT_SOURCE_DIR} -D CMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER})
endforeach()

add_test(NAME house/blas_kernels COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/bench/check_blas_kernels.py)
set_tests_properties(house/blas_kernels PROPERTIES ENVIRONMENT PYTHONDONTWRITEBYTECODE=1)

# What was missing once is looked for again; where this build has all of it, two more configurations show that.
if(TARGET tanor_python AND TARGET tanor_mpi AND TANOR_HAS_REPORT_PAGE AND CMAKE_GENERATOR STREQUAL "Ninja")
  add_test(NAME house/parts COMMAND ${CMAKE_COMMAND} -D source=${PROJECT_SOURCE_DIR} -D generator=${CMAKE_GENERATOR}
    -D work=${CMAKE_CURRENT_BINARY_DIR}/parts -D compiler=${CMAKE_CXX_COMPILER}
    -P ${CMAKE_CURRENT_SOURCE_DIR}/parts/configure_again.cmake)
  set_tests_properties(house/parts PROPERTIES TIMEOUT 300 COST 20)
endif()
