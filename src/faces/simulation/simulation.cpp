#include <tanor/motion.hpp>

#include "simulation/implementation.hpp"

namespace tanor {
using namespace detail;

Simulation::Simulation(System system, MotionOptions motion, SolverOptions solver, double t_start)
    : Simulation(Spread{}, std::move(system), Part{}, motion, solver, t_start) {}

Simulation::Simulation(Spread, System system, const Part& part, const MotionOptions& motion,
                       const SolverOptions& solver, double t_start)
    : implementation_(make_quietly<Implementation>(std::move(system), motion, solver, part, t_start)) {
  const QuietTraps quiet;
  const std::vector<std::size_t> idle = plan().idle_equations;
  std::vector<Index> all;
  std::optional<System> given;
  for (std::vector<Index> rigid = implementation_->find_prestress_rigid_points();
       implementation_->form.any(!rigid.empty()); rigid = implementation_->find_prestress_rigid_points()) {
    all.insert(all.end(), rigid.begin(), rigid.end());
    System held = implementation_->model.system;
    if (!given) given = held;
    hold_rigid_points(&held, rigid);
    implementation_.reset();  // two at a time would take twice the memory
    implementation_ = std::make_unique<Implementation>(std::move(held), motion, solver, part, t_start);
  }
  if (!all.empty()) {
    implementation_->given = std::move(given);
    PlanSummary& plan = implementation_->forms.plan;
    plan.prestress_rigid_points = std::move(all);
    std::set_difference(plan.idle_equations.begin(), plan.idle_equations.end(), idle.begin(), idle.end(),
                        std::back_inserter(plan.prestress_rigid_equations));
  }
  implementation_->add_breaks();
}
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;
Simulation::~Simulation() = default;

Outcome Simulation::advance_to(double t_end, const Observer& observer) {
  const QuietTraps quiet;
  (void)live(implementation_, "Simulation");
  return Implementation::advance_through_events(&implementation_, t_end, observer);
}

std::size_t Simulation::add_event(Event event) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Simulation");
  self.refuse_unknown(event);
  return self.add_event(event);
}
std::size_t Simulation::add_observable(const Observable& observable) {
  return live(implementation_, "Simulation").add_observable(observable);
}
std::span<const Observed> Simulation::observe(bool counts) {
  const QuietTraps quiet;
  return live(implementation_, "Simulation").observe(counts);
}
std::vector<Observed> Simulation::observe(std::span<const Observable> wanted) {
  const QuietTraps quiet;
  return live(implementation_, "Simulation").observe(wanted);
}
std::span<const Passage> Simulation::passages() const {
  return const_cast<Implementation&>(live(implementation_, "Simulation")).list_passages();
}
std::vector<std::byte> Simulation::save() {
  const QuietTraps quiet;
  return live(implementation_, "Simulation").save();
}
Certificate Simulation::certify() {
  const QuietTraps quiet;
  return live(implementation_, "Simulation").certify();
}
void Simulation::restore(std::span<const std::byte> saved) {
  const QuietTraps quiet;
  (void)live(implementation_, "Simulation");
  Implementation::restore(&implementation_, saved);
}

std::vector<std::byte> Simulation::save_progress() const {
  const QuietTraps quiet;
  return live(implementation_, "Simulation").save_progress();
}
void Simulation::restore_progress(std::span<const std::byte> saved, std::span<const double> positions,
                                  std::span<const double> velocities) {
  const QuietTraps quiet;
  live(implementation_, "Simulation").restore_progress(saved, positions, velocities);
}

const System& Simulation::system() const {
  return live(implementation_, "Simulation").system();
}
const PlanSummary& Simulation::plan() const {
  return live(implementation_, "Simulation").forms.plan;
}
const Outcome& Simulation::outcome() const {
  return live(implementation_, "Simulation").outcome;
}
const MotionReport& Simulation::report() const {
  return live(implementation_, "Simulation").report;
}
double Simulation::time() const {
  return live(implementation_, "Simulation").state.t;
}
std::span<const double> Simulation::coordinates() const {
  return live(implementation_, "Simulation").now.coordinates;
}
std::span<const double> Simulation::coordinate_rates() const {
  return live(implementation_, "Simulation").now.coordinate_rates;
}
RankReport Simulation::rank() {
  const QuietTraps quiet;
  RankReport report = live(implementation_, "Simulation").find_rank();
  const std::vector<std::size_t> gone = implementation_->rows_taken_out();
  std::erase_if(report.dependences, [&](const RowDependence& each) { return std::ranges::count(gone, each.row) > 0; });
  const std::vector<std::size_t>& rigid = plan().prestress_rigid_equations;
  for (RowDependence& dependence : report.dependences) {
    if (std::binary_search(rigid.begin(), rigid.end(), dependence.row))
      dependence.what = equation_name(system(), dependence.row) +
                        " is held rigid by prestress between supports, its force not determined";
  }
  return report;
}
std::span<const double> Simulation::positions() const {
  return live(implementation_, "Simulation").of_users(&Solution::positions);
}
std::span<const double> Simulation::velocities() const {
  return live(implementation_, "Simulation").of_users(&Solution::velocities);
}
std::span<const double> Simulation::accelerations() const {
  return live(implementation_, "Simulation").of_users(&Solution::accelerations);
}
Solution Simulation::solution() {
  const QuietTraps quiet;
  Solution at = live(implementation_, "Simulation").solution();
  implementation_->forget_what_is_gone(&at);
  forget_equations(system(), plan().prestress_rigid_equations, &at);
  at.self_stress = self_stress();
  return at;
}
std::vector<double> Simulation::friction_forces() {
  const QuietTraps quiet;
  return live(implementation_, "Simulation").friction_forces();
}
std::span<const double> Simulation::multipliers() const {
  auto& self = const_cast<Implementation&>(live(implementation_, "Simulation"));
  self.forget_what_is_gone(&self.now);
  return self.now.multipliers;
}
std::vector<double> Simulation::self_stress() const {
  return find_self_stress(live(implementation_, "Simulation").forms);
}
std::span<const double> Simulation::reactions() const {
  return live(implementation_, "Simulation").of_users(&Solution::reactions);
}
std::span<const double> Simulation::support_forces() const {
  return live(implementation_, "Simulation").of_users(&Solution::support_forces);
}

}  // namespace tanor
