#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tanor/observables.hpp>

#include "report/json_text.hpp"
#include "report/shared_parts.hpp"

namespace tanor::report {

/// One answer of the dynamics, with arrays in the user's order.
struct Solution {
  std::size_t num_points = 0;
  Units units{};
  Json groups{};  ///< of constraints
  Numbers positions, velocities, accelerations;
  std::optional<Split> split;  ///< parts in the tangent space and in the normal space
  Numbers multipliers, self_stress, reactions, support_forces;
  std::vector<Observed> observed;
  Numbers friction;  ///< tau; none if the system has no friction
  std::optional<FrictionReport> friction_report;
  std::optional<std::vector<ReactionPart>> reactions_by_cause;
  std::optional<RankReport> rank;
  std::optional<Certificate> certificate;
  std::string_view form = "normal";
  std::vector<std::string> left_out;
};

/// Prints a solution with all arrays inline.
void print_solution(const Solution& solution);

/// Writes a solution to a file. Arrays above `largest_inline` points go to `<stem>_<key>.npy` beside it.
void write_solution(const std::filesystem::path& path, const Solution& solution);

}  // namespace tanor::report
