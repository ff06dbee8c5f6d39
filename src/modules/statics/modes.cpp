#include <tanor/modes.hpp>

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>

#include "base/quiet_traps.hpp"
#include "base/text.hpp"
#include "statics/damped_modes.hpp"
#include "statics/forces_without_potential.hpp"
#include "statics/given_equilibrium.hpp"
#include "statics/mode_finder.hpp"
#include "statics/rigid_modes.hpp"
#include "statics/stability.hpp"

namespace tanor {
using namespace detail;

namespace {

/// Up to this many freedoms all modes are found by dense matrices, which may have at most `most_dense_numbers` numbers.
constexpr std::size_t most_dense_freedoms = 300, most_dense_numbers = 50'000'000;
/// Part of the scale of omega^2 below which damped modes count as zero.
constexpr double rounding = 1e-12;

/// Notes the forces that act on velocities only and are left out.
void leave_out_damping(const System& system, bool damped, std::vector<std::string>* left_out) {
  for (std::size_t k = 0; k < system.forces.size(); ++k) {
    const std::string name = force_name(system, k);
    if (const auto* const springs = std::get_if<Springs>(&system.forces[k]);
        springs != nullptr && springs->damping > 0.0 && !damped)
      left_out->push_back(name + ": its damping takes no part in vibrations");
    const auto* const drag = std::get_if<Drag>(&system.forces[k]);
    if (drag == nullptr) continue;
    if (!damped)
      left_out->push_back(name + ": drag acts on what moves");
    else if (drag->quadratic > 0.0)
      left_out->push_back(name + ": quadratic drag vanishes in small motions");
  }
}

/// Plan of the search: the number of modes, and whether all are found by dense matrices or the lowest ones.
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

/// Returns a column of real numbers for each mode, in the user's order.
std::vector<double> scatter_shapes(const Model& model, const Eigen::Ref<const Eigen::MatrixXd>& shapes) {
  const std::size_t numbers = 3 * model.num_points(), count = static_cast<std::size_t>(shapes.cols());
  std::vector<double> result(count * numbers), inner(numbers, 0.0);
  for (std::size_t j = 0; j < count; ++j) {
    const auto shape = shapes.col(static_cast<Eigen::Index>(j));
    std::copy(shape.begin(), shape.end(), inner.begin());
    model.numbering.scatter_points(inner, std::span(result).subspan(j * numbers, numbers));
  }
  return result;
}

void write_modes(const Model& model, const ModeSet& found, std::size_t count, const ZeroModes& zero, Modes* result) {
  result->shapes = scatter_shapes(model, found.shapes.leftCols(static_cast<Eigen::Index>(count)));
  for (Eigen::Index j = 0; j < found.omega2.size(); ++j) {
    const double omega2 = found.omega2[j];
    const bool is_zero = std::abs(omega2) <= zero.of_mode(found.shapes.col(j)),
               is_wanted = j < static_cast<Eigen::Index>(count);
    result->unstable_directions += !is_zero && omega2 < 0.0 ? 1 : 0;
    if (!is_wanted) continue;
    result->omega.push_back(is_zero ? 0.0 : std::copysign(std::sqrt(std::abs(omega2)), omega2));
    result->zero_modes += is_zero ? 1 : 0;
  }
}

/// Finds the lowest modes. If all of those asked for grow, the total number of growing modes is counted.
Outcome find_modes(const GivenEquilibrium& state, const Plan& plan, double tolerance, ModeFinder* finder,
                   KktSolver* kkt, Modes* result) {
  const ModeSet found = plan.is_dense ? finder->find_all() : finder->find_lowest(plan.count, tolerance);
  if (!found.outcome.ok()) return found.outcome;
  ZeroModes zero(state.equations(), plan.is_dense ? ZeroModes::Found::ByDenseMatrices : ZeroModes::Found::ByFactor);
  zero.raise(state.residuals());
  write_modes(state.model(), found, plan.count, zero, result);
  result->residual_max = found.residual;
  if (plan.is_dense || result->unstable_directions < plan.count) return {};
  const std::optional<std::size_t> all = count_near(-1.0, zero, kkt);
  if (!all) return {Status::NotConverged, "pivots vanish below zero: it is not known how many modes grow"};
  result->unstable_directions = *all;
  return {};
}

/// Writes damped modes. A real part below the rounding of the fastest motion counts as zero.
void write_damped_modes(const Model& model, const DampedModeSet& found, std::size_t count, double zero, Modes* result) {
  constexpr double rounding_of_decay = 1e-12;
  const auto kept = static_cast<Eigen::Index>(std::min(count, static_cast<std::size_t>(found.lambda.size())));
  const double fastest = found.lambda.size() > 0 ? found.lambda.cwiseAbs().maxCoeff() : 0.0;
  result->shapes = scatter_shapes(model, found.shapes.leftCols(kept).real());
  result->shapes_imaginary = scatter_shapes(model, found.shapes.leftCols(kept).imag());
  for (Eigen::Index k = 0; k < found.lambda.size(); ++k) {
    const std::complex<double>& lambda = found.lambda[k];
    const bool is_zero = std::norm(lambda) <= zero, decays = std::abs(lambda.real()) > rounding_of_decay * fastest;
    const double decay = is_zero || !decays ? 0.0 : -lambda.real();
    result->unstable_directions += decay < 0.0 ? 1 : 0;
    if (k >= kept) continue;
    result->omega.push_back(is_zero ? 0.0 : lambda.imag());
    result->decay.push_back(decay);
    result->zero_modes += is_zero ? 1 : 0;
  }
}

Modes& fail(Modes& result, Status status, std::string what) {
  result.outcome = {status, std::move(what)};
  return result;
}

/// Returns what makes the stiffness useless; ok if nothing does.
Outcome find_obstacle(GivenEquilibrium& state, std::span<const double> positions, const ModesOptions& options) {
  const double asymmetry = options.damped ? 0.0 : state.equations().stiffness().asymmetry();
  if (asymmetry > symmetric_to) {
    return {Status::NoSolution,
            "not conservative: the stiffness matrix is unsymmetric by " + text(asymmetry) +
                " of its largest entry, by forces without a potential (" +
                name_forces_without_potential(state.model().system, std::vector(positions.begin(), positions.end()),
                                              options.time, state.equations().stiffness().largest()) +
                "), and vibrations may gain energy; \"damped\": true takes it as it is"};
  }
  if (!options.multipliers.empty() || !options.prestress.empty()) return {};
  const std::string rows = state.find_ambiguous_stiffness();
  if (rows.empty()) return {};
  return {
      Status::NotUnique,
      "rods pull against each other by a self-stress that the forces do not determine, and the stiffness depends on "
      "it (" +
          rows + "); a prestress must be given"};
}

/// Finds the modes of a system whose constraints all act both ways.
Modes find_modes_about(const System& system, std::span<const double> positions, const ModesOptions& options) {
  const std::unique_ptr<GivenEquilibrium> standing = GivenEquilibrium::stand_at(
      system, {positions, options.multipliers, options.force_tolerance}, system_options(options));
  GivenEquilibrium& state = *standing;
  const Model& model = state.model();
  Modes result;
  result.left_out = state.left_out();
  leave_out_damping(system, options.damped, &result.left_out);
  if (!options.damped) {
    for (const std::string& name :
         list_formulas_on_velocities(model.system, {positions.begin(), positions.end()}, options.time))
      result.left_out.push_back(name + ": what depends on velocities takes no part in vibrations");
  }
  result.degrees_of_freedom = state.degrees_of_freedom();
  state.write_forces(&result.multipliers, &result.reactions, &result.support_forces);
  const Plan plan = make_plan(result.degrees_of_freedom, state.equations().size(), options.count);
  if (Outcome outcome = find_obstacle(state, positions, options); !outcome.ok()) {
    for (std::vector<double>* const forces : {&result.multipliers, &result.reactions, &result.support_forces})
      std::ranges::fill(*forces, std::numeric_limits<double>::quiet_NaN());
    return fail(result, outcome.status, std::move(outcome.what));
  }
  if (model.num_moving() == 0) return result;
  KktSolver kkt(state.equations());
  ModeFinder finder(state.equations(), kkt, result.degrees_of_freedom, state.dependent_rows());
  const double lightest = std::ranges::min(std::span(model.mass).first(model.num_moving())),
               residual = std::ranges::max(state.residuals());
  const double zero =
      std::max(rounding * finder.scale(), ZeroModes::share_of_residual * residual / (model.smallest_length * lightest));
  const bool feels_coriolis = state.feels_coriolis(), has_rates = options.damped || feels_coriolis;
  Eigen::SparseMatrix<double> D = state.equations().find_coriolis();
  if (options.damped) D += state.equations().stiffness().find_damping(options.time, state.positions().data());
  if (has_rates) {
    const std::optional<Eigen::MatrixXd> basis = plan.is_dense ? finder.find_basis() : std::nullopt;
    if (plan.is_dense && !basis) return fail(result, Status::Singular, "the stiffness matrix has no factor");
    const DampedModeSet found =
        plan.is_dense ? find_damped_modes(state.equations(), D, *basis, std::sqrt(zero))
                      : find_lowest_damped_modes(state.equations(), D, plan.count, result.degrees_of_freedom,
                                                 std::sqrt(finder.scale()), std::sqrt(zero));
    if (!found.outcome.ok()) return fail(result, found.outcome.status, found.outcome.what);
    write_damped_modes(model, found, options.count, zero, &result);
    result.residual_max = found.residual;
  } else {
    if (Outcome outcome = find_modes(state, plan, options.tolerance, &finder, &kkt, &result); !outcome.ok())
      return fail(result, outcome.status, outcome.what);
  }
  if (result.zero_modes > 0)
    result.rigid_zero_modes = std::min(result.zero_modes, count_rigid_modes(state.equations(), state.positions()));
  return result;
}

}  // namespace

Modes modes(const System& system, std::span<const double> positions, const ModesOptions& options) {
  const QuietTraps quiet;
  return find_with_closed(system, positions, options, [&](const System& held, const ModesOptions& chosen) {
    return find_modes_about(held, positions, chosen);
  });
}

}  // namespace tanor
