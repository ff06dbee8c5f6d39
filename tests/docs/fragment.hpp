#pragma once

/// \file What examples of the pages may use without making it.

#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include <tanor/tanor.hpp>

struct Fragment {
  tanor::System& chain;
  tanor::System& system;
  tanor::Simulation& simulation;
};
