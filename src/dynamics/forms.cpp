#include "dynamics/forms.hpp"

#include <algorithm>

#include "dynamics/taut.hpp"

namespace tanor {

Forms::Forms(System system, const SolverOptions& options, double t)
    : model(std::move(system), options, t), start_time_(t) {
  const bool has_coordinates = !model.coordinates.empty(), has_constraints = model.num_rows() > 0;
  const auto refuse = [](const std::string& what) { throw InputError("/solver/form", what); };
  if (!has_coordinates && options.form == Form::Tangent) refuse("the tangent form needs coordinates; none are given");
  if (!has_coordinates && options.form == Form::Both) refuse("both forms need coordinates too; none are given");
  if (has_coordinates && !has_constraints && options.form == Form::Normal)
    refuse("the normal form needs constraints; coordinates alone are given");
  if (has_coordinates && !has_constraints && options.form == Form::Both)
    refuse("both forms need constraints too; coordinates alone are given");
  if (has_constraints || !has_coordinates) normal = std::make_unique<NormalForm>(model, options);
  if (has_coordinates) tangent = std::make_unique<TangentForm>(model, options);
  choose(options.form);
  make_plan();
}

/// The cheaper form of those that there are: a mechanism with few coordinates in tangent form, a chain in normal form.
void Forms::choose(Form wanted) {
  const bool prefers_tangent =
      normal == nullptr || (tangent != nullptr && tangent->predicted_flops() <= normal->predicted_flops());
  const bool is_tangent = wanted == Form::Tangent || (wanted != Form::Normal && tangent != nullptr && prefers_tangent);
  main = is_tangent ? static_cast<EquationsOfMotion*>(tangent.get()) : normal.get();
}

void Forms::make_plan() {
  plan.points = model.num_points();
  plan.supports = plan.points - model.num_moving();
  plan.equations = model.num_rows();
  plan.coordinates = model.coordinates.num_coordinates();
  plan.islands = is_tangent() ? model.coordinates.island_start().size() - 1 : model.numbering.num_islands();
  plan.form = is_tangent() ? Form::Tangent : Form::Normal;
  for (std::size_t a = model.numbering.first_idle_row(); a < model.num_rows(); ++a) {
    plan.idle_equations.push_back(static_cast<std::size_t>(model.numbering.user_row[a]));
  }
  std::sort(plan.idle_equations.begin(), plan.idle_equations.end());
  auto& left_out = plan.left_out;
  left_out.push_back("friction stage: constraints are ideal");
  if (tangent == nullptr) left_out.push_back("tangent form: no coordinates are given");
  if (normal == nullptr) left_out.push_back("normal form: no constraints are given");
  if (normal != nullptr && tangent != nullptr)
    left_out.push_back(is_tangent() ? "normal form in steps: more flops" : "tangent form in steps: more flops");
  main->describe(&plan);
  if (!model.has_moving_supports()) left_out.push_back("support motion: every support is fixed");
  if (!main->has_work()) left_out.push_back("work integral: energy is conserved");
  if (!model.forces.has_springs()) left_out.push_back("spring forces: none");
  if (!model.forces.has_pairs()) left_out.push_back("pair forces: none");
}

Outcome Forms::reactions(double t, const double* r, const double* v, double* lambda, double* eta) {
  main->reactions(eta);
  if (!is_tangent()) {
    std::copy(normal->multipliers().begin(), normal->multipliers().end(), lambda);
    normal->minimize_multipliers(r, lambda);
    return {};
  }
  if (normal == nullptr) return {};
  scratch_.resize(3 * model.num_points());
  Outcome outcome = normal->accelerations(t, r, v, Gradients::Evaluate, scratch_.data());
  if (!outcome.ok()) return outcome;
  std::copy(normal->multipliers().begin(), normal->multipliers().end(), lambda);
  normal->minimize_multipliers(r, lambda);
  // Supports carry what the constraints do there.
  normal->reactions(scratch_.data());
  const auto first_support = static_cast<std::ptrdiff_t>(3 * model.num_moving());
  std::copy(scratch_.begin() + first_support, scratch_.end(), eta + first_support);
  return {};
}

RankReport Forms::rank(const double* r, bool thoroughly) {
  if (normal != nullptr) {
    RankReport report = normal->find_rank(r, thoroughly);
    report.taut_points = find_taut_points(model.system, report);
    return report;
  }
  // Coordinates alone: as many degrees of freedom as there are coordinates.
  RankReport report;
  report.degrees_of_freedom = model.coordinates.num_coordinates();
  return report;
}

Outcome Forms::solve_other(double t, const double* r, const double* v, double* w, double* eta) {
  EquationsOfMotion* const other = is_tangent() ? static_cast<EquationsOfMotion*>(normal.get()) : tangent.get();
  for (std::vector<double>* array : {&x_, &x_dot_, &x_ddot_}) array->resize(other->size());
  std::vector<double> places(r, r + 3 * model.num_points()), rates(v, v + 3 * model.num_points());
  if (Outcome outcome = other->adopt(t, r, v, x_.data(), x_dot_.data()); !outcome.ok()) return outcome;
  Outcome outcome = other->accelerations(t, x_.data(), x_dot_.data(), Gradients::Evaluate, x_ddot_.data());
  if (!outcome.ok()) return outcome;
  other->write_points(t, x_.data(), x_dot_.data(), x_ddot_.data(), places.data(), rates.data(), w);
  other->reactions(eta);
  return outcome;
}

}  // namespace tanor
