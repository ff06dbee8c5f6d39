#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include <tanor/system.hpp>

#include "base/parallel.hpp"

namespace tanor::detail {

/// A constraint that acts to one side: its gap, sign xi, is 0 or more, and so is its force, sign lambda.
struct OneSidedRow {
  Index row;           ///< inner
  double sign;         ///< 1 for `at_least`, -1 for `at_most`
  double restitution;  ///< Newton's
};

/// The inner order of points and rows. Outside, the user's order holds everywhere.
///
/// Islands (points connected by constraints; supports connect nothing) follow one another, those of one point by kinds.
/// Inside an island points and rows run along its paths, leaves first. So neighbours in space are neighbours in memory,
/// a chain gives a tridiagonal S, and a tree is eliminated without fill, each of its branches in one piece. Round a
/// ring, its row a joins its points a and a + 1, and the last row joins the last point and the first. Free points come
/// after the islands, supports last. Rows that join supports alone are idle and come after those of the islands.
/// Contacts that may stick have rows of their own (see contacts.hpp), whose numbers follow those of the user's rows.
struct Numbering {
  std::vector<Index> user_point;    ///< [inner point] -> user's point
  std::vector<Index> inner_point;   ///< [user's point] -> inner point
  std::vector<Index> user_row;      ///< [inner row] -> user's row; `num_user_rows` and above for contacts
  std::vector<Index> member_row;    ///< [member in the user's order] -> its first inner row; contacts at the end
  std::vector<Index> island_start;  ///< first row of each island, and the number of rows that are not idle
  std::size_t num_moving = 0;       ///< inner points below this move, the others are supports
  std::size_t num_user_rows = 0;    ///< d
  bool is_natural = false;          ///< points have the user's order
  std::vector<OneSidedRow> one_sided{};
  std::vector<char> may_open{};  ///< [inner row] is one-sided; empty if none is

  std::size_t num_points() const { return user_point.size(); }
  std::size_t num_rows() const { return user_row.size(); }
  std::size_t first_idle_row() const { return static_cast<std::size_t>(island_start.back()); }
  std::size_t num_islands() const { return island_start.size() - 1; }
  /// Returns the island of a row, or num_islands() for idle rows.
  std::size_t island_of(Index inner_row) const {
    return static_cast<std::size_t>(std::ranges::upper_bound(island_start, inner_row) - island_start.begin()) - 1;
  }
  bool is_contact_row(std::size_t inner_row) const {
    return static_cast<std::size_t>(user_row[inner_row]) >= num_user_rows;
  }
  bool has_contact_rows() const { return num_rows() > num_user_rows; }
  /// Returns true if the row has a gradient at some times alone: where a contact sticks, or a one-sided row is closed.
  bool comes_and_goes(std::size_t inner_row) const {
    return is_contact_row(inner_row) || (!may_open.empty() && may_open[inner_row] != 0);
  }
  bool has_rows_that_go() const { return has_contact_rows() || !one_sided.empty(); }

  /// Copy three numbers a point from the user's order to the inner one, and back.
  void gather_points(std::span<const double> user, std::span<double> inner, const Parallel& by = Parallel(1)) const;
  void scatter_points(std::span<const double> inner, std::span<double> user, const Parallel& by = Parallel(1)) const;
  /// Does the same for rows; those of contacts are not the user's and are left out.
  void scatter_rows(std::span<const double> inner, std::span<double> user, const Parallel& by = Parallel(1)) const;

 private:
  template <class Number, class Visit>
  void visit_points(Number* user, std::size_t begin, std::size_t end, const Visit& visit) const;
};

/// The places of points: positions [3n] in the user's order, and [inner point] -> user's point. Both are empty if they
/// are not known.
struct PointPlaces {
  std::span<const double> positions;
  std::span<const Index> user_point;
};

Numbering number(const System& system);

}  // namespace tanor::detail
