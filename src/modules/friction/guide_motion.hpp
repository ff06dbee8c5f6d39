#pragma once

#include <array>
#include <optional>
#include <vector>

#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Moves places on moving guides: across the guide by its functions of time, along it with its own velocity u,
///
///   p_dot = u - K_g Gamma_g^-1 (K_g'u + xi_t)                     Gamma_g = K_g'K_g, all at (p, t)
///
/// This is equivalent to T'(p_dot - u) = 0 and K_g'p_dot + xi_t = 0. It is integrated to rounding.
class GuideMotion {
 public:
  using Places = std::vector<Vec3>;  ///< of the contacts that are moved, or their displacements

  explicit GuideMotion(Workspace& work);

  /// Returns true if no guide ever moves.
  bool guides_rest() const { return guides_rest_; }
  /// Selects the contacts whose places are moved from now on; each has 1 or 2 guides.
  void select(std::vector<std::size_t> contacts);
  const std::vector<std::size_t>& contacts() const { return contacts_; }

  /// Returns the displacements until t of the places that are at `start` at the time `from`.
  const Places& advance(const Places& start, double from, double t);
  /// Puts places back onto their guides at t. An error across the guide, even of rounding size, would make them drift
  /// along it.
  void put_on_guides(double t, Places* places);

  /// Returns the length around a contact, m.
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
  std::optional<Constraints::Selection> guides_;          // of the contacts; none if not listed yet
  std::vector<double> points_, at_rest_, rows_, blocks_;  // [3n], [3n], [d], [3 blocks] scratch
  static constexpr std::size_t most_columns = 8;
  Places start_, ways_, next_, places_, before_, rates_;  // scratch
  std::array<Places, most_columns> table_;                // last row of the extrapolation table: T_{j,0} … T_{j,j}
};

}  // namespace tanor::detail
