#include "dynamics/implicit_form.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/stopwatch.hpp"
#include "base/text.hpp"

namespace tanor::detail {

namespace {

std::vector<Compliance> list_compliances(std::span<const Spring> springs) {
  std::vector<Compliance> result;
  for (const Spring& spring : springs) result.push_back({spring.stiffness, spring.damping});
  return result;
}

}  // namespace

ImplicitForm::ImplicitForm(Workspace& work)
    : work_(work),
      model_(work.model()),
      springs_(work.forces.springs().list_compliant()),
      compliances_(list_compliances(springs_)),
      num_springs_(work.forces.list_couplings().size()),
      plan_(make_plan()),
      friction_(model_.system, work.constraints.tangents()),
      blocks_(3 * work.constraints.num_blocks()),
      units_(3 * springs_.size()),
      linearised_blocks_(blocks_.size() + units_.size()),
      reactions_(3 * model_.num_points(), 0.0),
      product_(3 * model_.num_points()),
      spring_residuals_(springs_.size()),
      derivatives_(model_.num_moving(), num_springs_ + work.constraints.list_rods().size(),
                   work.forces.list_influences().size()) {}

/// Rows are those of constraints, then of compliant springs. Couplings are those of all springs, then of rods.
NewtonPlan ImplicitForm::make_plan() const {
  std::vector<Coupling> couplings = work_.forces.list_couplings();
  const std::vector<Coupling> rods = work_.constraints.list_rods();
  couplings.insert(couplings.end(), rods.begin(), rods.end());

  auto row = static_cast<Index>(num_active_rows()), block = static_cast<Index>(work_.constraints.num_blocks());
  std::vector<Incidence> incidences;
  std::ranges::copy_if(model_.incidences, std::back_inserter(incidences),
                       [row](const Incidence& incidence) { return incidence.row < row; });
  for (const Spring& spring : springs_) {
    incidences.push_back({spring.i, row, block, -1.0});
    incidences.push_back({spring.j, row++, block++, 1.0});
  }
  return {std::span(model_.mass).first(model_.num_moving()),
          static_cast<std::size_t>(row),
          couplings,
          work_.forces.list_influences(),
          incidences,
          compliances_,
          model_.may_lose_rank};
}

void ImplicitForm::write_multipliers(const Reactions& found, const double* r, const double* v, double* lambda) {
  std::ranges::copy(found.lambda, lambda);
  double* const tau = lambda + num_constraints();
  std::fill(tau, tau + springs_.size(), 0.0);
  work_.forces.springs().evaluate_compliant(model_.parallel, r, v, tau, units_.data(), tau);
  for (std::size_t k = 0; k < springs_.size(); ++k) tau[k] = -tau[k];
}

// ---- residuals ----

Outcome ImplicitForm::evaluate(double t, const double* r, const double* v, const double* lambda, double* w,
                               double* rows, Power* power) {
  work_.set_time(t);
  ++work_.counters.evaluations;
  const Stopwatch watch(&work_.times.evaluate);
  const Parallel& parallel = model_.parallel;
  const double* const tau = lambda + num_constraints();
  double scale = work_.evaluate_free(t, r, v, w, Forces::Which::WithoutCompliant);
  scale = larger(scale, work_.constraints.evaluate_rates(parallel, r, v, rows));
  if (!std::isfinite(scale)) return work_.not_finite(t, r);
  // w = M^-1 (f + K lambda)
  work_.forces.springs().evaluate_compliant(parallel, r, v, tau, units_.data(), rows + num_constraints());
  work_.forces.springs().add_compliant_forces(parallel, units_.data(), tau, model_.inverse_mass.data(), w);
  if (num_constraints() > 0) {
    work_.constraints.evaluate_gradients(parallel, r, blocks_.data());
    model_.gather.write_scaled(parallel, blocks_.data(), lambda, model_.inverse_mass.data(), model_.num_moving(),
                               reactions_.data());
    model_.add_to_moving(reactions_.data(), w);
    friction_.add_accelerations(v, model_.inverse_mass, w);
  }
  if (power != nullptr) {
    *power = work_.power(work_.power_of_reactions(reactions_.data(), v), {t, r, v});
    power->friction = friction_.power(v);
  }
  return {};
}

double ImplicitForm::evaluate_positions(double t, const double* r, double* xi) {
  work_.set_time(t);
  const Stopwatch watch(&work_.times.evaluate);
  return work_.constraints.evaluate_values(model_.parallel, r, xi);
}

// ---- Newton's matrix ----

void ImplicitForm::linearise(double t, const double* r, const double* v, const double* lambda) {
  work_.set_time(t);
  linearised_at_.t = t;
  linearised_at_.r.assign(r, r + 3 * model_.num_points());
  linearised_at_.v.assign(v, v + 3 * model_.num_points());
  linearised_at_.lambda.assign(lambda, lambda + num_rows());
  const Stopwatch watch(&work_.times.evaluate);
  const Parallel& parallel = model_.parallel;
  const double* const tau = lambda + num_constraints();
  work_.constraints.evaluate_gradients(parallel, r, linearised_blocks_.data());
  work_.forces.springs().evaluate_compliant(parallel, r, v, tau, linearised_blocks_.data() + blocks_.size(),
                                            spring_residuals_.data());
  work_.forces.evaluate_derivatives(parallel, t, r, v, tau, derivatives_);
  friction_.add_derivatives(derivatives_.point_velocities);
  work_.constraints.evaluate_rod_derivatives(parallel, r, lambda,
                                             derivatives_.coupling_positions.data() + num_springs_);
}

NewtonPlan::Values ImplicitForm::values() const {
  return {derivatives_.point_positions.data(),
          derivatives_.point_velocities.data(),
          derivatives_.coupling_positions.data(),
          derivatives_.coupling_velocities.data(),
          derivatives_.influence_positions.data(),
          derivatives_.influence_velocities.data(),
          linearised_blocks_.data()};
}

void ImplicitForm::add_stiffness(const double* dr, double* w, double* rows) {
  std::fill(product_.begin(), product_.end(), 0.0);
  plan_.add_stiffness(values(), dr, product_.data());
  for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) w[i] += model_.inverse_mass[i / 3] * product_[i];
  for (std::size_t k = 0; k < springs_.size(); ++k) {
    const Vec3 unit = load(linearised_blocks_.data() + blocks_.size(), k);
    rows[num_constraints() + k] += springs_[k].stiffness * dot(unit, load(dr, springs_[k].j) - load(dr, springs_[k].i));
  }
}

template <class T>
Outcome ImplicitForm::factorize(const NewtonWeights<T>& weights, Factor<T>* factor) {
  factor->weights = weights;
  if (plan_.rows().empty()) return {};
  if (factor->lu == nullptr) {
    factor->lu = std::make_unique<SparseLu<T>>(SquarePattern{plan_.column_start(), plan_.rows()});
    factor->unknowns.resize(factor->lu->pattern().size());
  }
  {
    const Stopwatch watch(&work_.times.assemble);
    plan_.assemble<T>({weights.mass, weights.velocity, weights.position}, values(), factor->lu->values());
  }
  const Stopwatch watch(&work_.times.factor);
  ++work_.counters.factorizations;
  const std::size_t num_pivotings = factor->lu->num_pivotings();
  const bool is_regular = factor->lu->factorize();
  if (factor->lu->num_pivotings() > num_pivotings) {
    factor->pivoted_at = linearised_at_;
    factor->pivoted_with = weights;
  }
  if (is_regular) return {};
  return {Status::Singular, "Newton's matrix of the implicit step is singular at t = " + text(linearised_at_.t)};
}

template <class T>
void ImplicitForm::solve(Factor<T>* factor, T* w, T* rows) {
  const Stopwatch watch(&work_.times.solve);
  ++work_.counters.solves;
  const std::size_t moving = 3 * model_.num_moving(), active = num_active_rows(), first_spring = num_constraints();
  std::vector<T>& unknowns = factor->unknowns;
  if (!unknowns.empty() && !factor->lu->has_factor()) {
    // The factor of a snapshot that is damaged could not be made again. The step fails, and the next one makes its own.
    const T nothing(std::numeric_limits<double>::quiet_NaN());
    std::fill(w, w + moving, nothing);
    std::fill(rows, rows + num_rows(), nothing);
    return;
  }
  if (!unknowns.empty()) {
    const auto& [mass, velocity, position] = factor->weights;
    for (std::size_t i = 0; i < moving; ++i) unknowns[i] = model_.mass[i / 3] * w[i];
    for (std::size_t a = 0; a < active; ++a) unknowns[moving + a] = -rows[a];
    T* const springs = unknowns.data() + moving + active;
    for (std::size_t k = 0; k < springs_.size(); ++k) {
      const auto& [stiffness, damping] = compliances_[k];
      springs[k] = -rows[first_spring + k] / (velocity * damping + position * stiffness);
    }
    factor->lu->solve(unknowns.data());
    std::copy_n(unknowns.data(), moving, w);
    std::copy_n(unknowns.data() + moving, active, rows);
    std::copy_n(springs, springs_.size(), rows + first_spring);
  }
  std::fill(w + moving, w + 3 * model_.num_points(), T(0.0));
  std::fill(rows + active, rows + first_spring, T(0.0));
}

// ---- memory ----

void ImplicitForm::exchange_memory(Memory& memory, Place* place) const {
  for (std::vector<double>* const array : {&place->r, &place->v}) array->resize(3 * model_.num_points());
  place->lambda.resize(num_rows());
  memory.exchange(place->t, place->r, place->v, place->lambda);
}

namespace {

void exchange_weight(Memory& memory, double& weight) {
  memory.exchange(weight);
}
void exchange_weight(Memory& memory, std::complex<double>& weight) {
  double real = weight.real(), imaginary = weight.imag();
  memory.exchange(real, imaginary);
  weight = {real, imaginary};
}

template <class T>
void exchange_weights(Memory& memory, NewtonWeights<T>* weights) {
  for (T* const weight : {&weights->mass, &weights->velocity, &weights->position}) exchange_weight(memory, *weight);
}

}  // namespace

template <class T>
void ImplicitForm::exchange_memory(Memory& memory, const Place& at, Factor<T>* factor) {
  NewtonWeights<T> weights = factor->weights, pivoted_with = factor->pivoted_with;
  Place pivoted_at = factor->pivoted_at;
  exchange_weights(memory, &weights);
  exchange_weights(memory, &pivoted_with);
  exchange_memory(memory, &pivoted_at);
  if (!memory.reads() || weights.mass == T(0.0)) return;
  if (factor->lu != nullptr) factor->lu->forget_pivots();
  linearise(pivoted_at);
  (void)factorize(pivoted_with, factor);
  linearise(at);
  (void)factorize(weights, factor);
}

void ImplicitForm::exchange_memory(Memory& memory) {
  Place at = linearised_at_;
  exchange_memory(memory, &at);
  exchange_memory(memory, at, &real_);
  exchange_memory(memory, at, &complex_);
}

}  // namespace tanor::detail
