#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "statics/equilibrium_equations.hpp"
#include "statics/statics_input.hpp"

namespace tanor::detail {

/// One-sided constraints, s = 1 or -1, and which of them are closed:
///
///   s xi >= 0,   s lambda >= 0,   xi lambda = 0
///
/// Rows are those of the whole system, in the user's order.
class OneSidedRows {
 public:
  using Rows = std::vector<std::size_t>;

  /// Closes the constraints that touch or are broken at the start. Throws InputError.
  OneSidedRows(const StaticsInput& input, const EquilibriumOptions& options);

  const std::vector<bool>& open() const { return open_; }
  void change(const Rows& rows);

  /// Convert between the rows of all constraints and those of the closed system; `spread` sets open rows to 0.
  std::vector<double> keep(const std::vector<double>& all) const;
  std::vector<double> spread(const std::vector<double>& kept) const;

  /// Returns the rows that contradict `found`, an equilibrium of the closed system: closed ones that pull, and of the
  /// open ones that are broken the worst one of each point.
  Rows find_wrong(const EquilibriumResult& found);
  /// Returns the open rows towards which residual forces drive points: the one that each point meets first.
  Rows find_pushed(const EquilibriumResult& found);
  Rows find_open() const;
  /// Returns the closed rows that carry no force.
  Rows find_weak(const EquilibriumResult& found);

  /// Returns "floor[3], floor[4], floor[5] and 7 more".
  std::string name(const Rows& rows) const;
  /// Replaces the members' numbers in the closed system by those of the user.
  void rename(std::string* text) const;

 private:
  void stand_at(const std::vector<double>& positions, const std::vector<double>& multipliers);
  double force_tolerance(const EquilibriumResult& found) const;
  Rows find_first_of_points(const std::vector<std::pair<double, std::size_t>>& rows) const;

  const System& system_;
  Workspace work_;
  EquilibriumEquations equations_;
  const double tolerance_;
  std::vector<int> side_;  // [row] 1 or -1; 0 if it acts both ways
  std::vector<bool> open_;
  std::vector<double> xi_, norm_;  // [row] values there, and |gradient|
  std::vector<double> rate_;       // [row] second derivative of xi by residual forces
};

/// Chooses which of the wrong rows change sides. All of them do while they become fewer, and for some rounds more; then
/// only the last one does until they are fewer than ever (Murty 1974; Judice & Pires 1994). With a positive definite
/// stiffness no set recurs; if one does, `is_stuck`.
class Exchange {
 public:
  OneSidedRows::Rows choose(const OneSidedRows::Rows& wrong, const std::vector<bool>& open);
  bool is_stuck() const { return is_stuck_; }

 private:
  std::size_t fewest_ = ~std::size_t{0};
  int patience_ = 0;
  bool is_stuck_ = false;
  std::set<std::vector<bool>> seen_;  // sets met while one row changes at a time
};

}  // namespace tanor::detail
