#pragma once

#include <span>
#include <variant>
#include <vector>

#include <tanor/forward.hpp>
#include <tanor/kinds.hpp>

#include "base/memory.hpp"
#include "base/parallel.hpp"
#include "base/vec3.hpp"
#include "evaluate/tangents.hpp"
#include "system/friction_magnitude.hpp"

namespace tanor::detail {

enum class LawForm {
  Given,         ///< a magnitude that depends on the speed alone
  Proportional,  ///< mu(speed) |N|
  Magnitude,     ///< any other magnitude that depends on |N|
  ThreeParts     ///< a force in any direction
};

template <class Law>
constexpr LawForm form_of() {
  if (HasForceOfFriction<Law>) return LawForm::ThreeParts;
  if (IsProportionalFriction<Law>) return LawForm::Proportional;
  return ReadsNormalForce<Law> ? LawForm::Magnitude : LawForm::Given;
}

template <class T, class... Laws>
T magnitude(const std::variant<Laws...>& friction, double speed, const T& normal) {
  return std::visit([&](const auto& law) { return magnitude_of(law, speed, normal); }, friction);
}

/// Returns the derivative of `magnitude` in |N|.
template <class... Laws>
double slope_in_normal_force(const std::variant<Laws...>& friction, double speed, double normal) {
  return magnitude(friction, speed, Forward<1>::variable(normal, 0)).d[0];
}

/// Evaluates tau(r, v, t, lambda) of all contacts (17), (41). For a contact that sticks this is only its reference; its
/// friction is the reference and the multipliers of its own rows.
///
/// At one instant tau is a sum of parts along fixed directions, tau = sum of x_p e_p. A law for a magnitude has one
/// part, with e against the sliding and N = sum of lambda_a k_a; a law for a force has three parts along the axes. The
/// unknowns of the iterations are the sizes x [parts], N. The laws themselves are in include/tanor/kinds/friction; a
/// law with x = mu |N| is called Coulomb's here, and its mu may depend on the speed.
class FrictionLaws {
 public:
  FrictionLaws(const System& system, const Numbering& numbering, const Tangents& tangents,
               std::span<const Incidence> incidences);

  /// Returns true if some law reads multipliers.
  bool depend_on_reactions() const { return !terms_.empty(); }

  /// Sets sliding velocities and directions at (t, r, v), with K in `blocks`; `tangents` must be current there.
  void set_state(const Parallel& parallel, double t, const double* r, const double* v, const double* blocks);
  /// Keeps the direction of v (at the last configuration) as that of sliding until the next call, since a contact does
  /// not turn back by itself within a step.
  void keep_slip_directions(const double* v);
  /// Sets the speeds of a contact, m/s. Slower than `rest`, it has no direction but rounding; slower than `slow`, its
  /// direction on a surface lags.
  void set_speeds(std::size_t contact, double rest, double slow) {
    contacts_[contact].rest = rest;
    contacts_[contact].slow = slow;
  }
  /// Sets where a contact slips to that begins to slide from rest, a unit vector; 0 if it is not known.
  void set_slip_direction(std::size_t contact, Vec3 direction) { contacts_[contact].slip = direction; }
  Vec3 slip_direction(std::size_t contact) const { return contacts_[contact].slip; }
  /// Marks a contact that gave way but does not move, since others hold it. Its friction is the static limit.
  void set_at_limit(std::size_t contact, bool is_at_limit) { contacts_[contact].is_at_limit = is_at_limit; }
  bool is_at_limit(std::size_t contact) const { return contacts_[contact].is_at_limit; }
  /// Sets the friction of a contact while it sticks, N, to which its rows add. Contacts that hold more than can move
  /// share their load by it; otherwise it changes nothing.
  void set_reference(std::size_t contact, Vec3 force) { contacts_[contact].reference = force; }
  /// Returns the reference along T if the contact sticks, else 0.
  Vec3 reference(std::size_t contact) const;

  void exchange_memory(Memory& memory) {
    for (Contact& contact : contacts_) memory.exchange(contact.slip, contact.is_at_limit, contact.reference);
  }

  std::size_t num_parts() const { return directions_.size(); }
  std::size_t first_part(std::size_t contact) const { return static_cast<std::size_t>(part_start_[contact]); }
  std::size_t end_part(std::size_t contact) const { return static_cast<std::size_t>(part_start_[contact + 1]); }
  /// Returns e, of unit length.
  Vec3 part_direction(std::size_t part) const { return directions_[part]; }

  /// Computes x [parts] at lambda [rows].
  void evaluate(const Parallel& parallel, const double* lambda, double* x) const;
  /// Computes dx := (dx/d lambda) dlambda at lambda.
  void apply_derivative(const Parallel& parallel, const double* lambda, const double* dlambda, double* dx) const;
  /// Writes tau [3 contacts], N, of x.
  void write_forces(const double* x, double* tau) const;

  bool is_coulomb(std::size_t contact) const { return is_coulomb_[contact] != 0; }
  /// Returns true if the friction is a force in any direction.
  bool has_three_parts(std::size_t contact) const { return contacts_[contact].form == LawForm::ThreeParts; }
  /// Returns true if the contact reads no multiplier.
  bool is_given(std::size_t contact) const { return term_start_[contact] == term_start_[contact + 1]; }
  /// Returns mu of a Coulomb contact, reduced by a regularisation.
  double coefficient(std::size_t contact) const { return factor_[contact]; }
  double coefficient_of_sliding(std::size_t contact) const { return contacts_[contact].coefficient; }
  double static_coefficient(std::size_t contact) const { return contacts_[contact].static_coefficient; }
  /// Returns the direction of sliding, of unit length.
  Vec3 direction(std::size_t contact) const {
    return has_three_parts(contact) ? Vec3{} : -directions_[first_part(contact)];
  }
  /// Returns the sum of a contact's own numbers in `rows` [rows] along its directions T; 0 if it may not stick.
  Vec3 along_tangents(std::size_t contact, const double* rows) const;
  /// Returns the friction of a contact that sticks, N: its reference plus the multipliers of its own rows, lambda
  /// [rows].
  Vec3 held(std::size_t contact, const double* lambda) const {
    return reference(contact) + along_tangents(contact, lambda);
  }
  /// Returns the largest friction that the contact could hold, mu_s |N| at lambda [rows], N.
  double static_limit(std::size_t contact, const double* lambda) const {
    return static_coefficient(contact) * norm(normal_force(contact, lambda));
  }
  bool reads_full_reaction(std::size_t contact) const { return contacts_[contact].is_full; }
  /// Returns N of a Coulomb contact.
  Vec3 normal_force(std::size_t contact, const double* lambda) const { return normal_force(contact, lambda, blocks_); }
  /// Does the same with another K.
  Vec3 normal_force(std::size_t contact, const double* lambda, const double* blocks) const;

 private:
  struct Term {
    Index row, block;
    double sign;
  };
  struct Contact {
    Index law;  // in laws_
    LawForm form;
    bool may_stick = false, is_full = false, is_at_limit = false;
    double coefficient = 0.0, static_coefficient = 0.0;
    double rest = 0.0, slow = 0.0, speed = 0.0;  // m/s
    Vec3 slip{};                                 // last direction of sliding that was kept
    Vec3 reference{};                            // N
    Vec3 position{}, velocity{};                 // at the last configuration, if it has three parts
  };
  static Contact describe(const Friction& law, Index number);
  void add_to_force_groups(std::size_t contact);
  void set_guides(std::size_t contact);
  Vec3 sliding_direction(std::size_t contact, const Vec3& velocity) const;
  bool has_reference(std::size_t contact) const {
    return tangents_.sticks(contact) && dot(contacts_[contact].reference, contacts_[contact].reference) > 0.0;
  }
  const Friction& law(std::size_t contact) const { return laws_[static_cast<std::size_t>(contacts_[contact].law)]; }
  template <class Visit>
  void for_forces(const Parallel& parallel, const double* lambda, bool with_derivatives, const Visit& visit) const;
  std::span<const Term> terms(std::size_t contact) const {
    return {terms_.data() + term_start_[contact], terms_.data() + term_start_[contact + 1]};
  }

  const Tangents& tangents_;
  std::vector<Friction> laws_;  // in the order of the system
  std::vector<Contact> contacts_;
  std::vector<Index> term_start_{0};  // [contact + 1]
  std::vector<Term> terms_;
  std::vector<Index> part_start_{0};  // [contact + 1]
  // Numbers of the last configuration that every iteration reads. The guides' normals are K_g = Q R, so that
  // mu |N| = |mu R lambda_g|.
  struct Guides {
    double a = 0.0, b = 0.0, c = 0.0;  // mu R = [a b; 0 c]; 0 if the contact sticks or has another law
    Index first_row, second_row;
  };
  std::vector<Guides> guides_;       // [contact]
  std::vector<std::size_t> others_;  // contacts whose law is a magnitude but not Coulomb's, or reads the full reaction
  /// Contacts of one law for a force, with as many multipliers each.
  struct ForceGroup {
    Index law;
    std::size_t num_multipliers;
    std::vector<std::size_t> contacts;
  };
  std::vector<ForceGroup> force_groups_;
  std::vector<char> is_coulomb_;
  std::vector<double> factor_;      // [contact] mu of a Coulomb contact; x itself if given
  std::vector<Vec3> directions_;    // [part]
  const double* blocks_ = nullptr;  // K at the last configuration
  double t_ = 0.0;
};

}  // namespace tanor::detail
