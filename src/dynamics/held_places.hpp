#pragma once

#include <array>
#include <optional>
#include <vector>

#include "dynamics/workspace.hpp"
#include "schur/redundancy.hpp"

namespace tanor {

/// Where contacts that stick are held: T'(r - p) = 0 beside T'(v - u) = 0, so that nothing creeps. On a guide that
/// moves the place p moves with it: across the guide as its functions of time say, along it with its own velocity u,
///
///   p_dot = u - K_g Gamma_g^-1 (K_g'u + xi_t)                     Gamma_g = K_g'K_g, all at (p, t)
///
/// which says the same as T'(p_dot - u) = 0 and K_g'p_dot + xi_t = 0. It is integrated to rounding, from the last step
/// that was accepted to wherever the places are asked for: steps that are tried and given up leave no trace.
class HeldPlaces {
 public:
  explicit HeldPlaces(Workspace& work);

  /// At t: contacts that stick and are not held are held at r from now on, contacts that slide are let go.
  void hold(double t, const double* r);
  /// None is held.
  void forget();
  /// The places at t, into the Tangents.
  void carry(double t);
  /// The step to t was accepted: from now on places come from there.
  void accept(double t);

  /// Places that other constraints do not let be reached give way: those contacts are held where they are.
  void give_way(const double* r);
  /// Largest |T'(r - place)| over the length around it; `rows` [rows] = xi(r). Rows that depend on others do not
  /// decide.
  double largest_violation(const double* rows, const Redundancy& redundancy) const;

  bool holds(std::size_t contact) const { return is_held_[contact] != 0; }

  void exchange_memory(Memory& memory);

 private:
  using Places = std::vector<Vec3>;  // of the contacts in `held_`, or how far they went from `then_`
  void list_held();
  void evaluate(double t, const Places& ways, Places* rates);
  void evaluate_guides(double t, const Places& places, bool wants_rates);
  Vec3 across(std::size_t contact, const Vec3& u) const;
  bool extrapolate(double t, double h, const Places& from, Places* ways);
  void advance_by_midpoints(double t, double h, int count, const Places& from, Places* to);
  void publish();
  double length_around(std::size_t contact) const;

  Workspace& work_;
  const Model& model_;
  const Tangents& tangents_;
  const bool guides_rest_;
  std::vector<char> is_held_;                     // [contact]
  std::vector<Vec3> then_, now_;                  // [contact] at …
  std::vector<Vec3> then_rest_, now_rest_;        // [contact] what rounding has left out of them
  double then_time_, time_;                       // … the last accepted step, and where they were asked for last
  std::vector<std::size_t> held_;                 // contacts
  std::optional<Constraints::Selection> guides_;  // of those
  std::vector<double> points_, at_rest_, rows_, blocks_;  // [3n], [3n], [d], [3 blocks] scratch
  static constexpr std::size_t most_columns = 8;
  Places ways_, next_, places_, before_, rates_;  // scratch
  std::array<Places, most_columns> table_;        // of the extrapolation, the last row: T_{j,0} … T_{j,j}
};

}  // namespace tanor
