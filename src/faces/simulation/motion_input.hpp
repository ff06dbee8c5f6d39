#pragma once

#include <cstddef>

#include <tanor/motion.hpp>
#include <tanor/ranks.hpp>

#include "dynamics/mechanics.hpp"
#include "motion/snapshot.hpp"

namespace tanor::detail {

/// Checks the user's options of a motion. Throws InputError if one makes no sense.
void check_options(const MotionOptions& options);
/// Checks options, start time and system, and returns the solver's options as the method needs them: rattle and the
/// implicit methods step in normal form. Throws InputError on all ranks if the input of one is wrong, if there is
/// friction and the method does not support it, or if an implicit method would reach from rank to rank.
SolverOptions check_together(const Part& part, const System& system, const MotionOptions& motion,
                             const SolverOptions& solver, double t_start);
/// Checks a snapshot; `size` is 3 times the number of points.
void check_snapshot(const Snapshot& snapshot, std::size_t size);

/// Chooses a method, the same on all ranks.
ChosenMethod choose_method(const MotionOptions& options, const System& system, Mechanics& mechanics,
                           bool in_coordinates);

}  // namespace tanor::detail
