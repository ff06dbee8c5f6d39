#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <tanor/system.hpp>

#include "base/block3.hpp"
#include "base/parallel.hpp"
#include "base/point_path.hpp"
#include "evaluate/neighbours.hpp"
#include "evaluate/pair_potential.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// Squares of the largest and the least distance of a pair that one step may lead over.
inline constexpr double far_apart2 = 1.25;

/// Pair forces of one group, in the inner order.
///
/// Each point gathers the forces of all its partners, in the order of their numbers. Every pair is evaluated from both
/// sides, and any number of threads gives the same bits. Forces and energies are kept until the positions change; they
/// are a function of these positions alone.
class PairField {
 public:
  /// The field has every pair in which a point moves, or those of two supports, which matter to nothing but the load
  /// that each support carries. Supports that start at the same place are no pair, because their force would have no
  /// direction.
  enum class Which { WithMovingPoints, OfSupports };
  PairField(const System& system, const PairForces& pairs, const Numbering& numbering,
            Which which = Which::WithMovingPoints);
  bool empty() const { return points_.empty(); }

  void add_forces(const Parallel& parallel, const double* r, double* f);
  double potential(const Parallel& parallel, const double* r);
  /// Returns the power that supports put in by their velocities, W.
  double power_of_supports(const Parallel& parallel, const double* r, const double* v);

  /// Returns true if stiffness is known here. EnergyForces knows it for few points with a smooth law; for too many
  /// points it is not known at all.
  bool gives_stiffness() const { return gives_stiffness_; }
  /// Calls visit(i, j, B) once for each pair that interacts at r, in a fixed order. i and j are inner numbers, and at
  /// least one of the points moves. B is the derivative of the force on j in r_j, N/m. With the unit vector n along
  /// r_j - r_i and the energy u(r),
  ///
  ///   B = (-u'/r) (I - nn') - u'' nn'
  using VisitStiffness = std::function<void(Index, Index, const Block3&)>;
  void for_each_stiffness(const Parallel& parallel, const double* r, const VisitStiffness& visit);

  /// Calls visit(shift, force) once for each pair at r that interacts through the faces of the box: the shift of the
  /// second point to its image, m, and the force on it, N.
  using VisitImage = std::function<void(Vec3 shift, Vec3 force)>;
  void for_each_image(const Parallel& parallel, const double* r, const VisitImage& visit);

  /// Returns the part of a step to make instead if a pair comes so near between two looks that these do not show it, or
  /// 1 if none does. `masses` [moving point, or all], kg, are those of what is pushed. See unseen_pairs.cpp.
  double find_unseen(const Parallel& parallel, const PointPath& path, std::span<const double> masses);
  /// Returns true if the force does not vanish at the cutoff.
  bool may_jump() const { return potential_.jumps(); }
  /// Notes in the path where a pair first comes to its cutoff. See pair_jumps.cpp.
  void note_jumps(const Parallel& parallel, PointPath* path, std::span<const double> masses);

  std::string name;  ///< of the force in messages

  /// Two inner points that fall onto each other.
  struct Collision {
    Index i, j;
    double distance;  // m
  };
  /// Returns the nearest pair that meets within so many seconds by its velocities, if the law attracts without bound
  /// there.
  std::optional<Collision> find_collision(const double* r, const double* v, double within) const;

 private:
  /// The force on one point, and its share of energy.
  struct PointForce {
    Vec3 force;              // N
    double potential = 0.0;  // J, half of that of its pairs
  };

  // The following is for `find_unseen`, in unseen_pairs.cpp.

  /// How far points go in a step: from where they begin, and from the chords of its pieces.
  struct Reach {
    double move, sagitta;  // m
  };
  /// Points i and j on their way, j seen at `shift` from where it is (an image).
  struct Approach {
    std::size_t i, j;
    Vec3 shift;
  };
  /// The instant at which two points are nearest to each other.
  struct Encounter {
    double r = std::numeric_limits<double>::infinity(), s = 0.0;  // m, and the fraction of the step
    double speed = 0.0;                                           // m/s there
  };
  class Nearness;
  class Crossing;
  Reach measure_reach(const Parallel& parallel, const PointPath& path);
  const NeighbourLists* find_near(const Parallel& parallel, double move);
  bool are_too_many(double radius) const;
  using VisitApproach = std::function<void(const Approach&)>;
  void for_each_image(std::size_t i, std::size_t j, double far, const VisitApproach& visit) const;
  double examine(const PointPath& path, const Approach& approach, std::span<const double> masses) const;
  double resolve_meeting(const PointPath& path, const Approach& approach, const Encounter& nearest_of_all,
                         std::span<const double> masses) const;
  Encounter find_nearest(const PointPath& path, const Approach& approach, double a, double b) const;
  void narrow(const PointPath& path, const Approach& approach, double a, double b, int depth, Encounter* nearest) const;
  PointPath::Place relative(const PointPath& path, const Approach& approach, double s) const;
  double measure(const PointPath& path, const Approach& approach, double impulse, std::span<const double> masses) const;
  Vec3 force_along(const PointPath& path, const Approach& approach, double s) const;
  double resolve_kinks(const PointPath& path, const Approach& approach, const Encounter& nearest,
                       std::span<const double> masses) const;

  void follow(const Parallel& parallel, const double* r);
  PointForce force_within_cutoff(std::size_t i, std::span<const Index> neighbours) const;
  PointForce force_without_cutoff(std::size_t i) const;
  PointForce logarithmic_force(std::size_t i) const;
  template <class Visit>
  void for_each_range_of_others(std::size_t i, const Visit& visit) const;
  template <class Visit>
  void for_each_pair(const Visit& visit) const;
  // The constructor takes these steps in turn.
  std::vector<Index> number_points(const PairForces& pairs, const Numbering& numbering, Which which);
  void read_charges(const PairForces& pairs, const Numbering& numbering);
  using Pairs = std::vector<std::array<Index, 2>>;
  void exclude_rods(const System& system, const Numbering& numbering, const std::vector<Index>& number_of,
                    Pairs* excluded) const;
  void exclude_same_place(const System& system, const Numbering& numbering, const std::vector<Index>& number_of,
                          const Vector3& box, Pairs* excluded) const;
  void prepare_search(double sigma, Pairs excluded);

  void note_jump(PointPath* path, const Crossing& crossing, std::span<const double> masses) const;

  std::vector<Index> points_;   // inner ones, those that move first; numbered from 0 on in what follows
  std::size_t num_moving_ = 0;  // the others interact with these alone; for supports, all
  PairPotential potential_;
  std::vector<double> charges_;  // [point], of law coulomb
  PeriodicBox box_;
  std::optional<NeighbourLists> neighbours_;  // for laws with a cutoff
  Groups<Index> skipped_;                     // without one: the point itself and excluded ones, by number

  bool is_known_ = false, gives_stiffness_;
  std::vector<Vec3> places_;              // [point] of the last evaluation
  std::vector<double> x_, y_, z_;         // the same, without a cutoff
  std::vector<PointForce> point_forces_;  // [point]

  // These serve `find_unseen`.
  std::optional<NeighbourLists> far_;  // for steps that lead beyond the skin of `neighbours_`
  std::vector<Vec3> begins_, moves_;   // [point] where a step begins, and how far it leads
  /// No pair of a point comes to its cutoff before the points have travelled far enough.
  struct {
    std::vector<double> until;  // [point] m
    double travelled = 0.0;     // m, since the beginning
    bool is_of_far = false;     // known for the pairs of `far_`, else of `neighbours_` …
    std::size_t version = 0;    // … in lists of this version
  } quiet_;
};

}  // namespace tanor::detail
