#include <tanor/equilibrium.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "base/quiet_traps.hpp"
#include "base/text.hpp"
#include "dynamics/prestress_rigidity.hpp"
#include "statics/damped_modes.hpp"
#include "statics/forces_without_potential.hpp"
#include "statics/mode_finder.hpp"
#include "statics/newton_descent.hpp"
#include "statics/one_sided.hpp"
#include "statics/projected_descent.hpp"
#include "statics/smallest_multipliers.hpp"
#include "statics/stability.hpp"
#include "statics/standing_corner.hpp"
#include "statics/statics_input.hpp"
#include "statics/stiffening_stress.hpp"
#include "statics/unbalanced_load.hpp"

namespace tanor {
using namespace detail;
namespace {

/// The search for one system from one start; arrays are in the inner order.
class Search {
 public:
  Search(System system, const SteadyFrame& frame, const EquilibriumOptions& options,
         const std::vector<double>& prestress, EquilibriumResult* result)
      : options_(options),
        frame_(frame),
        result_(*result),
        work_(std::move(system), options.solver, 0.0),
        model_(work_.model()),
        equations_(work_, options.at, frame.spin),
        multipliers_(equations_, options.solver),
        newton_(equations_, options.solver.ordering),
        prestress_(model_.num_rows(), 0.0) {
    for (std::size_t a = 0; a < prestress_.size(); ++a)
      prestress_[a] = prestress[static_cast<std::size_t>(model_.numbering.user_row[a])];
  }

  /// Returns the points that K alone would let move, but that rods under tension hold.
  std::vector<Index> find_rigid_points() {
    if (model_.num_rows() == 0 || newton_.measure(state_).violation > on_constraints) return {};
    std::vector<double> found;
    if (!multipliers_.find(state_.r, prestress_, &found).ok()) return {};
    return find_prestress_rigid_points(model_.system, multipliers_.rank().dependences);
  }

  void start_at(const std::vector<double>& positions, const std::vector<double>* multipliers) {
    state_.r.resize(3 * model_.num_points());
    model_.numbering.gather_points(positions, state_.r);
    work_.set_time(options_.at);
    work_.prescribe_all(options_.at, state_.r.data(), std::vector<double>(state_.r.size()).data());
    if (multipliers != nullptr)
      state_.lambda = *multipliers;
    else
      choose_start_multipliers();
  }

  /// Finds an equilibrium; if `assesses_stability`, its stability decides whether it is accepted.
  Outcome run(bool assesses_stability) {
    Stability& status = result_.stability.status;
    result_.stability = {};
    if (model_.num_moving() == 0) {
      if (const double violation = newton_.measure(state_).violation; violation > on_constraints)
        return {Status::NoSolution,
                "there is no equilibrium: no point can move, and supports alone violate a "
                "constraint by " +
                    text(violation) + " of its length"};
      status = Stability::Stable;
      return {};
    }
    if (std::string load = find_unbalanced_load(equations_, state_.r); !load.empty())
      return {Status::NoSolution, "there is no equilibrium: " + load};
    const bool may_leave = options_.method != EquilibriumMethod::Newton && options_.accept != AcceptedEquilibria::Any;
    if (Outcome outcome = search_from_smallest(search()); !outcome.ok() || !assesses_stability) return outcome;
    // Residual forces give a little stiffness to motions that cost nothing, so Newton's method removes those forces
    // first.
    if (equations_.size() <= most_dense_unknowns) {
      refine();
      decide_rank();
    }
    if (Outcome outcome = classify(); !outcome.ok()) return outcome;
    if (may_leave) leave_unstable();
    const bool is_wanted = options_.accept == AcceptedEquilibria::Any || status == Stability::Stable ||
                           (options_.accept == AcceptedEquilibria::Marginal && status == Stability::Marginal);
    if (is_wanted) return {};
    if (status == Stability::NotConservative)
      return {Status::NoSolution,
              "the equilibrium is not accepted: forces without a potential act (" + without_potential_ +
                  "), so that energy does not say whether it is stable; \"accept\": \"any\" takes it"};
    const bool is_marginal = status == Stability::Marginal;
    return {Status::NoSolution,
            std::string("the equilibrium is not accepted: it is ") +
                (is_marginal && inertia_.negative > 0
                     ? "marginal: the energy falls in " + text_of_count(inertia_.negative, "direction") +
                           ", and Coriolis forces alone hold it"
                 : is_marginal ? "marginal, with " + text_of_count(inertia_.zero - inertia_.rigid_zero, "zero mode") +
                                     " beyond those of islands as a whole"
                               : "unstable in " + text_of_count(inertia_.negative, "direction") +
                                     ", lowest omega^2 = " + text(inertia_.lowest) + "; most move the points " +
                                     name_points_that_move())};
  }

  /// Writes residuals, multipliers, energy and stability of the equilibrium.
  void describe() {
    decide_rank();
    if (!smallest_.empty()) {
      result_.multipliers_unique = rank_.multipliers_unique;
      for (const RowDependence& dependence : rank_.dependences) result_.dependences.push_back(dependence.what);
      result_.self_stress_states = count_self_stress();
      note_useless_prestress(prestress_, result_.self_stress_states, &result_.left_out);
      const Stability status = result_.stability.status;
      const bool stability_is_known = status != Stability::None && status != Stability::NotConservative;
      if (result_.self_stress_states > 0 && stability_is_known && options_.prestress.empty())
        result_.left_out.push_back(
            "stability: that with the multipliers that this result tells, since the load does not determine how rods "
            "pull against "
            "each other (" +
            text_of_count(result_.self_stress_states, "state") + " of self-stress)");
    }
    const StaticResidual residual = newton_.measure(state_);
    if (result_.self_stress_states > 0)
      note_changed_prestress(equations_, prestress_, state_.lambda, &result_.left_out);
    result_.residual_force = residual.force;
    result_.largest_force = model_.num_moving() > 0 ? residual.scale : std::numeric_limits<double>::quiet_NaN();
    result_.violation = residual.violation;
    result_.energy = equations_.energy(state_.r.data());
  }

  void write() {
    const std::size_t size = state_.r.size();
    const auto scatter = [&](const std::vector<double>& inner, std::vector<double>* user) {
      user->assign(size, 0.0);
      std::vector<double> all = inner;
      all.resize(size, 0.0);
      model_.numbering.scatter_points(all, *user);
    };
    scatter(state_.r, &result_.positions);
    result_.velocities.assign(size, 0.0);
    for (std::size_t i = 0; i < model_.num_points(); ++i)
      store(result_.velocities.data(), i, frame_.velocity_at(load(result_.positions.data(), i)));
    equations_.write_forces(state_.lambda, &result_.multipliers, &result_.reactions, &result_.support_forces);
    if (const std::vector<double> stress = multipliers_.find_self_stress();
        !stress.empty() && options_.prestress.empty()) {
      result_.self_stress.resize(model_.numbering.num_user_rows);
      model_.numbering.scatter_rows(stress, result_.self_stress);
    }
    if (!inertia_.shape.empty()) scatter(inertia_.shape, &result_.stability.lowest_shape);
  }

  const StaticState& state() const { return state_; }
  std::vector<double> positions() const {
    std::vector<double> result(state_.r.size());
    model_.numbering.scatter_points(state_.r, result);
    return result;
  }

  const System& system() const { return model_.system; }

 private:
  Outcome search() {
    EquilibriumSearch& report = result_.search;
    const NewtonLimits limits{options_.force_tolerance, options_.max_iterations};
    equations_.linearise(state_.r.data(), state_.lambda.data());
    report.method_used = EquilibriumMethod::Newton;
    if (work_.forces.has_formulas()) {
      if (options_.method == EquilibriumMethod::Descent)
        result_.left_out.push_back(
            "descent: forces by formulas may have no potential, Newton's method goes without it");
      return search_by_newton(limits);
    }
    if (options_.method == EquilibriumMethod::Descent) {
      if (Outcome outcome = descend(limits); !outcome.ok()) return outcome;
      return search_by_newton(limits);
    }
    const StaticState start = state_;
    Outcome outcome = search_by_newton(limits);
    const bool is_stuck = outcome.status == Status::NotConverged || outcome.status == Status::NotFinite;
    if (!is_stuck || options_.method != EquilibriumMethod::Auto) return outcome;
    // Descent gets past slack shapes, where Newton's method may stall, and past points that coincide.
    const StaticState stalled = std::exchange(state_, start);
    if (descend(limits).ok() && search_by_newton(limits).ok()) return {};
    state_ = stalled;
    report.method_used = EquilibriumMethod::Newton;
    return outcome;
  }

  Outcome search_by_newton(const NewtonLimits& limits) {
    Outcome outcome = newton_.run(limits, &state_, &result_.search.residuals);
    result_.search.iterations += newton_.iterations();
    result_.search.factorizations += newton_.factorizations();
    if (outcome.ok() && newton_.have_forces_vanished(limits)) position_error_ = newton_.last_move();
    return outcome;
  }

  Outcome descend(const NewtonLimits& limits) {
    result_.search.method_used = EquilibriumMethod::Descent;
    return descend_along_constraints(equations_, multipliers_, limits, &state_, &result_.search.residuals,
                                     &result_.search.iterations);
  }

  /// Continues the search from the smallest multipliers. If the load does not determine all multipliers, as in a net
  /// that has collapsed, Newton's method may have ended with any of them, or without an equilibrium.
  Outcome search_from_smallest(Outcome before) {
    constexpr double near = 1e-3;
    const StaticResidual here = newton_.measure(state_);
    if (!before.ok() && !(here.relative_force() < near && here.violation < near)) return before;
    decide_rank();
    if (smallest_.empty() || count_self_stress() == 0) return before;
    if (!(newton_.measure({state_.r, smallest_}).relative_force() < near)) return before;
    const StaticState ended = state_;
    state_.lambda = smallest_;
    Outcome outcome = search();
    outcome.ok() ? refine() : void(state_ = ended);
    decide_rank();
    take_smallest();
    return outcome.ok() ? outcome : before;
  }

  /// Iterates to rounding. Rods that coincide then do so exactly, and motions from there see which rows depend.
  void refine() {
    constexpr int most_steps = 8;
    StaticState refined = state_;
    std::vector<double> residuals;
    (void)newton_.run({std::numeric_limits<double>::epsilon(), most_steps}, &refined, &residuals);
    const StaticResidual before = newton_.measure(state_), after = newton_.measure(refined);
    if (after.force <= before.force && after.violation <= std::max(before.violation, 1e-15))
      state_ = std::move(refined);
  }

  /// Replaces the multipliers by the smallest ones if those balance the load as well.
  void take_smallest() {
    const double allowed = std::max(newton_.measure(state_).force, 1e-9 * newton_.residual().scale);
    if (!smallest_.empty() && count_self_stress() > 0 && newton_.measure({state_.r, smallest_}).force <= allowed)
      state_.lambda = smallest_;
  }

  void decide_rank() {
    if (decided_at_ == state_.r) return;
    decided_at_ = state_.r;
    if (!multipliers_.find_and_decide(state_.r, prestress_, &smallest_, &rank_).ok()) smallest_.clear();
  }

  std::size_t count_self_stress() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(rank_.dependences, [](const RowDependence& each) { return !each.terms.empty(); }));
  }

  /// Moves the points along the mode that lowers the energy most.
  void move_along_lowest_shape() {
    constexpr double far = 0.05;  // of the scene's size
    const double move = far * model_.scene_size / longest(inertia_.shape);
    for (std::size_t i = 0; i < inertia_.shape.size(); ++i) state_.r[i] += move * inertia_.shape[i];
  }

  /// Leaves an unstable equilibrium for a stable one elsewhere.
  void leave_unstable() {
    constexpr int most_times = 12;
    for (int time = 0; time < most_times && result_.stability.status == Stability::Unstable && !inertia_.shape.empty();
         ++time) {
      const StaticState unstable = state_;
      move_along_lowest_shape();
      result_.left_out.push_back(
          "an unstable equilibrium on the way, left along its lowest mode (omega^2 = " + text(inertia_.lowest) + ")");
      Outcome outcome = search_from_smallest(search());
      if (outcome.ok()) outcome = classify();
      if (!outcome.ok()) {
        state_ = unstable;
        decide_rank();
        (void)classify();
        result_.left_out.push_back("beyond it " + outcome.what);
        return;
      }
    }
  }

  Outcome classify() {
    StabilityReport& stability = result_.stability;
    if (options_.prestress.empty()) equations_.forget_idle_multipliers(state_.r.data(), &state_.lambda);
    equations_.linearise(state_.r.data(), state_.lambda.data());
    if (equations_.stiffness().asymmetry() > symmetric_to) {
      stability.status = Stability::NotConservative;
      without_potential_ =
          name_forces_without_potential(model_.system, positions(), options_.at, equations_.stiffness().largest());
      result_.left_out.push_back("stability: forces without a potential act (" + without_potential_ +
                                 "), so that energy does not say what a small push does; damped modes do");
      return {};
    }
    inertia_ = find_inertia_with(state_.lambda);
    if (count_self_stress() > 0 && options_.prestress.empty()) {
      const auto find = [this](const std::vector<double>& lambda) { return find_inertia_with(lambda); };
      choose_self_stress(equations_, multipliers_, find, state_.r, &state_.lambda, &inertia_);
    }
    if (!inertia_.is_known) {
      stability.status = Stability::None;
      return {Status::NotConverged, "it rests there, but pivots vanish on both sides of zero: stability is not known"};
    }
    const std::optional<std::size_t> growing = count_growing();
    if (!growing) {
      stability.status = Stability::None;
      return {Status::NotConverged, "it rests there, but its energy falls in " +
                                        text_of_count(inertia_.negative, "direction") +
                                        ", in which Coriolis forces may hold it: that is decided up to " +
                                        std::to_string(most_dense_unknowns) + " unknowns"};
    }
    stability.unstable_directions = *growing;
    stability.zero_modes = inertia_.zero;
    stability.rigid_zero_modes = inertia_.rigid_zero;
    stability.lowest_omega2 = inertia_.lowest;
    const bool is_held = inertia_.negative > 0 && *growing == 0;
    if (is_held)
      result_.left_out.push_back("stability: the energy falls in " + text_of_count(inertia_.negative, "direction") +
                                 ", in which Coriolis forces hold small motions as long as nothing slows them");
    stability.status = *growing > 0                                     ? Stability::Unstable
                       : is_held || inertia_.zero > inertia_.rigid_zero ? Stability::Marginal
                                                                        : Stability::Stable;
    return {};
  }

  /// Returns the number of motions that grow. At rest, and where nothing couples motions across the axis, these are all
  /// in which the energy falls. In a frame that turns Coriolis forces may hold an even number of them (Thomson and Tait
  /// 1879): with an odd one the roots lambda have a negative product. Returns nothing if that is not known.
  std::optional<std::size_t> count_growing() {
    if (!frame_.turns() || inertia_.negative == 0) return inertia_.negative;
    if (equations_.size() > most_dense_unknowns)
      return inertia_.negative % 2 == 1 ? std::optional(inertia_.negative) : std::nullopt;
    constexpr double none = 1e-12, of_double_roots = 1e-7;  // relative to the fastest motion
    equations_.linearise(state_.r.data(), state_.lambda.data());
    ModeFinder finder(equations_, newton_.solver(), rank_.degrees_of_freedom, list_dependent_rows(model_, rank_));
    const std::optional<Eigen::MatrixXd> basis = finder.find_basis();
    if (!basis) return std::nullopt;
    const DampedModeSet modes =
        find_damped_modes(equations_, equations_.find_coriolis(), *basis, std::sqrt(none * finder.scale()));
    const double fastest = modes.lambda.size() > 0 ? modes.lambda.cwiseAbs().maxCoeff() : 0.0;
    return static_cast<std::size_t>((modes.lambda.real().array() > of_double_roots * fastest).count());
  }

  ReducedInertia find_inertia_with(const std::vector<double>& lambda) {
    const StaticResidual here = newton_.measure(state_);
    const double error = here.relative_force() <= options_.force_tolerance ? 0.0 : position_error_;
    equations_.linearise_near(state_.r.data(), lambda.data(), error);
    return find_inertia(equations_, state_.r, rank_.degrees_of_freedom, list_dependent_rows(model_, rank_),
                        &newton_.solver());
  }

  /// Starts with the multipliers that balance the load best, if they balance at least half of it, else with the
  /// prestress.
  void choose_start_multipliers() {
    std::vector<double> found;
    state_.lambda = prestress_;
    const StaticResidual before = newton_.measure(state_);
    if (!multipliers_.find(state_.r, prestress_, &found).ok()) return;
    const StaticResidual after = newton_.measure({state_.r, found});
    if (after.force < 0.5 * before.force && after.scale < 1e3 * before.scale) state_.lambda = std::move(found);
  }

  std::string name_points_that_move() const {
    std::vector<std::pair<double, Index>> moves;
    for (std::size_t i = 0; i < inertia_.shape.size() / 3; ++i)
      moves.push_back({-norm(load(inertia_.shape.data(), i)), model_.numbering.user_point[i]});
    std::sort(moves.begin(), moves.end());
    std::string names;
    for (std::size_t k = 0; k < std::min<std::size_t>(3, moves.size()); ++k)
      names += (k > 0 ? ", " : "") + std::to_string(moves[k].second);
    return names;
  }

  const EquilibriumOptions& options_;
  const SteadyFrame& frame_;
  EquilibriumResult& result_;
  Workspace work_;
  const Model& model_;
  EquilibriumEquations equations_;
  SmallestMultipliers multipliers_;
  NewtonDescent newton_;
  static constexpr double on_constraints = 1e-9;  // largest violation of what counts as satisfied
  std::vector<double> prestress_;                 // [rows]
  StaticState state_;
  std::vector<double> decided_at_;  // positions at which the rank was decided
  RankReport rank_;                 // rank of K there
  std::vector<double> smallest_;    // multipliers there [rows]; empty if there are none
  ReducedInertia inertia_;
  std::string without_potential_;  // forces by name
  double position_error_ = 0.0;    // m, a step of Newton's method at the end
};

/// Starts a search in which points held rigid by prestress become supports, as in a Simulation.
std::unique_ptr<Search> start_search(const System& system, const SteadyFrame& frame, const EquilibriumOptions& options,
                                     const std::vector<double>& prestress, const std::vector<double>& positions,
                                     EquilibriumResult* result) {
  const auto make = [&](const System& held) {
    auto search = std::make_unique<Search>(held, frame, options, prestress, result);
    search->start_at(positions, nullptr);
    return search;
  };
  const auto find = [&](Search& search) {
    return options.prestress.empty() ? search.find_rigid_points() : std::vector<Index>();
  };
  std::vector<Index> rigid;
  std::unique_ptr<Search> search = make_without_rigid_points(system, make, find, &rigid);
  if (!rigid.empty()) result->left_out.push_back(describe_rigid_points(rigid));
  return search;
}

}  // namespace
EquilibriumResult detail::rest_from(const System& system, const SteadyFrame& frame, const EquilibriumOptions& options,
                                    const std::vector<double>& prestress, const std::vector<double>& start,
                                    bool assesses_stability) {
  EquilibriumResult result;
  std::unique_ptr<Search> search;
  for (int step = 1; step <= options.load_steps; ++step) {
    const double factor = static_cast<double>(step) / static_cast<double>(options.load_steps);
    System loaded = options.load_steps > 1 ? with_load(system, factor, options.at) : system;
    if (!search) {
      search = start_search(loaded, frame, options, prestress, start, &result);
    } else {
      const StaticState before = search->state();
      const std::vector<double> positions = search->positions();
      loaded.supports = search->system().supports;
      search = std::make_unique<Search>(std::move(loaded), frame, options, prestress, &result);
      search->start_at(positions, &before.lambda);
    }
    result.outcome = search->run(assesses_stability);
    if (!result.outcome.ok() && result.stability.status == Stability::None) break;
  }
  search->describe();
  search->write();
  return result;
}

Solution state_at_rest(const EquilibriumResult& found, double time) {
  Solution state;
  state.time = time;
  state.positions = found.positions;
  state.velocities = found.velocities;
  state.multipliers = found.multipliers;
  state.reactions = found.reactions;
  state.support_forces = found.support_forces;
  state.self_stress = found.self_stress;
  state.has_prestress =
      found.outcome.ok() && std::ranges::any_of(state.multipliers, [](double each) { return std::isnan(each); });
  for (std::vector<double>* array : {&state.velocities, &state.reactions, &state.support_forces})
    array->resize(found.positions.size());
  const bool moves = std::ranges::any_of(state.velocities, [](double each) { return each != 0.0; });
  state.accelerations.assign(found.positions.size(), moves ? std::numeric_limits<double>::quiet_NaN() : 0.0);
  return state;
}

EquilibriumResult find_equilibrium(const System& system, const EquilibriumOptions& given) {
  const QuietTraps quiet;
  StaticsInput input(system, given);
  const EquilibriumOptions options = take_sides(&input.system, given);
  std::vector<std::string> left_out = std::move(input.left_out);
  for (std::size_t k = 0; k < system.forces.size(); ++k)
    if (std::holds_alternative<Drag>(system.forces[k]))
      left_out.push_back(force_name(system, k) + ": drag acts on what moves");
  EquilibriumResult result = options.one_sided.empty() ? rest_from(input.system, input.frame, options, input.prestress,
                                                                   input.system.positions, true)
                                                       : rest_with_one_sided(input, options);
  if (result.stability.status == Stability::None)  // no multipliers balance the forces
    for (std::vector<double>* each : {&result.multipliers, &result.reactions, &result.support_forces})
      std::ranges::fill(*each, std::numeric_limits<double>::quiet_NaN());
  result.left_out.insert(result.left_out.begin(), left_out.begin(), left_out.end());
  return refuse_standing_corner(system, options.at, std::move(result));
}

}  // namespace tanor
