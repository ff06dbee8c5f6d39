# How code is compiled that fuzz targets watch: under the address and undefined-behaviour sanitizers and, for libFuzzer,
# telling which blocks run and what is compared. The rooms that read bytes of others are; the rooms behind them only
# compute with numbers, and are those of every build.
set(watched_compile_options)
set(watched_link_options)
set(sanitizers -fsanitize=address,undefined,float-cast-overflow)
# Eigen allocates otherwise under the address sanitizer, where the rooms that are not watched do not follow.
set(options_beside_sanitizers -DEIGEN_MALLOC_ALREADY_ALIGNED=1 -O1 -g1 -fno-sanitize-recover=all -fno-omit-frame-pointer)
if(TANOR_FUZZ)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    set(coverage -fsanitize-coverage=trace-pc,trace-cmp)  # tests/fuzz/gcc_coverage.cpp hands them on
  else()
    set(coverage -fsanitize=fuzzer-no-link)
  endif()
  set(watched_compile_options ${sanitizers} ${coverage} ${options_beside_sanitizers})
  set(watched_link_options ${sanitizers})
  foreach(room core/base core/system faces/simulation modules/host)
    file(GLOB watched src/${room}/*.cpp)
    # The headers that tanor_objects reads once are read without these options.
    set_source_files_properties(${watched} PROPERTIES
      COMPILE_OPTIONS "${watched_compile_options}" SKIP_PRECOMPILE_HEADERS ON)
  endforeach()
  # GCC's alarms at the stack of a formula are false: it takes the first slot that a pointer in a loop had for all.
  file(GLOB watched src/core/system/*.cpp)
  set_source_files_properties(${watched} PROPERTIES
    COMPILE_OPTIONS "${watched_compile_options};-fno-sanitize=object-size")
  target_compile_options(tanor_scene PRIVATE ${watched_compile_options})
elseif(TANOR_BUILD_TESTS AND NOT TANOR_SANITIZE)
  # In every other build the targets and what reads bytes for them are watched, in copies of their own (tests/fuzz).
  include(CheckCXXSourceCompiles)
  list(JOIN sanitizers " " CMAKE_REQUIRED_FLAGS)
  check_cxx_source_compiles("int main() { return 0; }" TANOR_HAS_SANITIZERS)
  unset(CMAKE_REQUIRED_FLAGS)
  if(TANOR_HAS_SANITIZERS)
    # These three, which the preset `fuzz` has, take a third of the time to compile; null pointers and sizes of objects are
    # seen by the address sanitizer, casts between classes of virtual functions there are none.
    set(watched_compile_options ${sanitizers} -fno-sanitize=null,object-size,vptr ${options_beside_sanitizers}
      $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)  # false alarms at std::regex (GCC bug 105562)
    set(watched_link_options ${sanitizers})
  else()
    message(STATUS "fuzz targets run without sanitizers: this compiler has none")
  endif()
endif()
