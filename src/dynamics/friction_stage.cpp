#include "dynamics/friction_stage.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/stopwatch.hpp"
#include "base/text.hpp"

namespace tanor {

namespace {

/// Deep where contacts are few, so that they are solved like a linear system; shallow where vectors are long: what they
/// cost is more than the iterations that they save.
int anderson_depth(std::size_t num_contacts) {
  return num_contacts <= 1000 ? FixedPoint::most_depth : 3;
}

constexpr double poor_contraction = 0.1;  // Newton's method is asked instead
constexpr double smallest_number = std::numeric_limits<double>::min();

double largest_of(const std::vector<double>& x) {
  double worst = 0.0;
  for (const double each : x) worst = larger(worst, std::abs(each));
  return worst;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) worst = larger(worst, std::abs(a[k] - b[k]));
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
      change_(model.num_rows(), 0.0),
      lambda_(model.num_rows()),
      guess_(model.num_rows()),
      x_(laws_.num_parts(), 0.0),
      x_at_(x_),
      tau_(3 * tangents_.size(), 0.0),
      tau_before_(tau_) {
  std::vector<std::vector<Index>> contacts_of_point(model.num_points());
  for (std::size_t c = 0; c < tangents_.size(); ++c)
    contacts_of_point[static_cast<std::size_t>(tangents_[c].point)].push_back(static_cast<Index>(c));
  incidences_of_contact_.resize(tangents_.size());
  struct RowTouch {
    Index row, part;
    Touch touch;
  };
  std::vector<RowTouch> touches;
  for (std::size_t k = 0; k < model.incidences.size(); ++k) {
    const Incidence& i = model.incidences[k];
    const auto point = static_cast<std::size_t>(i.point);
    for (const Index contact : contacts_of_point[point]) {
      const auto c = static_cast<std::size_t>(contact);
      if (feels(i, c)) incidences_of_contact_[c].push_back(k);
      for (std::size_t part = laws_.first_part(c); feels(i, c) && part < laws_.end_part(c); ++part)
        touches.push_back({i.row, static_cast<Index>(part), {i.block, i.sign * model.inverse_mass[point]}});
    }
  }
  std::stable_sort(touches.begin(), touches.end(), [](const auto& a, const auto& b) { return a.row < b.row; });
  for (const auto& [row, part, touch] : touches) {
    if (touched_rows_.empty() || touched_rows_.back() != row) {
      touched_rows_.push_back(row);
      touch_start_.push_back(static_cast<Index>(touches_.size()));
    }
    touches_.push_back(touch);
    shares_.push_back({part, 0.0});
  }
  touch_start_.push_back(static_cast<Index>(touches_.size()));
  b_touched_.resize(touched_rows_.size());

  const std::vector<Index>& start = model.numbering.island_start;
  islands_.resize(model.numbering.num_islands());
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    const auto after = std::upper_bound(start.begin(), start.end(), tangents_[c].guide_row[0]);
    islands_[static_cast<std::size_t>(after - start.begin() - 1)].push_back(c);
  }
  std::erase_if(islands_, [](const auto& island) { return island.empty(); });
  island_of_contact_.resize(tangents_.size());
  for (std::size_t island = 0; island < islands_.size(); ++island) {
    for (const std::size_t c : islands_[island]) island_of_contact_[c] = island;
  }
}

/// A user's law may push anywhere; others push along T, T'K_g = 0.
bool FrictionStage::feels(const Incidence& i, std::size_t contact) const {
  const Tangents::Place& place = tangents_[contact];
  const auto guides_end = place.guide_row.begin() + place.num_guides;
  return laws_.is_user(contact) || std::find(place.guide_row.begin(), guides_end, i.row) == guides_end;
}

/// What sizes of friction are told apart by: each neighbourhood's own.
void FrictionStage::set_accelerations(const std::vector<double>& accelerations) {
  if (group_of_part_.empty()) {
    std::vector<Index> group_of(model_.scales.size(), -1);
    for (std::size_t c = 0; c < tangents_.size(); ++c) {
      const std::size_t own = model_.scales.of_point(static_cast<std::size_t>(tangents_[c].point));
      if (group_of[own] < 0) {
        group_of[own] = static_cast<Index>(neighbourhoods_.size());
        neighbourhoods_.push_back(own);
      }
      group_of_part_.insert(group_of_part_.end(), laws_.end_part(c) - laws_.first_part(c), group_of[own]);
    }
  }
  // Forces round by eps m a: below 1e-4 m a they have fewer digits than the tolerance of the iterations.
  constexpr double part = 1e-4;
  least_.assign(neighbourhoods_.size(), 0.0);
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    const auto group = static_cast<std::size_t>(group_of_part_[laws_.first_part(c)]);
    const double mass = model_.mass[static_cast<std::size_t>(tangents_[c].point)];
    least_[group] = std::max(least_[group], part * mass * accelerations[neighbourhoods_[group]]);
  }
  if (neighbourhoods_.size() > 1) fixed_point_.set_groups(group_of_part_, least_);
}

/// |x - x_at| over the largest friction, of the worst neighbourhood.
double FrictionStage::relative_change() {
  if (neighbourhoods_.size() <= 1) return largest_difference(x_, x_at_) / std::max(largest_of(x_), smallest_number);
  largest_ = least_;
  largest_change_.assign(least_.size(), 0.0);
  for (std::size_t p = 0; p < x_.size(); ++p) {
    const auto group = static_cast<std::size_t>(group_of_part_[p]);
    largest_[group] = larger(largest_[group], std::abs(x_[p]));
    largest_change_[group] = larger(largest_change_[group], std::abs(x_[p] - x_at_[p]));
  }
  double worst = 0.0;
  for (std::size_t k = 0; k < largest_.size(); ++k)
    worst = larger(worst, largest_change_[k] / std::max(largest_[k], smallest_number));
  return worst;
}

// ---- the response of S ----

/// Row k of those that K'M^-1 tau touches.
double FrictionStage::felt(std::size_t k, const double* x) const {
  double sum = 0.0;
  for (Index t = touch_start_[k]; t < touch_start_[k + 1]; ++t) {
    const Share& share = shares_[static_cast<std::size_t>(t)];
    sum += share.size * x[share.part];
  }
  return sum;
}

/// x and tau from now on.
void FrictionStage::set_forces(const double* lambda) {
  laws_.evaluate(model_.parallel, lambda, x_.data());
  laws_.write_forces(x_.data(), tau_.data());
}

void FrictionStage::set_right_side(const double* b) {
  std::copy(b, b + right_side_.size(), right_side_.begin());
  for (std::size_t k = 0; k < touched_rows_.size(); ++k) b_touched_[k] = b[touched_rows_[k]];
}

void FrictionStage::find_multipliers(const double* x, double* lambda) {
  for (std::size_t k = 0; k < touched_rows_.size(); ++k)
    right_side_[static_cast<std::size_t>(touched_rows_[k])] = b_touched_[k] + felt(k, x);
  solve_(right_side_.data(), lambda, refines_);
}

void FrictionStage::find_change(const double* x, double* lambda) {
  for (std::size_t k = 0; k < touched_rows_.size(); ++k)
    change_[static_cast<std::size_t>(touched_rows_[k])] = felt(k, x);
  solve_(change_.data(), lambda, false);
}

// ---- one instant ----

void FrictionStage::set_place(double t, const double* r, const double* v) {
  laws_.set_state(model_.parallel, t, r, v, blocks_.data());
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    const Vec3 e = laws_.part_direction(static_cast<std::size_t>(shares_[k].part));
    shares_[k].size = touches_[k].weight * dot(load(blocks_.data(), touches_[k].block), e);
  }
}

Outcome FrictionStage::find(double t, const double* r, const double* v, const double* b, Judgement judgement,
                            const double* lambda) {
  const Stopwatch watch(&model_.times.friction);
  set_place(t, r, v);
  set_right_side(b);
  report_ = {.contacts = tangents_.size()};
  amplification_ = std::numeric_limits<double>::quiet_NaN();
  report_.sticking = num_sticking();
  std::copy(lambda, lambda + lambda_.size(), lambda_.begin());
  const bool all_stick = report_.sticking == report_.contacts;
  if (laws_.depend_on_reactions() && !all_stick) {
    ++model_.counters.friction_solves;
    Outcome outcome = iterate(t, lambda, lambda_.data());
    if (outcome.ok() && judgement != Judgement::None && report_.uniqueness == Uniqueness::NotAsked) outcome = judge(t);
    model_.counters.friction_iterations += static_cast<std::size_t>(report_.iterations);
    if (!outcome.ok()) return outcome;
  } else if (judgement != Judgement::None) {
    report_.uniqueness = Uniqueness::Proven;  // a given force
    amplification_ = 1.0;
  }
  set_forces(lambda_.data());
  return std::isfinite(largest_of(x_)) ? Outcome{} : model_.not_finite(t);
}

void FrictionStage::set_given(double t, const double* r, const double* v, const double* lambda) {
  set_place(t, r, v);
  laws_.evaluate(model_.parallel, lambda, x_.data());
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    if (laws_.is_coulomb(c)) std::fill_n(x_.data() + laws_.first_part(c), laws_.end_part(c) - laws_.first_part(c), 0.0);
  }
  laws_.write_forces(x_.data(), tau_.data());
}

void FrictionStage::add_force(std::size_t contact, Vec3 force, double* b) const {
  for (const std::size_t k : incidences_of_contact_[contact]) {
    const Incidence& i = model_.incidences[k];
    const double weight = i.sign * model_.inverse_mass[static_cast<std::size_t>(i.point)];
    b[i.row] += weight * dot(load(blocks_.data(), i.block), force);
  }
}

Vec3 FrictionStage::force(std::size_t contact, const double* lambda) const {
  return tangents_.sticks(contact) ? held(contact, lambda) : load(tau_.data(), contact);
}

Outcome FrictionStage::iterate(double t, const double* guess, double* lambda) {
  const auto converges = [&](FrictionMethod method, double poor = std::numeric_limits<double>::infinity()) {
    const Parallel& parallel = model_.parallel;
    const int depth = method == FrictionMethod::Anderson ? anderson_depth(tangents_.size()) : 0;
    const FixedPoint::Result result = method == FrictionMethod::Newton
                                          ? fixed_point_.solve_by_newton(parallel, lambda)
                                          : fixed_point_.iterate(parallel, depth, lambda, poor);
    report_.method_used = method;
    report_.iterations += result.iterations;
    report_.contraction = std::max(report_.contraction, result.contraction);
    if (!result.has_converged) std::copy(guess, guess + lambda_.size(), lambda);
    return result.has_converged;
  };
  const bool are_few = tangents_.size() <= most_enumerated;
  switch (method_) {
    case FrictionMethod::FixedPoint:
      if (converges(FrictionMethod::FixedPoint)) return {};
      return fail(Status::NotConverged, t,
                  "(43) does not converge by itself (contraction " + text(report_.contraction) + "); others may");
    case FrictionMethod::Auto:
      // A step of Newton's method for few contacts is a few solves: less than slow iterations are.
      if (are_few && converges(FrictionMethod::Anderson, poor_contraction)) return {};
      if (are_few && converges(FrictionMethod::Newton)) return {};
      if (converges(FrictionMethod::Anderson)) return {};
      if (!are_few && converges(FrictionMethod::Newton)) return {};
      break;
    case FrictionMethod::Anderson:
      if (converges(FrictionMethod::Anderson)) return {};
      break;
    case FrictionMethod::Newton:
      if (converges(FrictionMethod::Newton)) return {};
      if (!are_few && converges(FrictionMethod::Anderson)) return {};
      break;
    case FrictionMethod::Enumeration:
      break;
  }
  return enumerate(t, lambda);
}

/// Rounding of a single solve with an ill-conditioned S is more than the law may miss: Newton's method with refined
/// solves.
void FrictionStage::polish(const double* b, const double* lambda) {
  set_right_side(b);
  refines_ = true;
  constexpr double wanted = 1e-15;
  std::copy(lambda, lambda + lambda_.size(), guess_.begin());
  const FixedPoint::Result result = fixed_point_.solve_by_newton(model_.parallel, guess_.data(), wanted);
  refines_ = false;
  if (result.has_converged) set_forces(guess_.data());
}

void FrictionStage::add(double sign, double* w0, double* b) const {
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    const auto point = static_cast<std::size_t>(tangents_[c].point);
    add_to(w0, point, sign * model_.inverse_mass[point] * load(tau_.data(), c));
  }
  for (std::size_t k = 0; k < touched_rows_.size(); ++k) b[touched_rows_[k]] += sign * felt(k, x_.data());
}

double FrictionStage::change_to(const double* lambda, double s, double* y) {
  std::swap(x_, x_at_);
  std::swap(tau_, tau_before_);
  set_forces(lambda);
  add_change(s, y);
  return relative_change();
}

void FrictionStage::add_change(double s, double* y) const {
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    const auto point = static_cast<std::size_t>(tangents_[c].point);
    add_to(y, point, s * model_.inverse_mass[point] * (load(tau_.data(), c) - load(tau_before_.data(), c)));
  }
}

double FrictionStage::measure(const double* lambda) {
  laws_.evaluate(model_.parallel, lambda, x_at_.data());
  report_.residual = relative_change();
  report_.error_bound = amplification_ * largest_difference(x_, x_at_);
  return report_.residual;
}

Outcome FrictionStage::fail(Status status, double t, const std::string& why) const {
  return {status, "friction at t = " + text(t) + ": " + why};
}

// ---- outputs ----

Vec3 FrictionStage::held(std::size_t contact, const double* lambda) const {
  const Tangents::Place& place = tangents_[contact];
  Vec3 sum = laws_.reference(contact);
  for (int k = 0; place.first_row >= 0 && k < place.num_tangents(); ++k)
    sum = sum + lambda[place.first_row + k] * tangents_.directions(contact)[static_cast<std::size_t>(k)];
  return sum;
}

double FrictionStage::static_limit(std::size_t contact, const double* lambda) const {
  return laws_.static_coefficient(contact) * norm(laws_.normal_force(contact, lambda));
}

void FrictionStage::add_all(const double* lambda, double* tau) const {
  for (std::size_t c = 0; c < tangents_.size(); ++c) add_to(tau, tangents_[c].point, force(c, lambda));
}

void FrictionStage::add_to_points(const double* of_contacts, double* tau) const {
  for (std::size_t c = 0; c < tangents_.size(); ++c) add_to(tau, tangents_[c].point, load(of_contacts, c));
}

void FrictionStage::add_at(const double* lambda, double* tau) const {
  std::vector<double> x(x_.size()), forces(tau_.size());
  laws_.evaluate(model_.parallel, lambda, x.data());
  laws_.write_forces(x.data(), forces.data());
  add_to_points(forces.data(), tau);
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
