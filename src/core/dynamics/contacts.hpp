#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

#include "dynamics/constrained_system.hpp"
#include "dynamics/roles.hpp"

namespace tanor::detail {

class Workspace;

/// The positions and velocities [3n] at one instant, and K there as blocks.
struct ContactPlace {
  double t;
  const double *r, *v, *blocks;
};

/// The options of the check for other solutions of friction.
struct UniquenessCheck {
  bool is_wanted = false;
  bool refuses_several = false;         ///< if false, the one nearest to the guess is taken and reported
  std::span<const char> are_counted{};  ///< [island] motions already counted; empty if none are
};

/// A change of the one-sided guides in the island of a contact: some have closed or opened, or an impact has changed
/// velocities as well.
enum class GuideChange : char { None, Island, Struck };

/// Friction at guides, as the equations with multipliers see it: forces tau with
///
///   S lambda + K'M^-1 tau(lambda) = -(phi + K'M^-1 f)                         (*), (43)
///
/// and rows of K that hold contacts which stick. The laws and the choice of modes are in src/modules/friction.
class Contacts {
 public:
  virtual ~Contacts() = default;

  // ---- one instant ----

  /// Finds tau at `place` with the guess `lambda` [rows], and makes it a part of w0 [3n] and b = phi + K'w0 [rows].
  virtual Outcome find(const ContactPlace& place, const UniquenessCheck& check, const double* lambda, double* w0,
                       double* b) = 0;
  /// Finds tau again, with refined solves, where that at lambda differs from it. Returns true if w0 and b have changed.
  virtual bool improve(const double* lambda, double* w0, double* b) = 0;
  /// Measures by how much tau(lambda) differs from tau, for the report.
  virtual void measure(const double* lambda) = 0;
  virtual const FrictionReport& report() const = 0;
  /// Adds to the report what is known of all modes. Rejects friction that misses its law although it is unique.
  virtual Outcome verify(double t, FrictionReport* report) const = 0;

  /// Write the friction of all contacts [3 contacts], and its sums at the points, tau [3n], N.
  virtual void write_contacts(const double* lambda, std::vector<double>* forces) const = 0;
  virtual void write_points(const double* forces, double* tau) const = 0;
  /// Write tau [3n], N: without the friction that sticking contacts hold by their rows, and by the law at lambda.
  virtual void write_given(double* tau) const = 0;
  virtual void write_at(const double* lambda, double* tau) const = 0;
  /// Return the power of all friction, W, and that of the contacts that stick.
  virtual double power(const double* lambda, const double* v) const = 0;
  virtual double held_power(const double* lambda, const double* v) const = 0;
  /// Names a contact whose reaction depends on how dependent constraints share their load, or returns an empty string.
  virtual std::string find_undetermined_reaction() const = 0;

  // ---- projections of steps ----

  /// Returns true if some contact slides under a law that reads multipliers.
  virtual bool depends_on_multipliers() const = 0;
  /// `change_to` sets tau := tau(lambda), adds s M^-1 dtau to y [3n], and returns |dtau| over the largest friction.
  /// `add_change` adds the same change again.
  virtual double change_to(const double* lambda, double s, double* y) = 0;
  virtual void add_change(double s, double* y) const = 0;

  // ---- contacts that stick ----

  /// Returns true if they hold more than can move, so that they share a load. Their rows are then a little compliant.
  virtual bool shares_loads() const = 0;
  /// Returns true if some of them hold a friction that they began with, as where they share a load.
  virtual bool have_references() const = 0;
  /// Makes them share their load. Returns true if S must be factorized again.
  virtual bool begin_sharing() = 0;
  /// Moves the places where they are held to the time t.
  virtual void carry_places(double t) = 0;
  /// Returns the largest |T'(r - place)| over the length around it, for `rows` [rows] = xi(r).
  virtual double largest_violation(const double* rows) const = 0;

  // ---- the motion ----

  /// Chooses the modes at a start and computes their accelerations. Changes v where contacts are put to rest exactly.
  virtual Outcome begin(double t, const double* r, double* v, const Request& request, const AccelerationOutput& to) = 0;
  /// Chooses them again where the events() in `which` vanish, and in islands whose one-sided `guides` [contact] have
  /// changed. The equations must be linearised there. May change v likewise.
  virtual Outcome switch_guides(double t, const double* r, double* v, std::span<const std::size_t> which,
                                std::span<const GuideChange> guides, const Request& request,
                                const AccelerationOutput& to) = 0;
  /// Notes what is known of the uniqueness of the motion from here on.
  virtual void note(Uniqueness uniqueness, const std::string& why) = 0;
  /// Notes that a step to (t, r, v) was accepted.
  virtual void accept(double t, const double* r, const double* v) = 0;
  /// Null if no contact may stick.
  virtual EventFunctions* events() = 0;
  virtual void exchange_memory(Memory& memory) = 0;
};

/// Makes the contacts of a model with friction, from which `system` is made; it is not called before both are complete.
std::unique_ptr<Contacts> make_contacts(Workspace& work, FrictionMethod method, ConstrainedSystem& system);

/// Returns a failure with the message "friction at t = 0.5: why".
Outcome fail_friction(Status status, double t, const std::string& why);

}  // namespace tanor::detail
