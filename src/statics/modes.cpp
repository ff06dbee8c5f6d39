#include <tanor/modes.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <variant>

#include "base/quiet_traps.hpp"
#include "base/text.hpp"
#include "statics/given_equilibrium.hpp"
#include "statics/mode_finder.hpp"
#include "statics/rigid_modes.hpp"

namespace tanor {

namespace {

/// Below so many freedoms all modes are found, by dense matrices with so many numbers at most.
constexpr std::size_t most_dense_freedoms = 300, most_dense_numbers = 50'000'000;
/// |W - W'| over |W|: more is no rounding.
constexpr double allowed_asymmetry = 1e-8;
/// Of the scale of omega^2: less is 0. Where the equilibrium is known less well, zero modes are too.
constexpr double rounding = 1e-12, share_of_residual = 100.0;

/// What says which system it is.
EquilibriumOptions describe_system(const ModesOptions& options) {
  EquilibriumOptions result;
  result.at = options.time;
  result.prestress = options.prestress;
  result.ignore_friction = options.ignore_friction;
  result.solver = options.solver;
  return result;
}

void add_damping(const System& system, std::vector<std::string>* left_out) {
  for (std::size_t k = 0; k < system.forces.size(); ++k) {
    const auto* const springs = std::get_if<Springs>(&system.forces[k]);
    if (springs != nullptr && springs->damping > 0.0)
      left_out->push_back(force_name(system, k) + ": its damping takes no part in vibrations");
  }
}

/// Numbers of modes that can be found: all by dense matrices, or the lowest ones.
struct Plan {
  std::size_t count;
  bool is_dense;
};

Plan make_plan(std::size_t freedoms, std::size_t size, std::size_t wanted) {
  const bool is_dense = freedoms <= most_dense_freedoms && freedoms * size <= most_dense_numbers;
  if (is_dense) return {wanted == ModesOptions::all ? freedoms : std::min(wanted, freedoms), true};
  const std::string most = std::to_string(freedoms / 2) + " of the " + std::to_string(freedoms) + " modes";
  if (wanted == ModesOptions::all)
    throw InputError("/modes/count", "found \"all\", wanted a number: above " + std::to_string(most_dense_freedoms) +
                                         " freedoms the lowest modes are found, at most " + most);
  if (wanted > freedoms / 2)
    throw InputError("/modes/count", "found " + std::to_string(wanted) + ", wanted at most " + most);
  return {wanted, false};
}

void write_modes(const GivenEquilibrium& state, const ModeSet& found, std::size_t count, double zero, Modes* result) {
  const Model& model = state.model();
  const std::size_t numbers = 3 * model.num_points();
  result->shapes.resize(count * numbers);
  std::vector<double> inner(numbers, 0.0);
  for (std::size_t j = 0; j < count; ++j) {
    const double omega2 = found.omega2[static_cast<Eigen::Index>(j)];
    const bool is_zero = std::abs(omega2) <= zero;
    result->omega.push_back(is_zero ? 0.0 : std::copysign(std::sqrt(std::abs(omega2)), omega2));
    result->zero_modes += is_zero ? 1 : 0;
    result->unstable_directions += result->omega.back() < 0.0 ? 1 : 0;
    const auto shape = found.shapes.col(static_cast<Eigen::Index>(j));
    std::copy(shape.begin(), shape.end(), inner.begin());
    model.numbering.scatter_points(inner, std::span(result->shapes).subspan(j * numbers, numbers));
  }
}

Modes& fail(Modes& result, Status status, std::string what) {
  result.outcome = {status, std::move(what)};
  return result;
}

}  // namespace

Modes modes(const System& system, std::span<const double> positions, const ModesOptions& options) {
  if (options.damped)
    throw InputError("/modes/damped", "found true, wanted false: vibrations are those without damping");
  const QuietTraps quiet;
  const std::unique_ptr<GivenEquilibrium> standing = GivenEquilibrium::stand_at(
      system, {positions, options.multipliers, options.force_tolerance}, describe_system(options));
  GivenEquilibrium& state = *standing;
  const Model& model = state.model();
  Modes result;
  result.left_out = state.left_out();
  add_damping(system, &result.left_out);
  result.degrees_of_freedom = state.degrees_of_freedom();
  result.multipliers.resize(model.numbering.num_user_rows);
  model.numbering.scatter_rows(state.multipliers(), result.multipliers);
  const Plan plan = make_plan(result.degrees_of_freedom, state.equations().size(), options.count);

  if (const double asymmetry = state.equations().stiffness().asymmetry(); asymmetry > allowed_asymmetry) {
    return fail(result, Status::NoSolution,
                "not conservative: the stiffness matrix is unsymmetric by " + text(asymmetry) +
                    " of its largest entry, so some force has no potential, and vibrations may gain energy");
  }
  if (options.multipliers.empty() && options.prestress.empty()) {
    if (const std::string rows = state.find_ambiguous_stiffness(); !rows.empty())
      return fail(result, Status::NotUnique,
                  "rods pull against each other by a self-stress that the forces do not determine, and the stiffness "
                  "depends on it (" + rows + "); a prestress must be given");
  }
  KktSolver kkt(state.equations());
  ModeFinder finder(state.equations(), kkt, result.degrees_of_freedom);
  const ModeSet found = plan.is_dense ? finder.find_all() : finder.find_lowest(plan.count, options.tolerance);
  if (!found.outcome.ok()) return fail(result, found.outcome.status, found.outcome.what);
  const double zero = std::max(rounding, share_of_residual * state.relative_residual()) * finder.scale();
  write_modes(state, found, plan.count, zero, &result);
  result.residual_max = found.residual;
  if (result.zero_modes > 0) {
    result.rigid_zero_modes =
        std::min(result.zero_modes, count_rigid_modes(state.equations(), state.positions()));
  }
  return result;
}

}  // namespace tanor
