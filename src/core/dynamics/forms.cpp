#include "dynamics/forms.hpp"

#include <algorithm>
#include <utility>

#include <tanor/warnings.hpp>

#include "dynamics/prestress_rigidity.hpp"
#include "dynamics/split.hpp"

namespace tanor::detail {

Forms::Forms(System system, const SolverOptions& options, double t, const Workspace::MakeTeam& make_team, Ranks* ranks)
    : work(std::move(system), options, t, make_team), start_time_(t) {
  Decisions all(ranks);
  const bool has_coordinates = all.any(!work.coordinates.empty()), has_constraints = all.any(model.num_rows() > 0);
  const auto refuse = [](const std::string& what) { throw InputError("/solver/form", what); };
  const bool is_asked_for = all.any(options.form == Form::Tangent || options.form == Form::Both);
  const auto wanted = static_cast<double>(options.form);
  if ((has_coordinates || is_asked_for) && all.largest(wanted) != all.smallest(wanted))
    refuse("some ranks ask for another form than others");
  if (!has_coordinates && options.form == Form::Tangent) refuse("the tangent form needs coordinates; none are given");
  if (!has_coordinates && options.form == Form::Both) refuse("both forms need coordinates too; none are given");
  if (has_coordinates && !has_constraints && options.form == Form::Normal)
    refuse("the normal form needs constraints; coordinates alone are given");
  if (has_coordinates && !has_constraints && options.form == Form::Both)
    refuse("both forms need constraints too; coordinates alone are given");
  if (has_constraints || !has_coordinates) normal = std::make_unique<MultiplierForm>(work, options);
  if (has_coordinates) tangent = std::make_unique<TangentForm>(work, options);
  if (tangent != nullptr && model.has_friction()) tangent->dynamics().take_friction_from(normal.get());
  choose(options.form, all);
  make_plan();
  if (ranks != nullptr) main->join(*ranks);
}

/// Chooses the cheaper one of the available forms. A mechanism with few coordinates gets the tangent form, a chain the
/// normal form.
void Forms::choose(Form wanted, Decisions& all) {
  const auto is_cheaper = [&] {
    return all.sum(normal->predicted_flops() - tangent->dynamics().completed().predicted_flops()) >= 0.0;
  };
  const bool prefers_tangent =
      normal == nullptr || (tangent != nullptr && !all.any(model.has_friction()) && is_cheaper());
  const bool is_tangent = wanted == Form::Tangent || (wanted != Form::Normal && tangent != nullptr && prefers_tangent);
  reason_ = prefers_tangent == is_tangent ? "more flops" : "the other one was asked for";
  main = is_tangent ? static_cast<EquationsOfMotion*>(tangent.get()) : normal.get();
}

void Forms::make_plan() {
  plan.points = model.num_points();
  plan.supports = plan.points - model.num_moving();
  plan.equations = model.numbering.num_user_rows;
  plan.coordinates = work.coordinates.num_coordinates();
  plan.islands = is_tangent() ? work.coordinates.island_start().size() - 1 : model.numbering.num_islands();
  plan.form = is_tangent() ? Form::Tangent : Form::Normal;
  for (std::size_t a = model.numbering.first_idle_row(); a < model.num_rows(); ++a) {
    plan.idle_equations.push_back(static_cast<std::size_t>(model.numbering.user_row[a]));
  }
  std::sort(plan.idle_equations.begin(), plan.idle_equations.end());
  auto& left_out = plan.left_out;
  if (!model.has_friction()) left_out.push_back("friction: constraints are ideal");
  if (model.num_rows() > 0 && has_one_mass(model))
    left_out.push_back("second factorization for the parts along and across the motion: all points have one mass");
  if (tangent == nullptr) left_out.push_back("coordinates: none are given");
  if (normal == nullptr) left_out.push_back("constraints: none are given");
  if (normal != nullptr && !work.team().is_alone())
    left_out.push_back("which forces are not unique: nobody looks where ranks share an island");
  if (normal != nullptr && tangent != nullptr)
    left_out.push_back(std::string(is_tangent() ? "steps by constraints: " : "steps in coordinates: ") + reason_);
  if (normal != nullptr) plan.normal_flops = normal->predicted_flops();
  if (tangent != nullptr) plan.tangent_flops = tangent->dynamics().completed().predicted_flops();
  main->describe(&plan);
  if (!model.has_moving_supports()) left_out.push_back("support motion: every support is fixed");
  if (!main->has_work()) left_out.push_back("work integral: energy is conserved");
  if (!work.forces.has_springs()) left_out.push_back("spring forces: none");
  if (!work.forces.has_pairs()) left_out.push_back("pair forces: none");
  for (std::string& warning : find_warnings(model.system)) left_out.push_back(std::move(warning));
}

StartReport Forms::start(double t, double* r, double* v, StartMode mode) {
  return main->start_together([&] { return start_here(t, r, v, mode); });
}

StartReport Forms::start_here(double t, double* r, double* v, StartMode mode) {
  if (tangent == nullptr || normal == nullptr) return main->start(t, r, v, mode);
  StartReport placed = tangent->start(t, r, v, mode);
  if (!placed.outcome.ok()) return placed;
  StartReport report = is_tangent() ? placed : normal->start(t, r, v, mode);
  if (report.outcome.ok()) check_completeness(t, r);
  report.position_correction = std::max(report.position_correction, placed.position_correction);
  report.velocity_correction = std::max(report.velocity_correction, placed.velocity_correction);
  report.relative = std::max(report.relative, placed.relative);
  return report;
}

Outcome Forms::compare(const Kinematics& at, const Request& request, const double* w, const double* eta,
                       double* disagreement) {
  for (std::vector<double>* array : {&other_w_, &other_eta_}) array->resize(3 * model.num_points());
  if (Outcome outcome = solve_other(at, request, other_w_.data(), other_eta_.data()); !outcome.ok()) return outcome;
  double w_error = 0.0, w_scale = 0.0, eta_error = 0.0, eta_scale = 0.0;
  for (std::size_t i = 0; i < model.num_moving(); ++i) {
    const Vec3 f = load(work.f.data(), i);
    w_error = larger(w_error, norm(load(w, i) - load(other_w_.data(), i)));
    eta_error = larger(eta_error, norm(load(eta, i) - load(other_eta_.data(), i)));
    w_scale = std::max({w_scale, norm(load(w, i)), model.inverse_mass[i] * norm(f)});
    eta_scale = std::max({eta_scale, norm(load(eta, i)), norm(f)});
  }
  const auto relative = [](double error, double scale) { return scale > 0.0 ? error / scale : error; };
  *disagreement = larger(relative(w_error, w_scale), relative(eta_error, eta_scale));
  return {};
}

Outcome Forms::reactions(const Configuration& at, const Request& request, const Reactions& found, double* lambda,
                         double* eta) {
  if (eta != nullptr) main->write_reactions(at.own, found, eta);
  if (normal == nullptr) return {};
  if (is_tangent()) {
    scratch_.resize(3 * model.num_points());
    Outcome outcome = normal->accelerations(at.points, request, {scratch_.data(), nullptr, nullptr, &found_});
    if (!outcome.ok()) return outcome;
  }
  const std::vector<double>& own = (is_tangent() ? found_ : found).lambda;
  std::copy(own.begin(), own.end(), lambda);
  normal->minimize_multipliers(at.points, lambda);
  if (!is_tangent() || eta == nullptr) return {};
  // At supports, eta is the force of the constraints.
  normal->write_reactions(at.points, found_, scratch_.data());
  const auto first_support = static_cast<std::ptrdiff_t>(3 * model.num_moving());
  std::copy(scratch_.begin() + first_support, scratch_.end(), eta + first_support);
  return {};
}

double Forms::degrees_of_freedom() const {
  // With coordinates alone there are as many degrees of freedom as coordinates.
  if (normal == nullptr) return static_cast<double>(work.coordinates.num_coordinates());
  return 3.0 * static_cast<double>(model.num_moving()) - static_cast<double>(work.rank) +
         static_cast<double>(work.constraints.open.size());
}

RankReport Forms::rank(const double* r, bool thoroughly) {
  RankReport report;
  double freedoms = degrees_of_freedom();
  if (normal == nullptr) {
    report.is_known = false;
  } else if (work.team().is_alone()) {
    if (thoroughly) (void)normal->linearization().decide_rank_again(r, RankScope::AllRows);
    report = normal->linearization().dependences().report();
    report.prestress_rigid_points = find_prestress_rigid_points(model.system, report.dependences);
    freedoms = static_cast<double>(report.degrees_of_freedom);
  } else {
    report.rank = work.rank;
  }
  report.is_known = main->any(report.is_known);
  report.rank = static_cast<std::size_t>(main->sum(static_cast<double>(report.rank)));
  report.degrees_of_freedom = static_cast<std::size_t>(main->sum(freedoms));
  return report;
}

Outcome Forms::solve_other(const Kinematics& at, const Request& request, double* w, double* eta) {
  const auto [t, r, v] = at;
  EquationsOfMotion* const other = is_tangent() ? static_cast<EquationsOfMotion*>(normal.get()) : tangent.get();
  for (std::vector<double>* array : {&x_, &x_dot_, &x_ddot_}) array->resize(other->size());
  std::vector<double> places(r, r + 3 * model.num_points()), rates(v, v + 3 * model.num_points());
  if (Outcome outcome = other->set_state(t, r, v, x_.data(), x_dot_.data()); !outcome.ok()) return outcome;
  const Kinematics there{t, x_.data(), x_dot_.data()};
  Outcome outcome = other->accelerations(there, request, {x_ddot_.data(), nullptr, nullptr, &found_});
  if (!outcome.ok()) return outcome;
  other->write_points(there, x_ddot_.data(), found_, places.data(), rates.data(), w);
  other->write_reactions(there, found_, eta);
  return outcome;
}

}  // namespace tanor::detail
