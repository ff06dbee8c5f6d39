#pragma once

#include <vector>

#include "dynamics/contact_response.hpp"
#include "dynamics/contacts.hpp"
#include "dynamics/workspace.hpp"
#include "friction/contact_coupling.hpp"
#include "friction/fixed_point.hpp"
#include "friction/laws.hpp"
#include "friction/sliding_islands.hpp"

namespace tanor::detail {

/// Friction as a part of the equations (31). Finds tau(r, v, t, lambda) such that
///
///   S lambda + K'M^-1 tau(lambda) = -(phi + K'M^-1 f)                         (*), (43)
///
/// Each evaluation of tau(lambda) costs one solve with the present factor of S; Newton's steps cost more. Once found,
/// tau is a given force.
class FrictionSolver final : private Response {
 public:
  /// All arguments must outlive this object.
  FrictionSolver(Workspace& work, FrictionLaws& laws, FrictionMethod method, ContactResponse& response);

  const FrictionLaws& laws() const { return laws_; }
  const ContactIslands& islands() const { return islands_; }
  const ContactCoupling& coupling() const { return coupling_; }

  /// Sets the accelerations [neighbourhood], m/s^2, that measure friction where it vanishes.
  void set_accelerations(const std::vector<double>& accelerations) { scales_.set_accelerations(accelerations); }
  /// Sets the state, with K there, and computes the directions of sliding.
  void set_place(const ContactPlace& place);
  /// Finds tau at `place` for b = phi + K'w0 [rows], with the guess `lambda` [rows].
  Outcome find(const ContactPlace& place, const double* b, const UniquenessCheck& check, const double* lambda);
  /// Solves again from lambda near the answer, with refined solves; b is without friction.
  void refine(const double* b, const double* lambda);
  /// Sets tau without Coulomb friction: given forces, and a user's laws at lambda.
  void set_given(const ContactPlace& place, const double* lambda);

  /// Adds tau to w0 [3n] and b [rows]: w0 += sign M^-1 tau, b += sign K'M^-1 tau.
  void add(double sign, double* w0, double* b) const;
  /// `change_to` sets tau := tau(lambda), adds s M^-1 dtau to y [3n], and returns |dtau| over the largest friction.
  /// `add_change` adds the same change again.
  double change_to(const double* lambda, double s, double* y);
  void add_change(double s, double* y) const;
  /// Returns |tau(lambda) - tau| over the largest friction, and writes it into the report.
  double measure(const double* lambda);

  /// Returns the present friction of a contact, whether it sticks or slides, N.
  Vec3 force(std::size_t contact, const double* lambda) const;
  /// Write the friction of all contacts [3 contacts], and its sums at the points, tau [3n].
  void write_contacts(const double* lambda, std::vector<double>* forces) const;
  void write_points(const double* forces, double* tau) const;
  /// Write tau [3n], N: without the friction that sticking contacts hold by their rows, and by the law at lambda.
  void write_given(double* tau) const;
  void write_at(const double* lambda, double* tau) const;
  /// Return the power of all friction, W, and that of the contacts that stick.
  double power(const double* lambda, const double* v) const;
  double held_power(const double* lambda, const double* v) const;

  std::size_t num_sticking() const { return tangents_.num_sticking(); }
  /// Returns true if some contact slides under a law that reads multipliers.
  bool depends_on_multipliers() const { return laws_.depend_on_reactions() && num_sticking() < tangents_.size(); }
  const FrictionReport& report() const { return report_; }

  void exchange_memory(Memory& memory) {
    memory.exchange(now_.x, now_.tau);
    laws_.exchange_memory(memory);
  }

 private:
  struct Friction {
    std::vector<double> x;    // [parts]
    std::vector<double> tau;  // [3 contacts], of x
  };
  void find_multipliers(const double* x, double* lambda) override;
  void find_change(const double* x, double* lambda) override;
  void set_right_side(const double* b);
  void set_forces(const double* lambda);
  Outcome iterate(double t, const UniquenessCheck& check, const double* guess, double* lambda);
  bool converges(FrictionMethod method, double poor, const double* guess, double* lambda);

  Workspace& work_;
  const Model& model_;
  const Tangents& tangents_;
  const FrictionMethod method_;
  ContactResponse& response_;
  FrictionLaws& laws_;
  const ContactIslands islands_;
  ContactCoupling coupling_;
  FrictionScales scales_;
  FixedPoint fixed_point_;
  SlidingIslands sliding_;
  bool refines_ = false;            // true while solves are refined
  double amplification_ = 0.0;      // 1/(1 - L) if the constant L is proven; otherwise NaN
  std::vector<double> right_side_;  // [rows] b where nothing is touched
  std::vector<double> b_touched_;   // [touched row]
  std::vector<double> change_;      // [rows] 0 where nothing is touched
  std::vector<double> lambda_;      // [rows] in the iterations
  Friction now_, before_;
  FrictionReport report_;
};

}  // namespace tanor::detail
