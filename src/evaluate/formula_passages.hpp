#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include <tanor/kernel.hpp>
#include <tanor/system.hpp>

#include "base/parallel.hpp"
#include "base/point_path.hpp"
#include "evaluate/narrowness.hpp"

namespace tanor {

inline double norm_of(std::span<const double> x) {
  double square = 0.0;
  for (const double number : x) square += number * number;
  return std::sqrt(square);
}

/// What one formula does to its members while a step passes: a well, a bump or a window that is narrow beside the step
/// may lie between the looks of its scheme. A member is a point with a force, points that a constraint joins, or points
/// with coordinates of their own.
///
/// Intervals that hold the path tell how often the formula may change its course on the way (`Narrowness`). A few times
/// is what every scheme resolves, or its error estimate sees that it does not. Where it may be more, the path is halved
/// until it is a few times in each part, the formula is evaluated in all of them, and what is found is compared with a
/// polynomial over the whole step, which is how a scheme sees it.
///
/// Most members stay for many steps where their formula is smooth. A box around the path in which it is hardly changes
/// its course is remembered, and asked about again where the path leaves the box. What is found does not depend on it.
class FormulaPassages {
 public:
  virtual ~FormulaPassages() = default;

  /// False: sums and products alone.
  bool is_needed() const { return narrowness_.is_possible() && num_members() > 0; }
  /// The part of the step to make instead; 1: nothing is hidden in it.
  double find(const Parallel& parallel, PointPath* path);

 protected:
  /// Which numbers of a path the variables of the formula are; then come what each member has a constant of its own
  /// for, and the time.
  enum class Variables { OfPoints, OfPointsAndTheirRates, OfMechanics };
  FormulaPassages(const Expression& expression, Variables variables, bool thread_safe, std::size_t num_constants = 0);

  struct Allowed {
    double r, v;  // m, m/s: what a member may miss
  };
  virtual Allowed allow(const PointPath& path, std::size_t member) const = 0;
  /// Accelerations jump where the formula has its kinks. Fixed steps then miss something each time they pass one, so
  /// that a warning is due from a tenth of the error on that is worth one elsewhere.
  virtual bool has_jumps() const { return false; }
  /// Accelerations that the formula causes, m/s^2: so many numbers of a member, at the fraction s of the step. What
  /// the step misses of them, it misses of the motion.
  virtual std::size_t num_accelerations() const = 0;
  virtual void accelerate(const PointPath& path, std::size_t member, double s, double* a) const = 0;

  /// What points may miss of the path's tolerances: the least of some points.
  static Allowed allow(const PointPath& path, std::span<const Index> points);

  std::size_t num_numbers() const { return num_numbers_; }
  std::size_t num_members() const { return num_numbers_ > 0 ? numbers_.size() / num_numbers_ : 0; }
  /// Places in the arrays of a path.
  std::span<const Index> numbers(std::size_t member) const {
    return std::span(numbers_).subspan(member * num_numbers_, num_numbers_);
  }
  void append_number(Index number) { numbers_.push_back(number); }
  void append_constants(std::span<const double> constants) {
    constants_.insert(constants_.end(), constants.begin(), constants.end());
  }
  void append_points(std::span<const Index> points) {
    for (const Index point : points)
      for (Index c = 0; c < 3; ++c) append_number(3 * point + c);
  }
  std::span<const double> constants(std::size_t member) const {
    return std::span(constants_).subspan(member * num_constants_, num_constants_);
  }
  const Narrowness& formula() const { return narrowness_; }

 private:
  /// A part of a step in which the formula changes its course a few times at most, or that is as short as parts may be.
  struct Part {
    double begin, end;  // fractions of the step
  };
  using Counts = std::array<double, num_lanes>;
  bool is_doubtful(const PointPath& path, std::size_t member) const;
  void enclose(const PointPath& path, std::size_t group, std::size_t piece, Intervals* to) const;
  Counts count_along(const PointPath& path, std::size_t group);
  Counts count_parts(const PointPath& path, std::size_t member, double begin, double end) const;
  double divide(const PointPath& path, std::size_t member, double begin, double end, int depth,
                std::vector<Part>* parts) const;
  struct Integrals;
  double examine(const PointPath& path, std::size_t member) const;
  double integrate(const PointPath& path, std::size_t member, std::span<const Part> parts, const Allowed& allowed,
                   Integrals* sums) const;
  void subtract_looks(const PointPath& path, std::size_t member, Integrals* sums) const;

  Narrowness narrowness_;
  Variables variables_;
  std::size_t num_constants_, num_numbers_;
  bool thread_safe_, asks_for_rates_ = false;
  std::vector<Index> numbers_;     // [member][number]
  std::vector<double> constants_;  // [member][constant]
  std::vector<char> is_doubtful_;  // [member]
  // Of each group of eight members: where counts were taken, and how far beyond the path.
  struct Box {
    Counts counts{};
    double margin = 8.0;  // over the extent of the path; 0: none is remembered
    bool is_known = false;
  };
  std::vector<Box> boxes_;
  std::vector<Intervals> sides_;  // [group][variable]
};

/// Of forces on the p points of tuples, [member][p]. `masses` [moving point], kg, outlives it.
std::unique_ptr<FormulaPassages> make_force_passages(const ForceKernel& kernel, std::span<const Index> inner_points,
                                                     std::span<const double> masses);
enum class Course { Continuous, Jumps };
/// Of energies of p points, with each tuple's own constants.
std::unique_ptr<FormulaPassages> make_energy_passages(const PotentialKernel& kernel,
                                                      std::span<const Index> inner_points,
                                                      std::span<const double> constants, std::span<const double> masses,
                                                      Course course = Course::Continuous);
/// Of constraints, K'w = -phi: members of p points. Null: nothing is narrow, or nothing is known.
std::unique_ptr<FormulaPassages> make_constraint_passages(const ConstraintKernel& kernel,
                                                          std::span<const Index> inner_points);
/// Of coordinates, members side by side from `first_coordinate` on.
std::unique_ptr<FormulaPassages> make_coordinate_passages(const CoordinateKernel& kernel,
                                                          std::span<const Index> inner_points, Index first_coordinate);

}  // namespace tanor
