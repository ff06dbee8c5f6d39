#include "dynamics/friction_stage.hpp"

#include <algorithm>
#include <cmath>

#include "base/stopwatch.hpp"
#include "system/text.hpp"

namespace tanor {

std::string_view uniqueness_name(Uniqueness uniqueness) {
  switch (uniqueness) {
    case Uniqueness::NotAsked:
      break;
    case Uniqueness::Proven:
      return "proven";
    case Uniqueness::Unproven:
      return "unproven";
    case Uniqueness::Several:
      return "several";
    case Uniqueness::None:
      return "none";
  }
  return "not asked";
}

std::string_view friction_method_name(FrictionMethod method) {
  switch (method) {
    case FrictionMethod::Auto:
      break;
    case FrictionMethod::FixedPoint:
      return "fixed point";
    case FrictionMethod::Anderson:
      return "anderson";
    case FrictionMethod::Newton:
      return "newton";
    case FrictionMethod::Enumeration:
      return "enumeration";
  }
  return "auto";
}

namespace {

/// As deep as contacts are many, so that few of them are solved like a linear system; shallow where vectors are long.
int anderson_depth(std::size_t num_contacts) {
  return num_contacts <= 1000 ? 10 : 5;
}

constexpr std::size_t most_judged = 64;  // contacts of an island, one solve each
constexpr double smallest_number = std::numeric_limits<double>::min();

double largest_norm(const std::vector<double>& tau) {
  double worst = 0.0;
  for (std::size_t c = 0; 3 * c < tau.size(); ++c) worst = larger(worst, norm(load(tau.data(), c)));
  return worst;
}

double largest_change(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0.0;
  for (std::size_t c = 0; 3 * c < a.size(); ++c) worst = larger(worst, norm(load(a.data(), c) - load(b.data(), c)));
  return worst;
}

}  // namespace

FrictionStage::FrictionStage(Model& model, FrictionMethod method, const std::vector<double>& blocks, Solve solve)
    : model_(model),
      tangents_(model.constraints.tangents()),
      method_(method),
      blocks_(blocks),
      solve_(std::move(solve)),
      laws_(model.system, model.numbering, tangents_, model.incidences),
      fixed_point_(laws_, *this, model.num_rows()),
      right_side_(model.num_rows()),
      lambda_(model.num_rows()),
      tau_(3 * tangents_.size(), 0.0),
      tau_before_(tau_) {
  std::vector<std::vector<Index>> contacts_of_point(model.num_points());
  for (std::size_t c = 0; c < tangents_.size(); ++c)
    contacts_of_point[static_cast<std::size_t>(tangents_[c].point)].push_back(static_cast<Index>(c));
  for (const Incidence& i : model.incidences) {
    const auto point = static_cast<std::size_t>(i.point);
    for (const Index contact : contacts_of_point[point])
      touches_.push_back({i.row, contact, i.block, i.sign * model.inverse_mass[point]});
  }
  std::stable_sort(touches_.begin(), touches_.end(), [](const Touch& a, const Touch& b) { return a.row < b.row; });

  const std::vector<Index>& start = model.numbering.island_start;
  islands_.resize(model.numbering.num_islands());
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    const auto after = std::upper_bound(start.begin(), start.end(), tangents_[c].guide_row[0]);
    islands_[static_cast<std::size_t>(after - start.begin() - 1)].push_back(c);
  }
  std::erase_if(islands_, [](const auto& island) { return island.empty(); });
}

// ---- the response of S ----

void FrictionStage::add_to_rows(double sign, const double* tau, double* rows) const {
  for (const Touch& touch : touches_)
    rows[touch.row] += sign * touch.weight * dot(load(blocks_.data(), touch.block), load(tau, touch.contact));
}

void FrictionStage::find_multipliers(const double* tau, double* lambda) {
  std::copy(b_, b_ + right_side_.size(), right_side_.begin());
  add_to_rows(1.0, tau, right_side_.data());
  solve_(right_side_.data(), lambda, refines_);
}

void FrictionStage::find_change(const double* tau, double* lambda) {
  std::fill(right_side_.begin(), right_side_.end(), 0.0);
  add_to_rows(1.0, tau, right_side_.data());
  solve_(right_side_.data(), lambda, false);
}

// ---- one instant ----

Outcome FrictionStage::find(double t, const double* r, const double* v, const double* b, Judgement judgement,
                            const double* lambda) {
  const Stopwatch watch(&model_.times.friction);
  laws_.set_state(t, r, v, blocks_.data());
  b_ = b;
  report_ = {.contacts = tangents_.size()};
  amplification_ = std::numeric_limits<double>::quiet_NaN();
  report_.sticking = num_sticking();
  std::copy(lambda, lambda + lambda_.size(), lambda_.begin());
  const bool all_stick = report_.sticking == report_.contacts;
  if (laws_.depend_on_reactions() && !all_stick) {
    ++model_.counters.friction_solves;
    Outcome outcome = iterate(t, lambda_.data());
    if (outcome.ok() && judgement != Judgement::None && report_.uniqueness == Uniqueness::NotAsked)
      outcome = judge(t, judgement == Judgement::Quick ? most_enumerated : most_judged);
    model_.counters.friction_iterations += static_cast<std::size_t>(report_.iterations);
    model_.counters.solves += static_cast<std::size_t>(report_.iterations);
    if (!outcome.ok()) return outcome;
  } else if (judgement != Judgement::None) {
    report_.uniqueness = Uniqueness::Proven;  // a given force
    amplification_ = 1.0;
  }
  laws_.evaluate(model_.parallel, lambda_.data(), tau_.data());
  const double size = largest_norm(tau_);
  return std::isfinite(size) ? Outcome{} : model_.not_finite(t);
}

Outcome FrictionStage::iterate(double t, double* lambda) {
  const auto converges = [&](FrictionMethod method) {
    const std::vector<double> guess(lambda, lambda + lambda_.size());
    const Parallel& parallel = model_.parallel;
    const FixedPoint::Result result = method == FrictionMethod::Newton ? fixed_point_.solve_by_newton(parallel, lambda)
                                      : method == FrictionMethod::Anderson
                                          ? fixed_point_.iterate(parallel, anderson_depth(tangents_.size()), lambda)
                                          : fixed_point_.iterate(parallel, 0, lambda);
    report_.method_used = method;
    report_.iterations += result.iterations;
    report_.contraction = std::max(report_.contraction, result.contraction);
    if (!result.has_converged) std::copy(guess.begin(), guess.end(), lambda);
    return result.has_converged;
  };
  if (method_ == FrictionMethod::FixedPoint) {
    if (converges(FrictionMethod::FixedPoint)) return {};
    return fail(Status::NotConverged, t,
                "(43) does not converge by itself (contraction " + text(report_.contraction) + "); others may");
  }
  if (method_ != FrictionMethod::Enumeration) {
    if (method_ != FrictionMethod::Newton && converges(FrictionMethod::Anderson)) return {};
    if (method_ != FrictionMethod::Anderson && converges(FrictionMethod::Newton)) return {};
    const bool are_few = tangents_.size() <= most_enumerated;
    if (method_ == FrictionMethod::Newton && !are_few && converges(FrictionMethod::Anderson)) return {};
  }
  return enumerate(t, lambda);
}

/// Rounding of a single solve with an ill-conditioned S is more than the law may miss: Newton's method with refined
/// solves.
void FrictionStage::polish(const double* b, double* lambda) {
  b_ = b;
  refines_ = true;
  constexpr double wanted = 1e-15;
  std::vector<double> better(lambda, lambda + lambda_.size());
  const FixedPoint::Result result = fixed_point_.solve_by_newton(model_.parallel, better.data(), wanted);
  refines_ = false;
  if (!result.has_converged) return;
  std::copy(better.begin(), better.end(), lambda);
  laws_.evaluate(model_.parallel, lambda, tau_.data());
}

void FrictionStage::add(double sign, double* w0, double* b) const {
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    const auto point = static_cast<std::size_t>(tangents_[c].point);
    store(w0, point, load(w0, point) + sign * model_.inverse_mass[point] * load(tau_.data(), c));
  }
  add_to_rows(sign, tau_.data(), b);
}

double FrictionStage::change_to(const double* lambda, double s, double* x) {
  std::swap(tau_, tau_before_);
  laws_.evaluate(model_.parallel, lambda, tau_.data());
  add_change(s, x);
  return largest_change(tau_, tau_before_) / std::max(largest_norm(tau_), smallest_number);
}

void FrictionStage::add_change(double s, double* x) const {
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    const auto point = static_cast<std::size_t>(tangents_[c].point);
    const Vec3 change = model_.inverse_mass[point] * (load(tau_.data(), c) - load(tau_before_.data(), c));
    store(x, point, load(x, point) + s * change);
  }
}

double FrictionStage::measure(const double* lambda) {
  laws_.evaluate(model_.parallel, lambda, tau_before_.data());
  const double change = largest_change(tau_, tau_before_);
  report_.residual = change / std::max(largest_norm(tau_), smallest_number);
  report_.error_bound = amplification_ * change;
  return report_.residual;
}

Outcome FrictionStage::fail(Status status, double t, const std::string& why) const {
  return {status, "friction at t = " + text(t) + ": " + why};
}

// ---- outputs ----

Vec3 FrictionStage::held(std::size_t contact, const double* lambda) const {
  const Tangents::Place& place = tangents_[contact];
  Vec3 sum{};
  for (int k = 0; place.first_row >= 0 && k < place.num_tangents(); ++k)
    sum = sum + lambda[place.first_row + k] * tangents_.directions(contact)[static_cast<std::size_t>(k)];
  return sum;
}

std::size_t FrictionStage::num_sticking() const {
  std::size_t count = 0;
  for (std::size_t c = 0; c < tangents_.size(); ++c) count += tangents_.sticks(c) ? 1 : 0;
  return count;
}

double FrictionStage::static_limit(std::size_t contact, const double* lambda) const {
  return laws_.static_coefficient(contact) * norm(laws_.normal_force(contact, lambda));
}

void FrictionStage::add_to_points(const double* of_contacts, double* tau) const {
  for (std::size_t c = 0; c < tangents_.size(); ++c)
    store(tau, tangents_[c].point, load(tau, tangents_[c].point) + load(of_contacts, c));
}

void FrictionStage::add_held(const double* lambda, double* tau) const {
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    if (tangents_.sticks(c)) store(tau, tangents_[c].point, load(tau, tangents_[c].point) + held(c, lambda));
  }
}

void FrictionStage::add_at(const double* lambda, double* tau) {
  add_to_points(fixed_point_.friction(model_.parallel, lambda).data(), tau);
}

double FrictionStage::power(const double* lambda, const double* v) const {
  double sum = held_power(lambda, v);
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    if (!tangents_.sticks(c)) sum += dot(load(tau_.data(), c), load(v, tangents_[c].point));
  }
  return sum;
}

double FrictionStage::held_power(const double* lambda, const double* v) const {
  double sum = 0.0;
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    if (tangents_.sticks(c)) sum += dot(held(c, lambda), load(v, tangents_[c].point));
  }
  return sum;
}

}  // namespace tanor
