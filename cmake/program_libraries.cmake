# Libraries without which the program is built all the same, and says what it cannot write:
# zlib (compression), HDF5 (h5md), libzip (npz). Sets has_zlib, has_hdf5, has_zip and
# program_libraries; the modules of src/program/formats link HDF5 and libzip.
find_package(ZLIB QUIET)
# Debian's HDF5 without MPI lies in folders of its own; tools that could tell more are slow and pull in MPI.
find_path(HDF5_SERIAL_INCLUDE_DIR hdf5.h PATH_SUFFIXES hdf5/serial)
find_library(HDF5_SERIAL_LIBRARY NAMES hdf5_serial hdf5)
find_path(ZIP_INCLUDE_DIR zip.h)
find_library(ZIP_LIBRARY zip)
mark_as_advanced(HDF5_SERIAL_INCLUDE_DIR HDF5_SERIAL_LIBRARY ZIP_INCLUDE_DIR ZIP_LIBRARY)

set(program_libraries)
set(has_zlib ${ZLIB_FOUND})
if(has_zlib)
  list(APPEND program_libraries ZLIB::ZLIB)
endif()
foreach(library IN ITEMS hdf5:HDF5_SERIAL zip:ZIP)
  string(REPLACE ":" ";" library ${library})
  list(GET library 0 name)
  list(GET library 1 prefix)
  if(${prefix}_INCLUDE_DIR AND ${prefix}_LIBRARY)
    set(has_${name} ON)
  else()
    set(has_${name} OFF)
    message(STATUS "the program is built without ${name}")
  endif()
endforeach()
