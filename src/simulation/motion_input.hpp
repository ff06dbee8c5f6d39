#pragma once

#include <cstddef>

#include <tanor/motion.hpp>
#include <tanor/ranks.hpp>

#include "dynamics/mechanics.hpp"
#include "motion/snapshot.hpp"

namespace tanor {

/// Checks the user's options of a motion. Throws InputError if one makes no sense.
void check_options(const MotionOptions& options);
/// Checks options, start time and system. All ranks report what may be wrong with the input of one rank.
void check_together(const Part& part, const System& system, const MotionOptions& options, double t_start);
/// Checks a snapshot; `size` is 3 times the number of points.
void check_snapshot(const Snapshot& snapshot, std::size_t size);

ChosenMethod choose_method(const MotionOptions& options, const System& system, Mechanics& mechanics,
                           bool in_coordinates);
/// Chooses the normal form for rattle and the implicit methods, which need it. Throws InputError if there is none, or
/// if there is friction and the method does not support it.
SolverOptions resolve(SolverOptions solver, const System& system, Method method);

}  // namespace tanor
