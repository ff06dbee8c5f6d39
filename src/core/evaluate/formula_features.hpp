#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tanor/kernel.hpp>
#include <tanor/system.hpp>

#include "base/numbers.hpp"
#include "base/parallel.hpp"
#include "base/point_path.hpp"
#include "evaluate/narrowness.hpp"

namespace tanor::detail {

inline double norm_of(std::span<const double> x) {
  double square = 0.0;
  for (const double number : x) square += number * number;
  return std::sqrt(square);
}

/// Looks along a step for what one formula hides from its scheme: a well, a bump or a window that is narrow beside the
/// step may lie between the looks. A member is a point with a force, points that a constraint joins, or points with
/// coordinates of their own.
///
/// Intervals that hold the path tell how often the formula may change its course on the way (`Narrowness`). Every
/// scheme resolves a few changes, or its error estimate sees that it does not. If there may be more, the path is
/// divided until each part has a few, the formula is evaluated in all of them, and the result is compared with a
/// polynomial over the whole step, which is how a scheme sees it.
///
/// Most members stay for many steps where their formula is smooth. A box around the path in which the formula hardly
/// changes its course is remembered, and checked again if the path leaves it. The result does not depend on the box.
class FormulaFeatures {
 public:
  virtual ~FormulaFeatures() = default;

  /// Returns false if the formula has sums and products alone, or there are no members.
  bool is_needed() const { return narrowness_.is_possible() && num_members() > 0; }
  /// Returns the part of the step to make instead, or 1 if nothing is hidden in it.
  double find(const Parallel& parallel, PointPath* path);
  /// Returns true if what the formula causes may jump.
  bool may_jump() const { return is_force() && narrowness_.num_turns() > 0; }

  std::string name;  ///< of the force in messages

 protected:
  /// The numbers of a path that the variables of the formula are. Constants that each member has of its own and the
  /// time come after them.
  enum class Variables { OfPoints, OfPointsAndTheirRates, OfMechanics };
  /// The members of the formula, side by side.
  struct Members {
    std::span<const Index> points;
    std::size_t points_per_member;
    std::span<const double> constants = {};
    Index first_variable = 0;  ///< of the mechanics; the variables of all members lie side by side as well
    std::size_t num_moving = std::numeric_limits<std::size_t>::max();  ///< points from there on may miss anything
  };
  FormulaFeatures(const Expression& expression, Variables variables, bool thread_safe, const Members& members);

  /// Returns true if steps end where the formula jumps, since it is a force.
  virtual bool is_force() const { return false; }
  /// Returns true if accelerations jump where the formula has its kinks. Fixed steps then miss something each time they
  /// pass one, so a warning is due from a tenth of the error that is worth one elsewhere.
  virtual bool has_jumps() const { return false; }
  /// Returns how many numbers of acceleration the formula causes for a member. `accelerate` writes them, m/s^2, at the
  /// fraction s of the step. What the step misses of them, it misses of the motion.
  virtual std::size_t num_accelerations() const = 0;
  virtual void accelerate(const PointPath& path, std::size_t member, double s, double* a) const = 0;

  std::size_t num_numbers() const { return num_numbers_; }
  std::size_t num_members() const { return points_.size() / points_per_member_; }
  std::span<const Index> points(std::size_t member) const {
    return std::span(points_).subspan(member * points_per_member_, points_per_member_);
  }
  /// Returns a member's indices in the arrays of a path.
  std::span<const Index> numbers(std::size_t member) const {
    return std::span(numbers_).subspan(member * num_numbers_, num_numbers_);
  }
  std::span<const double> constants(std::size_t member) const {
    return std::span(constants_).subspan(member * num_constants_, num_constants_);
  }
  bool moves(Index point) const { return static_cast<std::size_t>(point) < num_moving_; }
  /// Returns the largest acceleration that may act on the points of a member.
  double largest_acceleration(const PointPath& path, std::size_t member) const;
  const Narrowness& formula() const { return narrowness_; }
  /// Writes the variables of the formula at the fraction s of a path.
  void load_variables(const PointPath& path, std::size_t member, double s, double* to) const;
  /// Writes the positions and velocities of a member's points there, or no velocities if `v` is null.
  void load_points(const PointPath& path, std::size_t member, double s, double* r, double* v) const;

 private:
  /// A part of a step in which the formula changes its course a few times at most, or that is as short as parts may be.
  struct Part {
    double begin, end;  // fractions of the step
  };
  using Counts = std::array<double, num_lanes>;
  struct Allowed {
    double r, v;  // m, m/s: what a member may miss
  };
  Allowed allow(const PointPath& path, std::size_t member) const;
  void enclose(const PointPath& path, std::size_t group, std::size_t piece, Intervals* to) const;
  Counts count_along(const PointPath& path, std::size_t group);
  Counts count_parts(const PointPath& path, std::size_t member, double begin, double end) const;
  double divide(const PointPath& path, std::size_t member, double begin, double end, int depth,
                std::vector<Part>* parts) const;
  double divide(const PointPath& path, std::size_t member, int depth, std::vector<Part>* parts) const;
  double divide(const PointPath& path, std::size_t member, std::vector<Part>* parts) const;
  void measure_turns(const PointPath& path, std::size_t member, double s, double* values) const;
  double uncertainty(const PointPath& path, std::size_t member, std::size_t turn, double s) const;
  bool jumps(PointPath* path, std::size_t member, PointPath::Jump* at) const;
  PointPath::Jump find_jump(PointPath* path, std::size_t member, double low, double high) const;
  void note_jumps(PointPath* path, std::size_t member) const;
  struct Integrals;
  double examine(const PointPath& path, std::size_t member) const;
  double integrate(const PointPath& path, std::size_t member, std::span<const Part> parts, const Allowed& allowed,
                   Integrals* sums) const;
  void subtract_looks(const PointPath& path, std::size_t member, Integrals* sums) const;

  Narrowness narrowness_;
  Variables variables_;
  bool thread_safe_, asks_for_rates_ = false;
  std::vector<Index> points_, numbers_;  // [member][point], [member][number]
  std::vector<double> constants_;        // [member][constant]
  std::size_t points_per_member_, num_constants_, num_numbers_, num_moving_;
  std::vector<char> is_doubtful_;  // [member]
  // Each group of eight members has the counts in a box, and how far it extends beyond the path.
  struct Box {
    Counts counts{};
    double margin = 8.0;  // over the extent of the path; 0: none is remembered
    bool is_known = false;
  };
  std::vector<Box> boxes_;
  std::vector<Intervals> sides_;  // [group][variable]
};

/// Makes the features of forces on the p points of tuples, [member][p]; null if nothing is narrow, or if the kernel has
/// no expression. `masses` [moving point], kg, must outlive them.
std::unique_ptr<FormulaFeatures> make_force_features(const ForceKernel& kernel, std::span<const Index> inner_points,
                                                     std::span<const double> masses);
enum class Course { Continuous, Jumps };
/// Makes the features of energies of p points, with each tuple's own constants, or null as above.
std::unique_ptr<FormulaFeatures> make_energy_features(const PotentialKernel& kernel,
                                                      std::span<const Index> inner_points,
                                                      std::span<const double> constants, std::span<const double> masses,
                                                      Course course = Course::Continuous);
/// Makes the features of constraints, K'w = -phi, whose members have p points, or null as above.
std::unique_ptr<FormulaFeatures> make_constraint_features(const ConstraintKernel& kernel,
                                                          std::span<const Index> inner_points);
/// Makes the features of coordinates, with members side by side from `first_coordinate` on, or null as above.
std::unique_ptr<FormulaFeatures> make_coordinate_features(const CoordinateKernel& kernel,
                                                          std::span<const Index> inner_points, Index first_coordinate);

}  // namespace tanor::detail
