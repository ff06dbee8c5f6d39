#include "dynamics/forms.hpp"

#include <algorithm>

namespace tanor {

Forms::Forms(System system, const SolverOptions& options, double t)
    : model(std::move(system), options, t), normal(std::make_unique<NormalForm>(model, options)), main(normal.get()) {
  make_plan();
}

void Forms::make_plan() {
  plan.points = model.num_points();
  plan.supports = plan.points - model.num_moving();
  plan.equations = model.num_rows();
  plan.islands = model.numbering.num_islands();
  for (std::size_t a = model.numbering.first_idle_row(); a < model.num_rows(); ++a) {
    plan.idle_equations.push_back(static_cast<std::size_t>(model.numbering.user_row[a]));
  }
  auto& left_out = plan.left_out;
  left_out.push_back("friction stage: constraints are ideal");
  left_out.push_back("tangent form: no coordinates are given");
  main->describe(&plan);
  if (!model.has_moving_supports()) left_out.push_back("support motion: every support is fixed");
  if (!main->has_work()) left_out.push_back("work integral: energy is conserved");
  if (!model.forces.has_springs()) left_out.push_back("spring forces: none");
}

void Forms::support_forces(double* carried) const {
  main->reactions(carried);
  const std::size_t moving = 3 * model.num_moving();
  std::fill(carried, carried + moving, 0.0);
  for (std::size_t i = moving; i < model.f.size(); ++i) carried[i] += model.f[i];
}

}  // namespace tanor
