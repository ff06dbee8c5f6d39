#pragma once

#include <array>
#include <optional>
#include <vector>

#include "dynamics/workspace.hpp"

namespace tanor {

/// Moves places on guides that move: across the guide as its functions of time say, along it with its own velocity u,
///
///   p_dot = u - K_g Gamma_g^-1 (K_g'u + xi_t)                     Gamma_g = K_g'K_g, all at (p, t)
///
/// which says the same as T'(p_dot - u) = 0 and K_g'p_dot + xi_t = 0. It is integrated to rounding.
class GuideMotion {
 public:
  using Places = std::vector<Vec3>;  ///< of the contacts that are moved, or how far they went

  explicit GuideMotion(Workspace& work);

  /// No guide ever moves.
  bool guides_rest() const { return guides_rest_; }
  /// The contacts whose places are moved from now on, of 1 or 2 guides each.
  void select(std::vector<std::size_t> contacts);
  const std::vector<std::size_t>& contacts() const { return contacts_; }

  /// How far the places, `start` at the time `from`, go until t.
  const Places& advance(const Places& start, double from, double t);
  /// Puts places back onto their guides at t: off them by rounding, they would slowly drift along them as well.
  void put_on_guides(double t, Places* places);

  /// m, around a contact.
  double length_around(std::size_t contact) const;

 private:
  bool extrapolate(double t, double h, const Places& from, Places* ways);
  void advance_by_midpoints(double t, double h, int count, const Places& from, Places* to);
  void evaluate(double t, const Places& ways, Places* rates);
  void evaluate_guides(double t, const Places& places, bool wants_rates);
  void select_guides();
  Vec3 across(std::size_t contact, const Vec3& u) const;

  Workspace& work_;
  const Model& model_;
  const Tangents& tangents_;
  const bool guides_rest_;
  std::vector<std::size_t> contacts_;
  std::optional<Constraints::Selection> guides_;          // of the contacts; none: not listed yet
  std::vector<double> points_, at_rest_, rows_, blocks_;  // [3n], [3n], [d], [3 blocks] scratch
  static constexpr std::size_t most_columns = 8;
  Places start_, ways_, next_, places_, before_, rates_;  // scratch
  std::array<Places, most_columns> table_;                // of the extrapolation, the last row: T_{j,0} … T_{j,j}
};

}  // namespace tanor
