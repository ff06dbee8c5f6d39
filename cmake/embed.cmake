# The plugs for programs of others (src/bindings/embed), each where its host is found.

# LAMMPS and LIGGGHTS, where their headers are.
function(find_rank_host name header library)
  # A host that is not sanitized itself cannot load what is.
  if(TANOR_SANITIZE)
    return()
  endif()
  find_path(${name}_INCLUDE_DIR fix.h PATH_SUFFIXES ${header})
  find_library(${name}_LIBRARY ${library})
  find_package(MPI QUIET COMPONENTS CXX)
  need_for(found TANOR_${name} "fix tanor/rods for ${name}" "${header}/fix.h, lib${library}, MPI or TANOR_SHARED"
    ${name}_INCLUDE_DIR ${name}_LIBRARY MPI_CXX_FOUND TANOR_SHARED)
  set(${name}_FOUND ${found} PARENT_SCOPE)
endfunction()

find_rank_host(LAMMPS lammps lammps)
find_rank_host(LIGGGHTS liggghts liggghts)
if(LAMMPS_FOUND OR LIGGGHTS_FOUND)
  find_package(MPI REQUIRED COMPONENTS CXX)
  add_subdirectory(src/bindings/embed/ranks src/embed/ranks)
endif()
if(LAMMPS_FOUND)
  add_subdirectory(src/bindings/embed/lammps src/embed/lammps)
endif()
if(LIGGGHTS_FOUND)
  add_subdirectory(src/bindings/embed/liggghts src/embed/liggghts)
endif()

# OpenMM, where its headers are, and a compiler takes them for C++20 (clang 14 does not).
find_package(OpenMM QUIET)
if(OpenMM_FOUND)
  include(CheckCXXSourceCompiles)
  set(CMAKE_REQUIRED_LIBRARIES OpenMM::OpenMM)
  check_cxx_source_compiles("#include <OpenMM.h>\nint main() { OpenMM::System system; }" OpenMM_COMPILES)
  unset(CMAKE_REQUIRED_LIBRARIES)
endif()
need_for(has_openmm TANOR_OPENMM "ExactConstraints for OpenMM"
  "openmm/reference/ReferenceConstraints.h, libOpenMM, a compiler that takes its headers for C++20, or TANOR_SHARED"
  OpenMM_COMPILES TANOR_SHARED)
if(has_openmm)
  add_subdirectory(src/bindings/embed/openmm src/embed/openmm)
endif()
