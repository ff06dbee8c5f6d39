#pragma once

#include <span>
#include <vector>

#include "base/memory.hpp"
#include "base/parallel.hpp"
#include "base/vec3.hpp"
#include "evaluate/tangents.hpp"
#include "friction/law_forms.hpp"

namespace tanor {

/// tau(r, v, t, lambda) of all contacts (17), (41). A contact that sticks has none but its reference: its friction is
/// the reference and the multipliers of its own rows.
///
/// At one instant tau is a sum of parts along directions that stand, tau = sum of x_p e_p: one of a law that says a
/// magnitude, e against the sliding, N = sum of lambda_a k_a; three along the axes of a law that says a force. What the
/// iterations look for are the sizes x [parts], N. The laws themselves stand in include/tanor/kinds/friction; a law
/// with x = mu |N| is called Coulomb's here, and its mu may depend on the speed.
class FrictionLaws {
 public:
  FrictionLaws(const System& system, const Numbering& numbering, const Tangents& tangents,
               std::span<const Incidence> incidences);

  /// Some law reads multipliers.
  bool depend_on_reactions() const { return !terms_.empty(); }

  /// Sliding velocities and directions at (t, r, v), K in `blocks`; `tangents` stand there.
  void set_state(const Parallel& parallel, double t, const double* r, const double* v, const double* blocks);
  /// From now on contacts slip in the direction of v (at the last place), until it is kept anew: within a step a
  /// contact does not turn back by itself.
  void keep_slip_directions(const double* v);
  /// A contact slower than `rest` has no direction but rounding; slower than `slow`, its direction on a surface lags
  /// (m/s).
  void set_speeds(std::size_t contact, double rest, double slow) {
    contacts_[contact].rest = rest;
    contacts_[contact].slow = slow;
  }
  /// Where a contact slips to that begins to slide at rest, a unit vector; 0: it is not known.
  void set_slip_direction(std::size_t contact, Vec3 direction) { contacts_[contact].slip = direction; }
  Vec3 slip_direction(std::size_t contact) const { return contacts_[contact].slip; }
  /// A contact that gave way but does not move, since others hold it: its friction is the static limit.
  void set_at_limit(std::size_t contact, bool is_at_limit) { contacts_[contact].is_at_limit = is_at_limit; }
  bool is_at_limit(std::size_t contact) const { return contacts_[contact].is_at_limit; }
  /// Friction of a contact while it sticks, N, to which its rows add. Contacts that hold more than can move share their
  /// load by it; otherwise it changes nothing.
  void set_reference(std::size_t contact, Vec3 force) { contacts_[contact].reference = force; }
  /// Along T, where it sticks; else 0.
  Vec3 reference(std::size_t contact) const;

  void exchange_memory(Memory& memory) {
    for (Contact& contact : contacts_) memory.exchange(contact.slip, contact.is_at_limit, contact.reference);
  }

  std::size_t num_parts() const { return directions_.size(); }
  std::size_t first_part(std::size_t contact) const { return static_cast<std::size_t>(part_start_[contact]); }
  std::size_t end_part(std::size_t contact) const { return static_cast<std::size_t>(part_start_[contact + 1]); }
  /// e, unit length.
  Vec3 part_direction(std::size_t part) const { return directions_[part]; }

  /// x [parts] at lambda [rows].
  void evaluate(const Parallel& parallel, const double* lambda, double* x) const;
  /// dx := (dx/d lambda) dlambda at lambda.
  void apply_derivative(const Parallel& parallel, const double* lambda, const double* dlambda, double* dx) const;
  /// tau [3 contacts], N, of x.
  void write_forces(const double* x, double* tau) const;

  bool is_coulomb(std::size_t contact) const { return is_coulomb_[contact] != 0; }
  /// Its friction is a force in any direction.
  bool has_three_parts(std::size_t contact) const { return contacts_[contact].form == LawForm::ThreeParts; }
  /// Reads no multiplier.
  bool is_given(std::size_t contact) const { return term_start_[contact] == term_start_[contact + 1]; }
  /// mu of a Coulomb contact, with what a regularisation leaves of it.
  double coefficient(std::size_t contact) const { return factor_[contact]; }
  double coefficient_of_sliding(std::size_t contact) const { return contacts_[contact].coefficient; }
  double static_coefficient(std::size_t contact) const { return contacts_[contact].static_coefficient; }
  /// Where it slides to, unit length.
  Vec3 direction(std::size_t contact) const {
    return has_three_parts(contact) ? Vec3{} : -directions_[first_part(contact)];
  }
  bool reads_full_reaction(std::size_t contact) const { return contacts_[contact].is_full; }
  /// N of a Coulomb contact.
  Vec3 normal_force(std::size_t contact, const double* lambda) const;

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
    Vec3 position{}, velocity{};                 // at the last place, where it has three parts
  };
  static Contact describe(const Friction& law, Index number);
  void set_guides(std::size_t contact);
  Vec3 sliding_direction(std::size_t contact, const Vec3& velocity) const;
  bool has_reference(std::size_t contact) const {
    return tangents_.sticks(contact) && dot(contacts_[contact].reference, contacts_[contact].reference) > 0.0;
  }
  const Friction& law(std::size_t contact) const { return laws_[static_cast<std::size_t>(contacts_[contact].law)]; }
  Vec3 force(std::size_t contact, const double* lambda, double* derivative) const;
  std::span<const Term> terms(std::size_t contact) const {
    return {terms_.data() + term_start_[contact], terms_.data() + term_start_[contact + 1]};
  }

  const Tangents& tangents_;
  std::vector<Friction> laws_;  // as the system lists them
  std::vector<Contact> contacts_;
  std::vector<Index> term_start_{0};  // [contact + 1]
  std::vector<Term> terms_;
  std::vector<Index> part_start_{0};  // [contact + 1]
  // What every iteration reads, at the last place: guides' normals K_g = Q R, so mu |N| = |mu R lambda_g|.
  struct Guides {
    double a = 0.0, b = 0.0, c = 0.0;  // mu R = [a b; 0 c]; 0: it sticks, or its law is no such one
    Index first_row, second_row;
  };
  std::vector<Guides> guides_;       // [contact]
  std::vector<std::size_t> others_;  // contacts whose law is not Coulomb's, or reads the full reaction
  std::vector<char> is_coulomb_;
  std::vector<double> factor_;      // [contact] mu of a Coulomb contact; x itself of a given one
  std::vector<Vec3> directions_;    // [part]
  const double* blocks_ = nullptr;  // K at the last place
  double t_ = 0.0;
  bool threads_are_safe_ = true;
};

}  // namespace tanor
