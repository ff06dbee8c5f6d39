# `cmake --install`: library, headers, CMake package, pkg-config file, program, licence.
# The install tree can be moved: nothing in it holds an absolute path.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/tanor)

install(TARGETS tanor EXPORT tanorTargets
  ARCHIVE COMPONENT development
  LIBRARY COMPONENT runtime NAMELINK_COMPONENT development
  FILE_SET HEADERS COMPONENT development
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})  # for consumers whose CMake (< 3.23) knows no file sets
install(EXPORT tanorTargets NAMESPACE tanor:: DESTINATION ${package_dir} COMPONENT development)

configure_package_config_file(cmake/tanorConfig.cmake.in ${PROJECT_BINARY_DIR}/tanorConfig.cmake
  INSTALL_DESTINATION ${package_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tanorConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/tanorConfig.cmake
  ${PROJECT_BINARY_DIR}/tanorConfigVersion.cmake
  cmake/FindCHOLMOD.cmake
  cmake/FindSPQR.cmake
  cmake/FindKLU.cmake
  cmake/FindMETIS.cmake
  DESTINATION ${package_dir} COMPONENT development)

file(RELATIVE_PATH libdir_to_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(cmake/tanor.pc.in ${PROJECT_BINARY_DIR}/tanor.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/tanor.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

if(TANOR_BUILD_PROGRAM)
  if(TANOR_HAS_REPORT_PAGE)  # the licences of what is bundled into the program
    foreach(library IN ITEMS three uplot)
      install(FILES ${page_bundle}/LICENSE.${library} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/tanor COMPONENT program)
    endforeach()
  endif()
  file(RELATIVE_PATH bindir_to_libdir ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
  set_target_properties(tanor_cli PROPERTIES INSTALL_RPATH "$ORIGIN/${bindir_to_libdir}")
  install(TARGETS tanor_cli RUNTIME COMPONENT program)
  foreach(module IN ITEMS tanor_view tanor_picture tanor_h5md tanor_npz)
    if(TARGET ${module})
      set_target_properties(${module} PROPERTIES INSTALL_RPATH "$ORIGIN/..")
      install(TARGETS ${module} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/tanor COMPONENT program)
    endif()
  endforeach()
  # Scenes that need no file that is fetched, and short programs of Python.
  install(DIRECTORY examples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/tanor/examples COMPONENT program
    FILES_MATCHING PATTERN "*.json" PATTERN "answers/*.py" PATTERN "python/*.py"
    REGEX "/((melt|melt_bonds|melt_phantom|protein)\\.json|liggghts|yade)$" EXCLUDE)
  if(TARGET tanor_manual)
    set(manual ${PROJECT_BINARY_DIR}/manual)
    install(DIRECTORY ${manual}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program
      FILES_MATCHING PATTERN "*.1")
    install(FILES ${manual}/completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME tanor
      COMPONENT program)
    install(FILES ${manual}/completion.zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions RENAME _tanor
      COMPONENT program)
  endif()
endif()

install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)
