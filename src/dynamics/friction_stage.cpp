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

constexpr double smallest_number = std::numeric_limits<double>::min();

double largest_of(const std::vector<double>& x) {
  double worst = 0.0;
  for (const double each : x) worst = larger(worst, std::abs(each));
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
      tau_(3 * tangents_.size(), 0.0) {
  std::vector<std::vector<Index>> contacts_of_point(model.num_points());
  for (std::size_t c = 0; c < tangents_.size(); ++c)
    contacts_of_point[static_cast<std::size_t>(tangents_[c].point)].push_back(static_cast<Index>(c));
  // A user's law may push anywhere; others push along T, T'K_g = 0. What holds a contact stands only where tau is 0.
  const auto feels = [&](const Incidence& i, std::size_t contact) {
    const Tangents::Place& place = tangents_[contact];
    const auto own = place.first_row < 0 ? 0 : place.num_tangents();
    if (i.row >= place.first_row && i.row < place.first_row + own) return false;
    const auto guides_end = place.guide_row.begin() + place.num_guides;
    return laws_.is_user(contact) || std::find(place.guide_row.begin(), guides_end, i.row) == guides_end;
  };
  struct RowTouch {
    Index row, part;
    Touch touch;
  };
  std::vector<RowTouch> touches;
  for (const Incidence& i : model.incidences) {
    const auto point = static_cast<std::size_t>(i.point);
    for (const Index contact : contacts_of_point[point]) {
      const auto c = static_cast<std::size_t>(contact);
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

  const std::vector<Index>& start = model.numbering.island_start;
  islands_.resize(model.numbering.num_islands());
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    const auto after = std::upper_bound(start.begin(), start.end(), tangents_[c].guide_row[0]);
    islands_[static_cast<std::size_t>(after - start.begin() - 1)].push_back(c);
  }
  std::erase_if(islands_, [](const auto& island) { return island.empty(); });
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
  b_ = b;
  std::copy(b, b + right_side_.size(), right_side_.begin());
}

void FrictionStage::find_multipliers(const double* x, double* lambda) {
  for (std::size_t k = 0; k < touched_rows_.size(); ++k) {
    const auto row = static_cast<std::size_t>(touched_rows_[k]);
    right_side_[row] = b_[row] + felt(k, x);
  }
  solve_(right_side_.data(), lambda, refines_);
}

void FrictionStage::find_change(const double* x, double* lambda) {
  for (std::size_t k = 0; k < touched_rows_.size(); ++k)
    change_[static_cast<std::size_t>(touched_rows_[k])] = felt(k, x);
  solve_(change_.data(), lambda, false);
}

// ---- one instant ----

Outcome FrictionStage::find(double t, const double* r, const double* v, const double* b, bool judges,
                            const double* lambda) {
  const Stopwatch watch(&model_.times.friction);
  laws_.set_state(model_.parallel, t, r, v, blocks_.data());
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    const Vec3 e = laws_.part_direction(static_cast<std::size_t>(shares_[k].part));
    shares_[k].size = touches_[k].weight * dot(load(blocks_.data(), touches_[k].block), e);
  }
  set_right_side(b);
  report_ = {.contacts = tangents_.size()};
  report_.sticking = num_sticking();
  std::copy(lambda, lambda + lambda_.size(), lambda_.begin());
  const bool all_stick = report_.sticking == report_.contacts;
  if (laws_.depend_on_reactions() && !all_stick) {
    ++model_.counters.friction_solves;
    Outcome outcome = iterate(t, lambda_.data());
    if (outcome.ok() && judges && report_.uniqueness == Uniqueness::NotAsked)
      outcome = enumerate(t, true, lambda_.data());
    model_.counters.friction_iterations += static_cast<std::size_t>(report_.iterations);
    model_.counters.solves += static_cast<std::size_t>(report_.iterations);
    if (!outcome.ok()) return outcome;
  } else if (judges) {
    report_.uniqueness = Uniqueness::Proven;  // a given force
    report_.error_bound = 0.0;
  }
  set_forces(lambda_.data());
  return std::isfinite(largest_of(x_)) ? Outcome{} : model_.not_finite(t);
}

Outcome FrictionStage::iterate(double t, double* lambda) {
  const auto converges = [&](FrictionMethod method) {
    std::copy(lambda, lambda + lambda_.size(), guess_.begin());
    const Parallel& parallel = model_.parallel;
    const FixedPoint::Result result = method == FrictionMethod::Newton ? fixed_point_.solve_by_newton(parallel, lambda)
                                      : method == FrictionMethod::Anderson
                                          ? fixed_point_.iterate(parallel, anderson_depth(tangents_.size()), lambda)
                                          : fixed_point_.iterate(parallel, 0, lambda);
    report_.method_used = method;
    report_.iterations += result.iterations;
    report_.contraction = std::max(report_.contraction, result.contraction);
    if (!result.has_converged) std::copy(guess_.begin(), guess_.end(), lambda);
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
  return enumerate(t, false, lambda);
}

/// Rounding of a single solve with an ill-conditioned S is more than the law may miss: Newton's method with refined
/// solves.
void FrictionStage::polish(const double* b, double* lambda) {
  set_right_side(b);
  refines_ = true;
  constexpr double wanted = 1e-15;
  std::vector<double> better(lambda, lambda + lambda_.size());
  const FixedPoint::Result result = fixed_point_.solve_by_newton(model_.parallel, better.data(), wanted);
  refines_ = false;
  if (!result.has_converged) return;
  std::copy(better.begin(), better.end(), lambda);
  set_forces(lambda);
}

void FrictionStage::add(double sign, double* w0, double* b) const {
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    const auto point = static_cast<std::size_t>(tangents_[c].point);
    store(w0, point, load(w0, point) + sign * model_.inverse_mass[point] * load(tau_.data(), c));
  }
  for (std::size_t k = 0; k < touched_rows_.size(); ++k) b[touched_rows_[k]] += sign * felt(k, x_.data());
}

double FrictionStage::measure(const double* lambda) {
  laws_.evaluate(model_.parallel, lambda, x_at_.data());
  double change = 0.0;
  for (std::size_t p = 0; p < x_.size(); ++p) change = larger(change, std::abs(x_[p] - x_at_[p]));
  report_.residual = change / std::max(largest_of(x_), smallest_number);
  return report_.residual;
}

// ---- few contacts: all solutions ----

/// N0 and W of the contacts of one island from the multipliers without their friction and from those that one newton
/// against the sliding of each adds.
SlidingContacts FrictionStage::collect(std::span<const std::size_t> members,
                                       const std::vector<std::vector<double>>& changes, const double* at_rest) const {
  const auto m = static_cast<Eigen::Index>(members.size());
  SlidingContacts result;
  result.N0.resize(3, m);
  const auto as_eigen = [](Vec3 a) { return Eigen::Vector3d(a.x, a.y, a.z); };
  for (Eigen::Index c = 0; c < m; ++c) {
    const std::size_t contact = members[static_cast<std::size_t>(c)];
    result.mu.push_back(laws_.coefficient(contact));
    result.N0.col(c) = as_eigen(laws_.normal_force(contact, at_rest));
  }
  for (Eigen::Index j = 0; j < m; ++j) {
    Eigen::Matrix3Xd& W = result.W.emplace_back(3, m);
    for (Eigen::Index c = 0; c < m; ++c) {
      W.col(c) = as_eigen(
          laws_.normal_force(members[static_cast<std::size_t>(c)], changes[static_cast<std::size_t>(j)].data()));
    }
  }
  return result;
}

Outcome FrictionStage::enumerate(double t, bool only_judges, double* lambda) {
  // Coulomb contacts that slide, island by island.
  std::vector<std::vector<std::size_t>> sliding;
  bool all_are_coulomb = true, all_are_full = true, all_are_few = true;
  double largest_mu = 0.0;
  std::size_t most = 0;
  for (const auto& island : islands_) {
    std::vector<std::size_t> members;
    for (const std::size_t c : island) {
      if (tangents_.sticks(c) || laws_.is_given(c)) continue;
      all_are_coulomb = all_are_coulomb && laws_.is_coulomb(c);
      all_are_full = all_are_full && laws_.is_coulomb(c) && laws_.reads_full_reaction(c);
      if (laws_.is_coulomb(c)) largest_mu = std::max(largest_mu, laws_.coefficient(c));
      members.push_back(c);
    }
    if (members.empty()) continue;
    most = std::max(most, members.size());
    sliding.push_back(std::move(members));
  }
  constexpr std::size_t most_judged = 32;
  all_are_few = most <= most_judged;
  report_.uniqueness = Uniqueness::Unproven;
  if (all_are_full && largest_mu < 1.0) {
    // Theorem A: |tau(e1) - tau(e2)| <= mu |e1 - e2| in the norm of M^-1.
    report_.uniqueness = Uniqueness::Proven;
    report_.error_bound = FixedPoint::tolerance * largest_friction() / (1.0 - largest_mu);
    if (only_judges) return {};
  }
  if (!all_are_coulomb || !all_are_few) {
    return only_judges ? Outcome{}
                       : fail(Status::NotConverged, t,
                              "the iteration for it does not converge, and its contacts are "
                              "too many to try all signs of their normal forces");
  }

  // One newton against the sliding of the j-th contact of every island at once: islands do not see each other.
  std::vector<std::vector<double>> changes;
  std::vector<double> force(x_.size());
  for (std::size_t j = 0; j < most; ++j) {
    std::fill(force.begin(), force.end(), 0.0);
    for (const auto& members : sliding) {
      if (j < members.size()) force[laws_.first_part(members[j])] = 1.0;
    }
    find_change(force.data(), changes.emplace_back(lambda_.size()).data());
    ++model_.counters.solves;
  }
  // Without the friction of those: given friction stays.
  std::vector<double> nothing(lambda_.size(), 0.0), at_rest(lambda_.size());
  laws_.evaluate(model_.parallel, nothing.data(), force.data());
  find_multipliers(force.data(), at_rest.data());
  ++model_.counters.solves;

  std::fill(force.begin(), force.end(), 0.0);
  bool is_proven = true;
  double bound = 0.0;
  for (const auto& members : sliding) {
    const SlidingContacts contacts = collect(members, changes, at_rest.data());
    SlidingSolutions solutions = find_sliding(contacts);
    const std::string name =
        model_.name_contact(members.front()) + (members.size() > 1 ? " and others of its island" : "");
    if (solutions.uniqueness == Uniqueness::None) {
      report_.uniqueness = Uniqueness::None;
      return fail(
          Status::NoSolution, t,
          name + ": no accelerations obey the law (" +
              (solutions.determinant_changes ? "the determinant changes its sign, Painleve" : "all signs were tried") +
              "); the rods jam, and the velocity would have to jump");
    }
    is_proven = is_proven && solutions.uniqueness == Uniqueness::Proven;
    if (solutions.contraction < 1.0)
      bound = std::max(bound, FixedPoint::tolerance * largest_friction() / (1.0 - solutions.contraction));
    else
      bound = std::numeric_limits<double>::quiet_NaN();
    if (solutions.uniqueness == Uniqueness::Several) {
      report_.uniqueness = Uniqueness::Several;
      if (several_are_refused_) {
        return fail(Status::NotUnique, t,
                    name + ": " + text(static_cast<double>(solutions.found.size())) +
                        " accelerations obey the law (the determinant changes its sign, Painleve)");
      }
    }
    if (only_judges) continue;
    if (solutions.found.empty()) add_by_iteration(contacts, &solutions.found);
    if (solutions.found.empty()) return fail(Status::NotConverged, t, name + ": no iteration converges");
    // The one that is nearest to what was before.
    const auto distance = [&](const Eigen::VectorXd& s) {
      double sum = 0.0;
      for (std::size_t c = 0; c < members.size(); ++c) {
        const double before = contacts.mu[c] * norm(laws_.normal_force(members[c], lambda));
        sum += std::pow(s(static_cast<Eigen::Index>(c)) - before, 2);
      }
      return sum;
    };
    const auto nearest = std::min_element(solutions.found.begin(), solutions.found.end(),
                                          [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
    for (std::size_t c = 0; c < members.size(); ++c)
      force[laws_.first_part(members[c])] = (*nearest)(static_cast<Eigen::Index>(c));
  }
  if (report_.uniqueness != Uniqueness::Several)
    report_.uniqueness = is_proven ? Uniqueness::Proven : Uniqueness::Unproven;
  if (is_proven) report_.error_bound = bound;
  if (only_judges) return {};

  report_.method_used = FrictionMethod::Enumeration;
  std::vector<double> given(x_.size());
  laws_.evaluate(model_.parallel, nothing.data(), given.data());
  for (std::size_t i = 0; i < given.size(); ++i) force[i] += given[i];
  find_multipliers(force.data(), lambda);
  ++report_.iterations;
  return {};
}

double FrictionStage::largest_friction() const {
  std::vector<double> x(x_.size());
  laws_.evaluate(model_.parallel, lambda_.data(), x.data());
  return largest_of(x);
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
