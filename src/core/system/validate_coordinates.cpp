#include "system/validate_coordinates.hpp"

#include <algorithm>
#include <string>
#include <unordered_map>
#include <vector>

#include "system/field_checks.hpp"

namespace tanor::detail {

namespace {

[[noreturn]] void fail_point(Index point, std::size_t k, const std::string& where, const std::string& problem) {
  throw InputError(element(where + "/points", k), "point " + text(point) + ": " + problem);
}

/// One walk over the entries, in the order of the scene file.
class CoordinateValidation {
 public:
  CoordinateValidation(const System& system, std::span<const std::size_t> support_of_point, double t)
      : system_(system), support_of_point_(support_of_point), t_(t), owner_of_point_(system.num_points(), none) {}

  void run() {
    for (entry_ = 0; entry_ < system_.coordinates.size(); ++entry_) {
      std::visit([&](const auto& group) { check(group, entry_pointer(entry_)); }, system_.coordinates[entry_]);
    }
    check_cover();
    check_names();
  }

 private:
  // ---- kinds ----

  template <class Group>
  void check(const Group& group, const std::string& where) {
    cover(group.points, where);
    check_fields(group, t_, where);
    check_start(system_, group, t_,
                [&](std::size_t k, const std::string& problem) { fail_point(group.points[k], k, where, problem); });
  }

  void check(const ChainAngles& chain, const std::string& where) {
    check_range(chain.anchor, where + "/anchor");
    if (support_of_point_[static_cast<std::size_t>(chain.anchor)] == no_support) {
      throw InputError(where + "/anchor",
                       "point " + text(chain.anchor) + " is not a support; a chain's anchor is one, fixed or moving");
    }
    cover(chain.points, where);
    check_fields(chain, t_, where);
    const bool is_zero = chain.normal == Vector3{};
    if (const char* complaint = is_zero ? nullptr : zero_complaint(chain.normal)) {
      throw InputError(where + "/normal", "normal " + text(chain.normal) + complaint);
    }
    Index before = chain.anchor;
    for (std::size_t k = 0; k < chain.points.size(); ++k) {
      const Index point = chain.points[k];
      if (!(norm(position(point) - position(before)) > 0.0)) {
        fail_point(point, k, where, "it is where point " + text(before) + " is; a link has a direction");
      }
      before = point;
    }
  }

  void check(const RigidBody& body, const std::string& where) {
    cover(body.points, where);
    if (body.points.size() < 3) {
      throw InputError(where + "/points", text_of_count(body.points.size(), "point") +
                                              "; a rigid body has at least 3 that are not on one line");
    }
    // Finds the point farthest from the first one, and the farthest from the line through both.
    const Vec3 first = position(body.points[0]);
    Vec3 along{};
    Index farthest = body.points.back();
    double size = norm(first);
    for (const Index point : body.points) {
      const Vec3 arm = position(point) - first;
      if (norm(arm) > norm(along)) {
        along = arm;
        farthest = point;
      }
      size = std::max(size, norm(position(point)));
    }
    double height = 0.0;
    for (const Index point : body.points) {
      height = std::max(height, norm(cross(along, position(point) - first)));
    }
    constexpr double rounding = 64.0 * std::numeric_limits<double>::epsilon();
    if (!(height > rounding * size * norm(along))) {
      throw InputError(where + "/points", "all " + text(body.points.size()) +
                                              " points are on one line, through points " + text(body.points.front()) +
                                              " and " + text(farthest) + "; a rigid body needs one beside it");
    }
  }

  /// Checks that the map, its derivatives along the given motion and its tangents are numbers.
  void check(const UserCoordinates& user, const std::string& where) {
    const CoordinateKernel& kernel = user.kernel;
    if (kernel.evaluate == nullptr) throw InputError(where + "/x", "is missing: there is no function to call");
    if (kernel.num_points < 1) throw InputError(where + "/x", "a map to no point; at least 1 is right");
    if (kernel.num_coordinates < 1) throw InputError(where + "/q", "a map of no coordinates; at least 1 is right");
    const auto p = static_cast<std::size_t>(kernel.num_points), s = static_cast<std::size_t>(kernel.num_coordinates);
    for (std::size_t k = 0; k < user.tuples.size(); ++k) {
      const std::string tuple = user.tuples.size() == 1 ? where + "/points" : element(where + "/points", k);
      if (user.tuples[k].size() != p) {
        throw InputError(tuple,
                         text_of_count(user.tuples[k].size(), "point") + " for a map to " + text_of_count(p, "point"));
      }
      cover_at(user.tuples[k], tuple);
    }
    check_numbers(user.q, user.tuples.size() * s, where + "/q", "q");
    if (!user.q_dot.empty()) check_numbers(user.q_dot, user.q.size(), where + "/q_dot", "q_dot");

    const std::vector<double> at_rest(s, 0.0);
    std::vector<double> r(3 * p), v(3 * p), psi(3 * p), tangents(3 * p * s);
    for (std::size_t k = 0; k < user.tuples.size(); ++k) {
      const double* const q_dot = user.q_dot.empty() ? at_rest.data() : &user.q_dot[k * s];
      kernel.evaluate(kernel.context.get(),
                      {1, t_, &user.q[k * s], q_dot, r.data(), v.data(), psi.data(), tangents.data()});
      const std::pair<const char*, const std::vector<double>&> results[] = {
          {"a position", r}, {"a velocity", v}, {"a curvature psi", psi}, {"a tangent", tangents}};
      for (const auto& [noun, numbers] : results) {
        const auto bad = std::ranges::find_if_not(numbers, [](double x) { return is_in_range(x); });
        if (bad != numbers.end()) {
          throw InputError(where + "/q", text(std::span<const Index>(user.tuples[k])) + ": the map has " + noun + " " +
                                             text(*bad) + " at the start");
        }
      }
    }
  }

  static void check_numbers(std::span<const double> numbers, std::size_t wanted, const std::string& where,
                            const std::string& noun) {
    if (numbers.size() != wanted) {
      throw InputError(where, text_of_count(numbers.size(), "number") + "; one for each coordinate of each tuple, " +
                                  text(wanted) + ", are right");
    }
    for (std::size_t i = 0; i < numbers.size(); ++i) check_number(numbers[i], ValueRange::any, element(where, i), noun);
  }

  // ---- points ----

  void check_range(Index point, const std::string& where) const {
    if (0 <= point && static_cast<std::size_t>(point) < system_.num_points()) return;
    throw InputError(where, "point " + text(point) + " is out of range: the scene has " +
                                text_of_count(system_.num_points(), "point"));
  }

  void cover(std::span<const Index> points, const std::string& where) { cover_at(points, where + "/points"); }

  /// Marks that these points now belong to the present entry.
  void cover_at(std::span<const Index> points, const std::string& where) {
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Index point = points[k];
      check_range(point, element(where, k));
      const auto i = static_cast<std::size_t>(point);
      if (support_of_point_[i] != no_support) {
        throw InputError(element(where, k), "point " + text(point) + " belongs to " +
                                                element("/supports", support_of_point_[i]) +
                                                " already: its motion is prescribed, no coordinates move it");
      }
      if (owner_of_point_[i] != none) {
        throw InputError(element(where, k), "point " + text(point) + " is covered by " +
                                                entry_pointer(owner_of_point_[i]) +
                                                " already; every point that moves is covered once");
      }
      owner_of_point_[i] = entry_;
    }
  }

  void check_cover() const {
    for (std::size_t i = 0; i < owner_of_point_.size(); ++i) {
      if (owner_of_point_[i] == none && support_of_point_[i] == no_support) {
        throw InputError("/coordinates",
                         "point " + text(i) + " moves and no entry covers it; every point that moves is covered once");
      }
    }
  }

  void check_names() const {
    std::unordered_map<std::string, std::size_t> owners;
    for (std::size_t i = 0; i < system_.coordinates.size(); ++i) {
      const auto [owner, is_new] = owners.emplace(coordinates_name(system_, i), i);
      if (is_new) continue;
      throw InputError(entry_pointer(i) + "/name", "\"" + owner->first + "\" is the name of " +
                                                       entry_pointer(owner->second) + " already; a name is used once");
    }
  }

  static std::string entry_pointer(std::size_t entry) { return element("/coordinates", entry); }
  Vec3 position(Index point) const { return load(system_.positions.data(), point); }

  static constexpr std::size_t none = no_support;

  const System& system_;
  const std::span<const std::size_t> support_of_point_;
  const double t_;
  std::vector<std::size_t> owner_of_point_;  ///< [point] -> its entry or none
  std::size_t entry_ = 0;
};

}  // namespace

void validate_coordinates(const System& system, std::span<const std::size_t> support_of_point, double t) {
  if (!system.coordinates.empty()) CoordinateValidation(system, support_of_point, t).run();
}

}  // namespace tanor::detail
