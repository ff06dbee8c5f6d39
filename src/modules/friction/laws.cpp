#include "friction/laws.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <variant>

namespace tanor::detail {

namespace {

constexpr std::size_t most_multipliers = 2;  // multipliers of the guides at one point

}  // namespace

FrictionLaws::Contact FrictionLaws::describe(const Friction& friction, Index number) {
  return std::visit(
      [&]<class Law>(const Law& law) {
        Contact contact{.law = number, .form = form_of<Law>()};
        if constexpr (requires { KindOf<Law>::reads_full_reaction(law); })
          contact.is_full = KindOf<Law>::reads_full_reaction(law);
        if constexpr (IsProportionalFriction<Law>)
          contact.coefficient = contact.static_coefficient = KindOf<Law>::magnitude(law, 1.0, 1.0);
        if constexpr (requires { KindOf<Law>::sticks(law); }) {
          contact.may_stick = KindOf<Law>::sticks(law);
          contact.static_coefficient = KindOf<Law>::static_coefficient(law);
          contact.coefficient = contact.may_stick ? KindOf<Law>::magnitude(law, 0.0, 1.0) : contact.static_coefficient;
        }
        return contact;
      },
      friction);
}

FrictionLaws::FrictionLaws(const System& system, const Numbering& numbering, const Tangents& tangents,
                           std::span<const Incidence> incidences)
    : tangents_(tangents), laws_(system.friction) {
  // The rows at each point, for laws that read all of them
  std::vector<std::vector<Term>> at_point(numbering.num_points());
  for (const Incidence& i : incidences) {
    const bool is_user = !numbering.is_contact_row(static_cast<std::size_t>(i.row));
    if (is_user) at_point[static_cast<std::size_t>(i.point)].push_back({i.row, i.block, i.sign});
  }
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const Tangents::Place& place = tangents[c];
    const Contact contact = describe(laws_[static_cast<std::size_t>(place.friction)], place.friction);
    if (contact.is_full) {
      const auto& all = at_point[static_cast<std::size_t>(place.point)];
      terms_.insert(terms_.end(), all.begin(), all.end());
    } else if (contact.form != LawForm::Given) {
      for (std::size_t g = 0; g < static_cast<std::size_t>(place.num_guides); ++g)
        terms_.push_back({place.guide_row[g], place.guide_block[g], 1.0});
    }
    term_start_.push_back(static_cast<Index>(terms_.size()));
    is_coulomb_.push_back(contact.form == LawForm::Proportional ? 1 : 0);
    contacts_.push_back(contact);
    constexpr std::array axes{Vec3{1.0, 0.0, 0.0}, Vec3{0.0, 1.0, 0.0}, Vec3{0.0, 0.0, 1.0}};
    directions_.insert(directions_.end(), axes.begin(), has_three_parts(c) ? axes.end() : axes.begin() + 1);
    part_start_.push_back(static_cast<Index>(directions_.size()));
  }
  factor_.resize(contacts_.size());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const auto& rows = tangents[c].guide_row;
    guides_.push_back({.first_row = rows[0], .second_row = tangents[c].num_guides == 2 ? rows[1] : rows[0]});
    if (has_three_parts(c))
      add_to_force_groups(c);
    else if (!is_coulomb(c) || contacts_[c].is_full)
      others_.push_back(c);
  }
}

void FrictionLaws::add_to_force_groups(std::size_t c) {
  const Index law = contacts_[c].law;
  const std::size_t num_multipliers = terms(c).size();
  auto group = std::ranges::find_if(force_groups_, [&](const ForceGroup& each) {
    return each.law == law && each.num_multipliers == num_multipliers;
  });
  if (group == force_groups_.end()) group = force_groups_.insert(group, {law, num_multipliers, {}});
  group->contacts.push_back(c);
}

void FrictionLaws::set_state(const Parallel& parallel, double t, const double* r, const double* v,
                             const double* blocks) {
  t_ = t;
  blocks_ = blocks;
  const auto set_contact = [&](std::size_t c) {
    Contact& contact = contacts_[c];
    const Vec3 velocity = tangents_.sliding_velocity(c, v);
    if (has_three_parts(c)) {
      contact.position = load(r, tangents_[c].point);
      contact.velocity = velocity;
      return;
    }
    const double speed = norm(velocity);
    Vec3& e = directions_[first_part(c)];
    if (has_reference(c)) {
      const Vec3 force = reference(c);
      factor_[c] = norm(force);
      e = factor_[c] > 0.0 ? (1.0 / factor_[c]) * force : Vec3{};
      return set_guides(c);
    }
    e = speed > 0.0 ? (-1.0 / speed) * velocity : Vec3{};
    contact.speed = speed;
    // For a proportional law this is mu, found with a normal force of 1 N.
    factor_[c] = contact.is_at_limit ? contact.static_coefficient : magnitude(law(c), speed, 1.0);
    if (contact.may_stick) e = -sliding_direction(c, velocity);
    if (is_coulomb(c) && !contact.is_full) set_guides(c);
  };
  parallel.for_ranges(contacts_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) set_contact(c);
  });
}

void FrictionLaws::set_guides(std::size_t c) {
  const auto& [first, second] = tangents_.normals(c);
  const double mu = tangents_.sticks(c) ? 0.0 : factor_[c], length = norm(first);
  const Vec3 q = length > 0.0 ? (1.0 / length) * first : Vec3{};
  const double along = dot(q, second);
  Guides& guides = guides_[c];
  guides.a = mu * length;
  guides.b = mu * along;
  guides.c = mu * norm(second - along * q);
}

/// Returns v/|v|, which keeps its sense beyond a stop, since a stop is located on a smooth motion. On a surface the
/// direction of a slow motion is stiff, as it turns at the rate mu N/(m |v|). Below `slow` the part across the last
/// direction is v/slow instead, which turns towards the same balance no faster than at that speed.
Vec3 FrictionLaws::sliding_direction(std::size_t c, const Vec3& velocity) const {
  const double speed = norm(velocity);
  const auto& [t0, t1] = tangents_.directions(c);
  const Vec3 kept = dot(t0, contacts_[c].slip) * t0 + dot(t1, contacts_[c].slip) * t1;
  const double length = norm(kept);
  if (length == 0.0) return speed > 0.0 ? (1.0 / speed) * velocity : Vec3{};
  const Vec3 before = (1.0 / length) * kept;
  if (tangents_[c].num_guides == 2) return before;
  const double forward = dot(velocity, before);
  const double slow = contacts_[c].slow;
  if (speed >= slow) return ((forward < 0.0 ? -1.0 : 1.0) / speed) * velocity;
  const Vec3 across = (1.0 / slow) * (velocity - forward * before);
  return std::sqrt(std::max(0.0, 1.0 - dot(across, across))) * before + across;
}

void FrictionLaws::keep_slip_directions(const double* v) {
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Vec3 velocity = tangents_.sliding_velocity(c, v);
    const double speed = norm(velocity);
    if (speed <= contacts_[c].rest || tangents_.sticks(c)) continue;
    // On a surface a slow direction depends on v and on the kept direction, so that keeping another one would make it
    // jump.
    const bool has_slip = dot(contacts_[c].slip, contacts_[c].slip) > 0.0;
    if (tangents_[c].num_guides == 1 && has_slip && speed < contacts_[c].slow) continue;
    contacts_[c].slip = sliding_direction(c, velocity);
    contacts_[c].is_at_limit = false;
  }
}

Vec3 FrictionLaws::reference(std::size_t c) const {
  if (!tangents_.sticks(c)) return {};
  Vec3 sum{};
  for (int k = 0; k < tangents_[c].num_tangents(); ++k) {
    const Vec3 t = tangents_.directions(c)[static_cast<std::size_t>(k)];
    sum = sum + dot(t, contacts_[c].reference) * t;
  }
  return sum;
}

Vec3 FrictionLaws::normal_force(std::size_t contact, const double* lambda, const double* blocks) const {
  Vec3 sum{};
  for (const Term& term : terms(contact)) sum = sum + term.sign * lambda[term.row] * load(blocks, term.block);
  return sum;
}

Vec3 FrictionLaws::along_tangents(std::size_t contact, const double* rows) const {
  const Tangents::Place& place = tangents_[contact];
  Vec3 sum{};
  for (int k = 0; place.first_row >= 0 && k < place.num_tangents(); ++k)
    sum = sum + rows[place.first_row + k] * tangents_.directions(contact)[static_cast<std::size_t>(k)];
  return sum;
}

/// Calls visit(contact, tau, d tau/d lambda [3][terms]) for all contacts whose law is a force. Laws are evaluated for
/// some contacts at once.
template <class Visit>
void FrictionLaws::for_forces(const Parallel& parallel, const double* lambda, bool with_derivatives,
                              const Visit& visit) const {
  constexpr std::size_t at_once = 64;
  const auto evaluate = [&]<class Law>(const Law& law, const ForceGroup& group, std::size_t begin, std::size_t end) {
    if constexpr (HasForceOfFriction<Law>) {
      const std::size_t p = group.num_multipliers;
      std::array<double, 3 * at_once> r, v, tau;
      std::array<double, most_multipliers * at_once> own;
      std::array<double, 3 * most_multipliers * at_once> derivative;
      for (std::size_t first = begin; first < end; first += at_once) {
        const std::size_t count = std::min(at_once, end - first);
        for (std::size_t k = 0; k < count; ++k) {
          const std::size_t c = group.contacts[first + k];
          store(r.data(), k, contacts_[c].position);
          store(v.data(), k, contacts_[c].velocity);
          for (std::size_t a = 0; a < p; ++a) own[p * k + a] = lambda[terms(c)[a].row];
        }
        std::fill_n(tau.begin(), 3 * count, 0.0);  // a law may write what is not 0 alone
        if (with_derivatives) std::fill_n(derivative.begin(), 3 * p * count, 0.0);
        KindOf<Law>::forces(law, {count, t_, r.data(), v.data(), own.data(), tau.data(),
                                  with_derivatives ? derivative.data() : nullptr});
        for (std::size_t k = 0; k < count; ++k)
          visit(group.contacts[first + k], load(tau.data(), k), derivative.data() + 3 * p * k);
      }
    }
  };
  for (const ForceGroup& group : force_groups_) {
    std::visit(
        [&]<class Law>(const Law& law) {
          if constexpr (HasForceOfFriction<Law>) {
            const Parallel own(KindOf<Law>::is_thread_safe(law) ? parallel.threads() : 1);
            own.for_ranges(group.contacts.size(),
                           [&](std::size_t begin, std::size_t end) { evaluate(law, group, begin, end); });
          }
        },
        laws_[static_cast<std::size_t>(group.law)]);
  }
}

void FrictionLaws::evaluate(const Parallel& parallel, const double* lambda, double* x) const {
  parallel.for_ranges(guides_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      // mu R lambda_g|^2, then all square roots together
      const Guides& guides = guides_[c];
      const double second = lambda[guides.second_row];
      const double first = guides.a * lambda[guides.first_row] + guides.b * second;
      x[part_start_[c]] = first * first + guides.c * second * (guides.c * second);
    }
    const Index first_part = part_start_[begin];
    Eigen::Map<Eigen::ArrayXd> own(x + first_part, part_start_[end] - first_part);
    own = own.sqrt();
    for (std::size_t c = begin; c < end; ++c) {
      if (has_reference(c)) x[part_start_[c]] = factor_[c];
    }
  });
  const auto evaluate_others = [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t c = others_[k];
      double* const own = x + first_part(c);
      if (tangents_.sticks(c))
        std::fill(own, x + end_part(c), has_reference(c) ? factor_[c] : 0.0);
      else if (is_coulomb(c))
        *own = factor_[c] * norm(normal_force(c, lambda));  // mu |N|
      else if (!is_given(c))
        *own = magnitude(law(c), contacts_[c].speed, norm(normal_force(c, lambda)));
      else
        *own = factor_[c];
    }
  };
  parallel.for_ranges(others_.size(), evaluate_others);
  for_forces(parallel, lambda, false,
             [&](std::size_t c, const Vec3& tau, const double*) { store(x + first_part(c), 0, tau); });
}

void FrictionLaws::apply_derivative(const Parallel& parallel, const double* lambda, const double* dlambda,
                                    double* dx) const {
  const auto apply_range = [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const std::span<const Term> all = terms(c);
      double* const own = dx + first_part(c);
      std::fill(own, dx + end_part(c), 0.0);
      if (tangents_.sticks(c) || has_three_parts(c) || all.empty()) continue;
      // dx = slope N'dN/|N|
      const Vec3 normal = normal_force(c, lambda);
      const double size = norm(normal);
      if (!(size > 0.0)) continue;
      const double slope = is_coulomb(c) ? factor_[c] : slope_in_normal_force(law(c), contacts_[c].speed, size);
      *own = slope * dot(normal, normal_force(c, dlambda)) / size;
    }
  };
  parallel.for_ranges(contacts_.size(), apply_range);
  for_forces(parallel, lambda, true, [&](std::size_t c, const Vec3&, const double* derivative) {
    const std::span<const Term> all = terms(c);
    double* const own = dx + first_part(c);
    for (std::size_t a = 0; a < all.size(); ++a) {
      for (std::size_t k = 0; k < 3; ++k) own[k] += dlambda[all[a].row] * derivative[k * all.size() + a];
    }
  });
}

void FrictionLaws::write_forces(const double* x, double* tau) const {
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    Vec3 sum{};
    for (std::size_t part = first_part(c); part < end_part(c); ++part) sum = sum + x[part] * directions_[part];
    store(tau, c, sum);
  }
}

}  // namespace tanor::detail
