#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tanor/motion.hpp>
#include <tanor/system.hpp>

namespace tanor::report {

/// A rope that may be slack.
struct RopeShape {
  std::size_t group, member;         ///< among the constraints
  std::vector<double> coefficients;  ///< of its segments
};

/// The part of a system that a trajectory shows: some points, and the rods between them.
struct ShownParts {
  std::size_t num_points = 0;    ///< number of shown points, m
  std::vector<Index> points;     ///< m, points of the system, in the order of the files
  std::vector<bool> is_support;  ///< m
  /// An entry of supports, and the number of a point in it.
  struct Member {
    std::string name, entry;  ///< "hook", "supports/0"
    std::size_t number;
  };
  std::map<std::size_t, Member> support_names;    ///< by the position of each support
  std::vector<std::array<std::int32_t, 2>> rods;  ///< both ends, as positions in `points` followed by `images`
  std::vector<std::size_t> rod_rows;              ///< row of each rod among the multipliers

  /// A group of rods some of which are shown.
  struct RodGroup {
    std::string name;
    std::size_t first;                 ///< number of its first rod in `rods`
    std::vector<std::size_t> members;  ///< number of each shown rod in the group; empty if all are shown
    std::size_t number;                ///< of the group among the constraints
  };
  std::vector<RodGroup> rod_groups;
  std::vector<std::int32_t> loose_points;  ///< positions in `points` that no shown rod touches

  /// The end r_j + offset of a rod across the edge of a periodic sample. The rod is drawn beside its point i, not
  /// across the sample.
  struct Image {
    std::int32_t point;  ///< position of j in `points`
    Vector3 offset;      ///< m
  };
  std::vector<Image> images;

  /// A rope over sheaves, a formula of several points, a spring or a bond, which is drawn from point to point.
  struct Tie {
    std::string kind, name, place;     ///< of its constraint or force, such as "rope[0]" and "constraints/2/0"
    std::vector<std::int32_t> points;  ///< positions in `points`
    std::vector<Vector3> sheaves;      ///< m, which it passes after its first point
    std::size_t row;                   ///< among the multipliers; beyond them for a force
    std::optional<RopeShape> rope{};   ///< of a rope that may be slack
  };
  std::vector<Tie> ties;          ///< the first 2000, those of forces last
  std::size_t ties_left_out = 0;  ///< number of the others
  Units units{};                  ///< of the system

  /// Returns the points of the system at both ends of each rod; an image stands for its point. Modules need it, which
  /// hold nothing else of these sources.
  std::vector<std::array<Index, 2>> rod_points() const {
    const auto point = [this](std::int32_t end) {
      const auto beyond = static_cast<std::size_t>(end) - num_points;  // number of an image
      return points[static_cast<std::size_t>(end) < num_points ? end : images[beyond].point];
    };
    std::vector<std::array<Index, 2>> ends;
    for (const auto& [i, j] : rods) ends.push_back({point(i), point(j)});
    return ends;
  }
  /// Calls use(group, number in it) for each rod.
  template <class Use>
  void for_each_rod(const Use& use) const {
    for (std::size_t g = 0; g < rod_groups.size(); ++g) {
      const RodGroup& group = rod_groups[g];
      const std::size_t end = g + 1 < rod_groups.size() ? rod_groups[g + 1].first : rods.size();
      for (std::size_t k = 0; k < end - group.first; ++k) use(group, group.members.empty() ? k : group.members[k]);
    }
  }
  /// Returns the name of each rod, "links[3]".
  std::vector<std::string> rod_names() const {
    std::vector<std::string> names;
    for_each_rod(
        [&](const auto& group, std::size_t k) { names.push_back(group.name + "[" + std::to_string(k) + "]"); });
    return names;
  }
};

/// Returns the place of a group of constraints in its system, as passages have it.
inline std::string place_of_constraint(std::size_t group) {
  return "constraints/" + std::to_string(group);
}

/// Since when what passages of events took out holds no longer, s, by its place in the system.
class GoneTimes {
 public:
  explicit GoneTimes(std::span<const Passage> passages);
  /// Returns NaN for what holds.
  double of(const std::string& place) const;
  double of(const std::string& entry, std::size_t member) const {
    return is_empty() ? of("") : of(entry + "/" + std::to_string(member));
  }
  bool is_empty() const { return times_.empty(); }

 private:
  std::map<std::string, double> times_;
};

/// Since when each shown rod and support holds no longer, s; NaN where it holds.
struct GoneParts {
  std::vector<double> rods, supports;  ///< [R], [m]
};
/// Finds what passages of events took out. All lists are empty where they took nothing.
GoneParts find_gone(const ShownParts& shown, std::span<const Passage> passages);

/// Chooses what is shown. `chosen` names the points in their order; if it is empty, all points are shown.
ShownParts choose_parts(const System& system, std::span<const Index> chosen);

/// Copies the rows of the shown points. `all` has 3n numbers; the result has 3m and reuses `rows`.
void gather_points(const ShownParts& shown, std::span<const double> all, std::vector<double>* rows);

/// Returns the tensions of the shown rods, N: -lambda. `multipliers` are those of all constraints (d); a rod beyond
/// their end has NaN.
std::vector<double> find_tensions(const ShownParts& shown, std::span<const double> multipliers);

/// Returns multipliers with NaN in place of those that are not unique, by the self-stress of Solution.
std::vector<double> unique_multipliers(std::span<const double> multipliers, std::span<const double> self_stress);
/// Returns the tensions of the ties, N, likewise: -lambda, which a pulley has at its first point.
std::vector<double> find_tie_tensions(const ShownParts& shown, std::span<const double> multipliers);

/// Returns the rows of the images from those of the shown points (3m).
std::vector<double> gather_images(const ShownParts& shown, std::span<const double> rows);
/// Returns the same for positions, with the images shifted.
std::vector<double> gather_shifted_images(const ShownParts& shown, std::span<const double> positions);

/// Returns the diagonal of the box around points [3n], m; 0 if there are none.
double measure_diagonal(std::span<const double> positions);

/// Returns the gravity of a system, m/s^2; 0 if it has none.
Vector3 find_gravity(const System& system);

/// Returns the forces of guides and supports on the shown points, 3m, N: K lambda without the pull of the rods, and at
/// a support the force that holds it. `positions` and `tensions` (N) are those of the shown points and rods;
/// `reactions` and `support_forces` are those of all points (3n).
std::vector<double> find_guide_forces(const ShownParts& shown, std::span<const double> positions,
                                      std::span<const double> tensions, std::span<const double> reactions,
                                      std::span<const double> support_forces);

}  // namespace tanor::report
