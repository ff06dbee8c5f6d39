#pragma once

#include <cstddef>

#include <tanor/motion.hpp>
#include <tanor/ranks.hpp>

#include "dynamics/mechanics.hpp"
#include "motion/snapshot.hpp"

namespace tanor {

/// What a user gives to a motion: throws InputError where it makes no sense.
void check_options(const MotionOptions& options);
/// Options, start time and system; what may be wrong with the input of some rank is told by all.
void check_together(const Part& part, const System& system, const MotionOptions& options, double t_start);
/// `size`: 3 times the number of points.
void check_snapshot(const Snapshot& snapshot, std::size_t size);

ChosenMethod choose_method(const MotionOptions& options, const System& system, Mechanics& mechanics,
                           bool in_coordinates);
/// rattle and the implicit methods step in normal form. Throws InputError where there is none, or friction that
/// implicit methods do not know.
SolverOptions resolve(SolverOptions solver, const System& system, Method method);

}  // namespace tanor
