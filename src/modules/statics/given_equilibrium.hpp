#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tanor/modes.hpp>

#include "base/check_size.hpp"
#include "statics/equilibrium_equations.hpp"
#include "statics/one_sided.hpp"
#include "statics/smallest_multipliers.hpp"
#include "statics/statics_input.hpp"
#include "system/chosen_members.hpp"

namespace tanor::detail {

/// Returns those of the options of modes or buckling that define the system.
template <class Options>
EquilibriumOptions system_options(const Options& options) {
  EquilibriumOptions result;
  result.at = options.time;
  if constexpr (requires { options.prestress; }) result.prestress = options.prestress;
  result.ignore_friction = options.ignore_friction;
  result.freeze_time = options.freeze_time;
  result.solver = options.solver;
  return result;
}

/// An equilibrium that the caller claims, in the user's order.
struct EquilibriumClaim {
  std::span<const double> positions;    ///< [3n]
  std::span<const double> multipliers;  ///< [equations]; empty: the smallest ones of f + K lambda = 0
  double force_tolerance;               ///< relative to the largest force
};

/// A system at an equilibrium that the caller has found, linearised there. Arrays are in the inner order.
class GivenEquilibrium {
 public:
  /// Throws NotAtRest if the claim is no equilibrium, naming the worst point. Only the `options` that define the
  /// system are used: time, prestress, friction and solver. Points that nothing balances, but that rods under tension
  /// hold between supports, become supports (find_prestress_rigid_points), as in find_equilibrium.
  static std::unique_ptr<GivenEquilibrium> stand_at(System system, const EquilibriumClaim& claim,
                                                    const EquilibriumOptions& options);
  GivenEquilibrium(const System& system, const EquilibriumClaim& claim, const EquilibriumOptions& options);

  const Model& model() const { return work_.model(); }
  EquilibriumEquations& equations() { return equations_; }
  const EquilibriumEquations& equations() const { return equations_; }
  const std::vector<double>& positions() const { return r_; }          ///< [3 points]
  const std::vector<double>& multipliers() const { return lambda_; }   ///< [rows]
  const std::vector<double>& residuals() const { return residuals_; }  ///< |f + K lambda| [moving point], N
  const std::vector<std::string>& left_out() const { return input_.left_out; }
  std::size_t degrees_of_freedom() const { return rank_.degrees_of_freedom; }
  /// Returns the rows of K that depend on others.
  std::vector<std::size_t> dependent_rows() const { return list_dependent_rows(model(), rank_); }

  /// Writes the forces as `EquilibriumEquations::write_forces` does.
  void write_forces(std::vector<double>* multipliers, std::vector<double>* reactions,
                    std::vector<double>* support_forces) {
    std::vector<double> g(equations_.size()), xi(model().num_rows());
    equations_.evaluate(r_.data(), lambda_.data(), g.data(), xi.data());
    equations_.write_forces(lambda_, multipliers, reactions, support_forces);
  }
  /// Evaluates K and W for other multipliers.
  void linearise(const std::vector<double>& lambda) { equations_.linearise(r_.data(), lambda.data()); }
  /// Returns true if Coriolis forces couple motions that the constraints allow.
  bool feels_coriolis();
  /// Names the rows whose multipliers forces do not determine and that change Z'WZ; empty if there are none.
  std::string find_ambiguous_stiffness();

 private:
  void find_multipliers(std::span<const double> given);
  std::string name_worst_row();
  /// Returns why the claim is no equilibrium; empty if it is one.
  std::string find_complaint(double force_tolerance);
  double find_next_step(std::vector<double> g, std::vector<double> xi, double scale);
  std::vector<double> self_stress(const RowDependence& dependence) const;
  std::vector<std::vector<double>> random_moves(std::size_t count);

  StaticsInput input_;
  Workspace work_;
  EquilibriumEquations equations_;
  SmallestMultipliers smallest_;
  std::vector<double> r_, lambda_;
  std::vector<double> residuals_;
  RankReport rank_;
};

/// Returns find(system, options) without the constraints with a side that keep their distance at `positions` [3n]. The
/// options and the answer have the numbers and names of all members.
template <class Options, class Find>
auto find_with_closed(const System& system, std::span<const double> positions, Options options, const Find& find) {
  const std::vector<bool> open = find_open_rows(system, positions, system_options(options));
  if (open.empty()) return find(system, options);
  const auto rename = [&](std::string text) {
    rename_members(system, open, &text);
    return text;
  };
  if constexpr (requires { options.multipliers; }) {
    if (!options.multipliers.empty()) {
      check_size(options.multipliers.size(), open.size(), "multipliers");
      options.multipliers = keep_rows(options.multipliers, open);
    }
    for (Prestress& each : options.prestress) {
      std::size_t row = 0;
      for (std::size_t g = 0; g < system.constraints.size(); ++g) {
        if (each.tensions.size() > 1 && constraint_name(system, g) == each.rods)
          each.tensions = keep_rows(each.tensions, open, row);
        const auto [members, rows] = shape_of(system.constraints[g]);
        row += members * rows;
      }
    }
  }
  try {
    auto found = find(without_open_rows(system, open), options);
    found.outcome.what = rename(found.outcome.what);
    if constexpr (requires { found.multipliers; }) {
      found.multipliers = spread_rows(found.multipliers, open);
      for (std::string& each : found.left_out) each = rename(each);
    }
    return found;
  } catch (const NotAtRest& error) {
    throw NotAtRest(error.where(), rename(error.what()));
  }
}

}  // namespace tanor::detail
