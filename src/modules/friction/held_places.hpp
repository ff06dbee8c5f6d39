#pragma once

#include <array>
#include <optional>
#include <vector>

#include "dynamics/dependences.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// The places where sticking contacts are held: T'(r - p) = 0 beside T'(v - u) = 0, so that they do not creep. A place
/// moves from the last accepted step to the requested time: across a moving guide by its functions of time, along it
/// with its own velocity u,
///
///   p_dot = u - K_g Gamma_g^-1 (K_g'u + xi_t)                     Gamma_g = K_g'K_g, all at (p, t)
///
/// This is equivalent to T'(p_dot - u) = 0 and K_g'p_dot + xi_t = 0. It is integrated to rounding. Rejected steps leave
/// no trace.
class HeldPlaces {
 public:
  explicit HeldPlaces(Workspace& work);

  /// Holds at r, at the time t, all contacts that stick and are not held yet. Releases the contacts that slide.
  void hold(double t, const double* r);
  /// Releases all contacts.
  void forget();
  /// Moves the places to t and passes them to the Tangents.
  void carry(double t);
  /// Accepts the step to t; places start from there from now on.
  void accept(double t);

  /// Moves to r the places that other constraints keep from being reached.
  void give_way(const double* r);
  /// Returns the largest |T'(r - place)| over the length around it, for `rows` [rows] = xi(r). Dependent rows do not
  /// count.
  double largest_violation(const double* rows, const Dependences& redundancy) const;

  bool holds(std::size_t contact) const { return is_held_[contact] != 0; }

  void exchange_memory(Memory& memory);

 private:
  using Places = std::vector<Vec3>;  // of the contacts that are held, or their displacements
  /// The places at one time.
  struct Instant {
    double time;
    std::vector<Vec3> places, rest;  // [contact] places, and their rounding errors
  };
  void list_held();
  void publish();
  double length_around(std::size_t contact) const;
  void advance(double from, double t);
  bool extrapolate(double t, double h, const Places& from, Places* ways);
  void advance_by_midpoints(double t, double h, int count, const Places& from, Places* to);
  void evaluate(double t, const Places& ways, Places* rates);
  void evaluate_guides(double t, const Places& places, bool wants_rates);
  void select_guides();
  Vec3 across(std::size_t contact, const Vec3& u) const;

  Workspace& work_;
  Tangents& tangents_;
  const bool guides_rest_;                                // no guide ever moves
  std::vector<char> is_held_;                             // [contact]
  std::vector<std::size_t> held_;                         // the contacts that are held
  Instant then_, now_;                                    // at the last accepted step, and at the last requested time
  std::optional<Constraints::Selection> guides_;          // of the contacts that are held; none if not listed yet
  std::vector<double> points_, at_rest_, rows_, blocks_;  // [3n], [3n], [d], [3 blocks] scratch
  static constexpr std::size_t most_columns = 8;
  Places start_, ways_, next_, places_, before_, rates_;  // scratch
  std::array<Places, most_columns> table_;                // last row of the extrapolation table: T_{j,0} … T_{j,j}
};

}  // namespace tanor::detail
