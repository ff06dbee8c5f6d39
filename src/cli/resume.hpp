#pragma once

#include <optional>

#include <tanor/motion.hpp>

#include "report/checkpoint.hpp"

namespace tanor::cli {

/// A simulation from the start of a system, or from a checkpoint.
Simulation make_simulation(System system, MotionOptions motion, const SolverOptions& solver,
                           const std::optional<report::Checkpoint>& checkpoint);

/// Report of a whole run: what was done before a checkpoint (if any) and what was done since.
MotionReport add_reports(const std::optional<report::Checkpoint>& before, const MotionReport& since);

}  // namespace tanor::cli
