#pragma once

#include <memory>
#include <string>
#include <vector>

#include "evaluate/coordinate_family.hpp"
#include "evaluate/formula_features.hpp"

namespace tanor::detail {

class UserCoordinateFamily;

/// The map r = r(q, t) of all points that move, with one family for each kind. Coordinates are numbered family by
/// family. A member's own coordinates are an island of A'WA, since no other member moves its points.
class Parametrisation {
 public:
  /// `t` is the instant of "initial" values and of the first charts. The object is empty if the system has no
  /// coordinates.
  Parametrisation(const System& system, const Numbering& numbering, double t);

  bool empty() const { return families_.empty(); }
  std::size_t num_coordinates() const { return num_coordinates_; }
  std::size_t num_blocks() const { return num_blocks_; }
  bool depends_on_time() const;
  bool has_charts() const;
  void set_time(double t);

  // Arrays over points are 3n in the inner order. What stands at supports is input, or left alone.

  /// Evaluates r, and v = A q_dot + r_t, psi and the blocks of A unless these are null.
  void evaluate(const Parallel& parallel, const double* q, const double* q_dot, double* r, double* v, double* psi,
                double* blocks) const;
  /// Returns true if all families move single points, so that `accelerate` may be called.
  bool has_closed_form() const;
  /// Computes q_ddot and w as PointFamily::accelerate does.
  double accelerate(const Parallel& parallel, const double* q, const double* q_dot, const double* w0,
                    const Vec3* uniform, double* q_ddot, double* w) const;
  /// Computes y = A x at points that move.
  void apply(const Parallel& parallel, const double* blocks, const double* x, double* y) const;
  /// Computes x = A'y.
  void apply_transposed(const Parallel& parallel, const double* blocks, const double* y, double* x) const;

  /// Adds the reactions of coordinates to the rows of the supports that hold them; eta at the points is given [3n].
  void add_support_reactions(double* eta) const;

  /// Returns the products of A'WA, island by island; `weights` [point].
  std::vector<Product> list_products(const std::vector<double>& weights) const;
  /// Returns the first coordinate of each member, then s.
  const std::vector<Index>& island_start() const { return island_start_; }

  /// Copies numbers of coordinates [s] from this order into the user's: entry by entry, member by member.
  void scatter(const double* inner, double* users) const;
  /// Copies them back.
  void gather(const double* users, double* inner) const;
  /// Names the entry of an inner coordinate, as in "wire[3]", where the number counts the entry's own coordinates.
  std::string name_coordinate(const System& system, std::size_t inner) const;

  /// Finds q of the positions r, in charts centred there. If several q give the same r, finds one near the given q.
  void locate(const double* r, double* q);
  /// Writes the start where the user gave q and q_dot.
  void write_start(double* q, double* q_dot) const;
  /// Copies `from` to `to` at the points of such coordinates [3n].
  void copy_where_given(const double* from, double* to) const;
  /// Returns the features that look for what a step may pass over in coordinates given by formulas.
  std::vector<std::unique_ptr<FormulaFeatures>> list_features() const;

  /// Centres charts at q and converts the motion to them.
  void recentre(double t, double* q, double* q_dot, double* q_ddot);
  /// Saves or restores where charts are centred.
  void exchange_memory(Memory& memory) {
    for (const auto& family : families_) family->exchange_memory(memory);
  }

 private:
  class Builder;
  /// Coordinates of one entry of the user's list. They lie side by side, since a family keeps the order of its members.
  struct Entry {
    const CoordinateFamily* family;
    Index first, count;  // `first` counts the family's coordinates
  };

  std::vector<std::unique_ptr<CoordinateFamily>> families_;
  std::vector<const PointFamily*> points_;          // those of families_ that move single points
  std::vector<const UserCoordinateFamily*> users_;  // those of a user's own coordinates
  std::vector<Entry> entries_;
  std::size_t num_coordinates_ = 0, num_blocks_ = 0;
  std::vector<Index> island_start_{0};
};

}  // namespace tanor::detail
