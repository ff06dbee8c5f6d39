#include "friction/laws.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <variant>

namespace tanor {

namespace {

constexpr std::size_t most_multipliers = 2;  // of the guides at one point

}  // namespace

FrictionLaws::FrictionLaws(const System& system, const Numbering& numbering, const Tangents& tangents,
                           std::span<const Incidence> incidences)
    : tangents_(tangents) {
  // The rows at each point, for laws that read all of them.
  std::vector<std::vector<Term>> at_point(numbering.num_points());
  for (const Incidence& i : incidences) {
    const bool is_user = !numbering.is_contact_row(static_cast<std::size_t>(i.row));
    if (is_user) at_point[static_cast<std::size_t>(i.point)].push_back({i.row, i.block, i.sign});
  }
  std::vector<Index> kernel_of_entry(system.friction.size(), -1);
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const Tangents::Place& place = tangents[c];
    const auto entry_index = static_cast<std::size_t>(place.friction);
    Contact contact{};
    const auto add_guides = [&] {
      for (std::size_t g = 0; g < static_cast<std::size_t>(place.num_guides); ++g)
        terms_.push_back({place.guide_row[g], place.guide_block[g], 1.0});
    };
    if (const auto* coulomb = std::get_if<Coulomb>(&system.friction[entry_index])) {
      contact.law = Law::Coulomb;
      contact.is_full = coulomb->reaction == Coulomb::Reaction::Full;
      contact.coefficient = coulomb->coefficient;
      contact.static_coefficient = coulomb->static_coefficient.value_or(coulomb->coefficient);
      contact.regularisation = coulomb->regularisation.value_or(0.0);
      if (contact.is_full) {
        const auto& all = at_point[static_cast<std::size_t>(place.point)];
        terms_.insert(terms_.end(), all.begin(), all.end());
      } else {
        add_guides();
      }
    } else if (const auto* viscous = std::get_if<Viscous>(&system.friction[entry_index])) {
      contact.law = Law::Viscous;
      contact.coefficient = viscous->coefficient;
    } else {
      static_assert(std::variant_size_v<Friction> == 3, "a new law needs its branch here");
      const FrictionKernel& kernel = std::get<UserFriction>(system.friction[entry_index]).kernel;
      contact.law = Law::User;
      if (kernel_of_entry[entry_index] < 0) {
        kernel_of_entry[entry_index] = static_cast<Index>(kernels_.size());
        kernels_.push_back(kernel);
        threads_are_safe_ = threads_are_safe_ && kernel.thread_safe;
      }
      contact.user = static_cast<Index>(users_.size());
      users_.push_back({.kernel = kernel_of_entry[entry_index]});
      add_guides();
    }
    term_start_.push_back(static_cast<Index>(terms_.size()));
    is_coulomb_.push_back(contact.law == Law::Coulomb ? 1 : 0);
    contacts_.push_back(contact);
    constexpr std::array axes{Vec3{1.0, 0.0, 0.0}, Vec3{0.0, 1.0, 0.0}, Vec3{0.0, 0.0, 1.0}};
    directions_.insert(directions_.end(), axes.begin(), contact.law == Law::User ? axes.end() : axes.begin() + 1);
    part_start_.push_back(static_cast<Index>(directions_.size()));
  }
  factor_.resize(contacts_.size());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const auto& rows = tangents[c].guide_row;
    guides_.push_back({.first_row = rows[0], .second_row = tangents[c].num_guides == 2 ? rows[1] : rows[0]});
    if (!is_coulomb(c) || contacts_[c].is_full) others_.push_back(c);
  }
}

void FrictionLaws::set_state(const Parallel& parallel, double t, const double* r, const double* v,
                             const double* blocks) {
  t_ = t;
  blocks_ = blocks;
  const auto set_contact = [&](std::size_t c) {
    const Contact& contact = contacts_[c];
    const Vec3 velocity = tangents_.sliding_velocity(c, v);
    if (contact.law == Law::User) {
      User& user = users_[static_cast<std::size_t>(contact.user)];
      user.position = load(r, tangents_[c].point);
      user.velocity = velocity;
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
    if (contact.law == Law::Viscous) {
      factor_[c] = contact.coefficient * speed;
      return;
    }
    if (contact.regularisation > 0.0) {
      // mu |v|/sqrt(v^2 + v0^2) along v/|v|
      factor_[c] = contact.coefficient * speed / std::hypot(speed, contact.regularisation);
    } else {
      factor_[c] = contact.is_at_limit ? contact.static_coefficient : contact.coefficient;
      e = -sliding_direction(c, velocity);
    }
    if (!contact.is_full) set_guides(c);
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

/// v/|v|, on as before beyond a stop: it is located on a smooth motion. On a surface the direction of a slow motion is
/// stiff, it turns at the rate mu N/(m |v|): below `slow` the part across the last sense is v/slow instead, which
/// turns towards the same balance no faster than at that speed.
Vec3 FrictionLaws::sliding_direction(std::size_t c, const Vec3& velocity) const {
  const double speed = norm(velocity);
  const auto& [t0, t1] = tangents_.directions(c);
  const Vec3 kept = dot(t0, contacts_[c].sense) * t0 + dot(t1, contacts_[c].sense) * t1;
  const double length = norm(kept);
  if (length == 0.0) return speed > 0.0 ? (1.0 / speed) * velocity : Vec3{};
  const Vec3 sense = (1.0 / length) * kept;
  if (tangents_[c].num_guides == 2) return sense;
  const double forward = dot(velocity, sense);
  const double slow = contacts_[c].slow;
  if (speed >= slow) return ((forward < 0.0 ? -1.0 : 1.0) / speed) * velocity;
  const Vec3 across = (1.0 / slow) * (velocity - forward * sense);
  return std::sqrt(std::max(0.0, 1.0 - dot(across, across))) * sense + across;
}

void FrictionLaws::keep_senses(const double* v) {
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Vec3 velocity = tangents_.sliding_velocity(c, v);
    const double speed = norm(velocity);
    if (speed <= contacts_[c].rest || tangents_.sticks(c)) continue;
    // On a surface a slow direction is a function of v and of one sense: another one would make it jump.
    const bool has_sense = dot(contacts_[c].sense, contacts_[c].sense) > 0.0;
    if (tangents_[c].num_guides == 1 && has_sense && speed < contacts_[c].slow) continue;
    contacts_[c].sense = sliding_direction(c, velocity);
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

Vec3 FrictionLaws::normal_force(std::size_t contact, const double* lambda) const {
  Vec3 sum{};
  for (const Term& term : terms(contact)) sum = sum + term.sign * lambda[term.row] * load(blocks_, term.block);
  return sum;
}

/// tau of a user's law; d tau/d lambda [3][terms] unless null.
Vec3 FrictionLaws::user_friction(std::size_t c, const double* lambda, double* derivative) const {
  const User& user = users_[static_cast<std::size_t>(contacts_[c].user)];
  const std::span<const Term> all = terms(c);
  std::array<double, most_multipliers> own{};
  for (std::size_t a = 0; a < all.size(); ++a) own[a] = lambda[all[a].row];
  const FrictionKernel& kernel = kernels_[static_cast<std::size_t>(user.kernel)];
  const std::array r{user.position.x, user.position.y, user.position.z};
  const std::array v{user.velocity.x, user.velocity.y, user.velocity.z};
  std::array<double, 3> tau{};
  kernel.evaluate(kernel.context.get(), {1, t_, r.data(), v.data(), own.data(), tau.data(), derivative});
  return make_vec3(tau);
}

void FrictionLaws::evaluate(const Parallel& parallel, const double* lambda, double* x) const {
  parallel.for_ranges(guides_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      // |mu R lambda_g|^2, then all roots together
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
      else if (is_user(c))
        store(own, 0, user_friction(c, lambda, nullptr));
      else
        *own = factor_[c];
    }
  };
  if (threads_are_safe_) return parallel.for_ranges(others_.size(), evaluate_others);
  evaluate_others(0, others_.size());
}

void FrictionLaws::apply_derivative(const Parallel& parallel, const double* lambda, const double* dlambda,
                                    double* dx) const {
  const auto apply_range = [&](std::size_t begin, std::size_t end) {
    std::array<double, 3 * most_multipliers> derivative;
    for (std::size_t c = begin; c < end; ++c) {
      const std::span<const Term> all = terms(c);
      double* const own = dx + first_part(c);
      std::fill(own, dx + end_part(c), 0.0);
      if (tangents_.sticks(c)) continue;
      if (is_coulomb(c)) {
        // mu N'dN/|N|
        const Vec3 normal = normal_force(c, lambda);
        const double size = norm(normal);
        if (size > 0.0) *own = factor_[c] * dot(normal, normal_force(c, dlambda)) / size;
      } else if (is_user(c)) {
        derivative.fill(0.0);
        user_friction(c, lambda, derivative.data());
        for (std::size_t a = 0; a < all.size(); ++a) {
          for (std::size_t k = 0; k < 3; ++k) own[k] += dlambda[all[a].row] * derivative[k * all.size() + a];
        }
      }
    }
  };
  if (threads_are_safe_) return parallel.for_ranges(contacts_.size(), apply_range);
  apply_range(0, contacts_.size());
}

void FrictionLaws::write_forces(const double* x, double* tau) const {
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    Vec3 sum{};
    for (std::size_t part = first_part(c); part < end_part(c); ++part) sum = sum + x[part] * directions_[part];
    store(tau, c, sum);
  }
}

}  // namespace tanor
