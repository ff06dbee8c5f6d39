#pragma once

#include <memory>
#include <string>
#include <vector>

#include "evaluate/coordinate_family.hpp"
#include "evaluate/formula_passages.hpp"

namespace tanor {

class UserCoordinateFamily;

/// r = r(q, t) of all points that move, one family a kind. Coordinates are numbered family by family; a member's own
/// coordinates are an island of A'WA, since no other member moves its points.
class Parametrisation {
 public:
  /// `t`: where "initial" values and charts stand at first. Empty where the system has no coordinates.
  Parametrisation(const System& system, const Numbering& numbering, double t);

  bool empty() const { return families_.empty(); }
  std::size_t num_coordinates() const { return num_coordinates_; }
  std::size_t num_blocks() const { return num_blocks_; }
  bool depends_on_time() const;
  bool has_charts() const;
  void set_time(double t);

  // Arrays over points are 3n in the inner order; what stands at supports is given, or left alone.

  /// r; v = A q_dot + r_t and psi unless null; A's blocks unless null.
  void evaluate(const Parallel& parallel, const double* q, const double* q_dot, double* r, double* v, double* psi,
                double* blocks) const;
  /// Whether all families move single points.
  bool has_closed_form() const;
  /// There: q_ddot and w, as PointFamily::accelerate.
  double accelerate(const Parallel& parallel, const double* q, const double* q_dot, const double* w0,
                    const Vec3* uniform, double* q_ddot, double* w) const;
  /// y = A x at points that move
  void apply(const Parallel& parallel, const double* blocks, const double* x, double* y) const;
  /// x = A'y
  void apply_transposed(const Parallel& parallel, const double* blocks, const double* y, double* x) const;

  /// Adds to the rows of supports that hold coordinates what these do there; eta at the points is given [3n].
  void add_support_reactions(double* eta) const;

  /// The products of A'WA, island by island; `weights` [point].
  std::vector<Product> list_products(const std::vector<double>& weights) const;
  /// First coordinate of each member, then s.
  const std::vector<Index>& island_start() const { return island_start_; }

  /// Numbers of coordinates, [s] from this order into the user's: entry by entry, member by member.
  void scatter(const double* inner, double* users) const;
  /// And back.
  void gather(const double* users, double* inner) const;
  /// Whose an inner coordinate is: "wire[3]", the number counting the entry's own.
  std::string name_coordinate(const System& system, std::size_t inner) const;

  /// q of the places r, in charts centred there; where several q say the same: near the given one.
  void locate(const double* r, double* q);
  /// Where the user gave q and q_dot.
  void write_start(double* q, double* q_dot) const;
  /// to := from at the points of such coordinates [3n].
  void copy_where_given(const double* from, double* to) const;
  /// Looks for what a step may pass over in coordinates that are given by formulas.
  std::vector<std::unique_ptr<FormulaPassages>> list_passages() const;

  /// Charts centred at q; the motion goes along.
  void recentre(double t, double* q, double* q_dot, double* q_ddot);
  /// Where charts are centred.
  void exchange_memory(Memory& memory) {
    for (const auto& family : families_) family->exchange_memory(memory);
  }

 private:
  class Builder;
  /// Coordinates of one entry of the user's list: side by side, since a family keeps the order of its members.
  struct Entry {
    const CoordinateFamily* family;
    Index first, count;  // first: of the family's
  };

  std::vector<std::unique_ptr<CoordinateFamily>> families_;
  std::vector<const PointFamily*> points_;          // those of families_ that move single points
  std::vector<const UserCoordinateFamily*> users_;  // and a user's own
  std::vector<Entry> entries_;
  std::size_t num_coordinates_ = 0, num_blocks_ = 0;
  std::vector<Index> island_start_{0};
};

}  // namespace tanor
