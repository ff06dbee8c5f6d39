#include "scene/memory.hpp"

/// Returns 1 GB, in place of src/program/scene/memory.cpp: scenes that ask for more are refused on every machine.
double tanor::scene::measure_memory() {
  return 1e9;
}
