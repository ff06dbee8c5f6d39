#pragma once

/// \file The objects that examples of the pages use without making them.

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
