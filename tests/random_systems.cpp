#include "random_systems.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include <rapidcheck.h>

namespace tanor {

namespace {

class RandomSystemMaker {
 public:
  RandomSystemMaker(std::size_t num_points, std::uint32_t seed, const RandomSystemOptions& options)
      : num_points_(static_cast<Index>(num_points)), options_(options), random_(seed) {}

  RandomSystem make() {
    result_.t = options_.time_dependent ? uniform(0.2, 2.0) : 0.0;
    place_points();
    add_supports();
    add_constraints();
    if (options_.forces) add_forces();
    project_velocities();
    return std::move(result_);
  }

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  double normal() { return std::normal_distribution()(random_); }
  bool happens(double probability) { return uniform(0.0, 1.0) < probability; }
  Index any_point() { return std::uniform_int_distribution<Index>(0, num_points_ - 1)(random_); }
  bool moves_in_time() { return options_.time_dependent && happens(0.5); }

  Vector3 any_vector() { return {normal(), normal(), normal()}; }
  Vector3 any_direction() {
    const Vector3 a = any_vector();
    return std::hypot(a[0], a[1], a[2]) > 0.3 ? a : any_direction();
  }

  std::vector<Index> any_points(std::size_t count) {
    std::vector<Index> all(static_cast<std::size_t>(num_points_));
    for (Index i = 0; i < num_points_; ++i) all[static_cast<std::size_t>(i)] = i;
    std::shuffle(all.begin(), all.end(), random_);
    all.resize(std::min(all.size(), count));
    return all;
  }

  /// Returns a function of time that has `value` at t and that is constant or swings with the given amplitude.
  ScalarFunction through(double value, double amplitude, bool moves) {
    if (!moves) return value;
    const double rate = uniform(0.5, 3.0), t = result_.t;
    return ScalarFunction::custom(
        [=](const auto& s) { return value + amplitude * (sin(rate * s) - std::sin(rate * t)); });
  }
  VectorFunction through(const Vector3& value, double amplitude, bool moves) {
    return {through(value[0], amplitude, moves), through(value[1], amplitude, moves),
            through(value[2], amplitude, moves)};
  }

  void place_points() {
    System& system = result_.system;
    const double side = 1.5 * std::cbrt(static_cast<double>(num_points_));
    const auto is_free = [&](const Vector3& r) {
      for (std::size_t i = 0; i < system.positions.size(); i += 3) {
        const double* const other = &system.positions[i];
        if (std::hypot(r[0] - other[0], r[1] - other[1], r[2] - other[2]) < 0.4) return false;
      }
      return true;
    };
    while (static_cast<Index>(system.masses.size()) < num_points_) {
      const Vector3 r = {uniform(0.0, side), uniform(0.0, side), uniform(0.0, side)};
      if (!is_free(r)) continue;
      system.positions.insert(system.positions.end(), r.begin(), r.end());
      system.masses.push_back(std::exp(uniform(-2.0, 2.0)));
    }
    result_.positions = system.positions;
    for (Index c = 0; c < 3 * num_points_; ++c) result_.velocities.push_back(normal());
  }

  /// Adds supports. The positions at t stay where they are, and the initial positions are moved instead.
  void add_supports() {
    System& system = result_.system;
    const auto most = static_cast<std::size_t>(std::min(num_points_ - 1, 3));
    for (const Index i : any_points(std::uniform_int_distribution<std::size_t>(0, most)(random_))) {
      Support support{"", {i}, {}};
      if (moves_in_time()) support.displacement = through(any_vector(), 0.3, true);
      const auto now = support.displacement(result_.t);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t c = 3 * static_cast<std::size_t>(i) + k;
        system.positions[c] = result_.positions[c] - now[k].value();
        result_.positions[c] = system.positions[c] + now[k].value();
        result_.velocities[c] = now[k].derivative(1);
      }
      system.supports.push_back(std::move(support));
    }
    is_support_ = reference::find_supports(system);
  }

  // ---- constraints ----

  void add_constraints() {
    const auto num_moving = static_cast<double>(std::count(is_support_.begin(), is_support_.end(), 0));
    const double wanted = uniform(0.0, options_.most_rows) * 3.0 * num_moving;
    for (int attempt = 0; attempt < 200 && static_cast<double>(gradients_.size()) < wanted; ++attempt) {
      (this->*adders[std::uniform_int_distribution<std::size_t>(0, std::size(adders) - 1)(random_)])();
    }
  }

  /// Returns true if the rows of a group with one member are independent of all rows so far, and then remembers them.
  /// Writes xi of the last row.
  template <class Group>
  bool is_independent(const Group& group, double* xi = nullptr) {
    System single;
    single.positions = result_.system.positions;
    single.masses = result_.system.masses;
    single.constraints.push_back(group);
    const auto numbers = reference::evaluate_constraints(single, result_.t, result_.positions, result_.velocities);
    const Eigen::Index rows = numbers.K.cols();
    std::vector<Eigen::VectorXd> fresh;
    for (Eigen::Index a = 0; a < rows; ++a) {
      Eigen::VectorXd g = numbers.K.col(a);
      for (Index i = 0; i < num_points_; ++i) {
        const auto k = static_cast<std::size_t>(i);
        g.segment<3>(3 * i) *= is_support_[k] ? 0.0 : 1.0 / std::sqrt(single.masses[k]);
      }
      const double length = g.norm();
      if (!(numbers.K.col(a).norm() > 0.1 && length > 0.0)) return false;
      for (int pass = 0; pass < 2; ++pass) {
        for (const Eigen::VectorXd& other : gradients_) g -= other.dot(g) * other;
        for (const Eigen::VectorXd& other : fresh) g -= other.dot(g) * other;
      }
      if (!(g.norm() > 0.05 * length)) return false;
      fresh.push_back(g.normalized());
    }
    gradients_.insert(gradients_.end(), fresh.begin(), fresh.end());
    if (xi != nullptr) *xi = numbers.xi[rows - 1];
    return true;
  }

  /// The range of the parameter of a kind, and how far the parameter swings.
  struct Range {
    double low, high, amplitude;
  };
  static constexpr Range any_value{-1e300, 1e300, 0.1}, any_length{0.3, 1e300, 0.1}, any_cosine{-0.9, 0.9, 0.01};

  /// Adds a group of those random members that fit, with the parameter that each has now. The parameter is `unit` times
  /// what xi measures.
  template <class Group, class Member, class AnyMember>
  void add_group(Group group, std::vector<Member> Group::*members, Parameter Group::*parameter, const Range& range,
                 std::size_t candidates, const AnyMember& any_member, double unit = 1.0) {
    std::vector<Member> taken;
    std::vector<ScalarFunction> functions;
    std::vector<double> constants;
    const bool moves = moves_in_time();
    for (std::size_t k = 0; k < candidates; ++k) {
      Group single = group;
      single.*members = {any_member()};
      single.*parameter = 0.0;
      const std::size_t rows_before = gradients_.size();
      double value = 0.0;
      if (!is_independent(single, &value)) continue;
      if (!(range.low < value && value < range.high)) {
        gradients_.resize(rows_before);
        continue;
      }
      taken.push_back((single.*members)[0]);
      constants.push_back(unit * value);
      functions.push_back(through(constants.back(), range.amplitude, true));
    }
    if (taken.empty()) return;
    group.*members = std::move(taken);
    group.*parameter = moves ? Parameter(std::move(functions)) : Parameter(std::move(constants));
    result_.system.constraints.push_back(std::move(group));
  }

  std::array<Index, 2> any_pair() {
    const std::vector<Index> points = any_points(2);
    return {points[0], points[1]};
  }

  /// Returns a place near a point, at most a few lengths away.
  Vector3 any_place_near(Index point) {
    const Vector3 away = any_direction();
    const double* const r = &result_.positions[3 * static_cast<std::size_t>(point)];
    return {r[0] + away[0], r[1] + away[1], r[2] + away[2]};
  }

  void add_rods() {
    if (num_points_ < 2) return;
    Rods rods;
    const bool shifted = happens(0.2);
    if (shifted) rods.offsets = {any_vector()};
    add_group(rods, &Rods::pairs, &Rods::length, any_length, shifted ? 1 : 4, [&] { return any_pair(); });
  }

  void add_planes() {
    Planes planes;
    planes.normal = through(any_direction(), 0.2, moves_in_time());
    const double normal_length = reference::norm(now(planes.normal)).value();
    add_group(
        planes, &Planes::points, &Planes::offset, any_value, 2, [&] { return any_point(); }, normal_length);
  }

  void add_spheres() {
    Spheres spheres;
    spheres.center = through(any_place_near(any_point()), 0.2, moves_in_time());
    add_group(spheres, &Spheres::points, &Spheres::radius, any_length, 2, [&] { return any_point(); });
  }

  void add_line() {
    Lines line;
    line.points = {any_point()};
    line.direction = through(any_direction(), 0.2, moves_in_time());
    line.origin = through(from_point(line.points[0], normal(), now(line.direction)), 0.2, moves_in_time());
    if (is_independent(line)) result_.system.constraints.push_back(std::move(line));
  }

  void add_circle() {
    Circles circle;
    circle.points = {any_point()};
    circle.normal = through(any_direction(), 0.2, moves_in_time());
    const auto arm = reference::cross(now(circle.normal), reference::place(any_direction()));
    const double arm_length = reference::norm(arm).value(), radius = uniform(0.5, 2.0);
    if (!(arm_length > 0.1)) return;
    circle.center = through(from_point(circle.points[0], radius / arm_length, arm), 0.2, moves_in_time());
    circle.radius = through(radius, 0.1, moves_in_time());
    if (is_independent(circle)) result_.system.constraints.push_back(std::move(circle));
  }

  void add_angles() {
    if (num_points_ < 3) return;
    const auto any_triple = [&] {
      const std::vector<Index> points = any_points(3);
      return std::array{points[0], points[1], points[2]};
    };
    add_group(Angles{}, &Angles::triples, &Angles::cosine, any_cosine, 2, any_triple);
  }

  void add_pulleys() {
    if (num_points_ < 2) return;
    const std::array<Index, 2> pair = any_pair();
    Pulleys pulleys;
    pulleys.a = any_place_near(pair[0]);
    pulleys.b = any_place_near(pair[1]);
    pulleys.ratio = uniform(0.5, 2.0) * (happens(0.2) ? -1.0 : 1.0);
    add_group(pulleys, &Pulleys::pairs, &Pulleys::length, any_value, 1, [&] { return pair; });
  }

  void add_linears() {
    Linears linears;
    const auto size = std::uniform_int_distribution<std::size_t>(1, 4)(random_);
    if (size > static_cast<std::size_t>(num_points_)) return;
    for (std::size_t k = 0; k < size; ++k) linears.coefficients.push_back(any_direction());
    add_group(linears, &Linears::tuples, &Linears::value, any_value, 2, [&] { return any_points(size); });
  }

  reference::Place now(const VectorFunction& function) const { return reference::standing({}, result_.t)(function); }

  /// Returns r - s d of a point.
  Vector3 from_point(Index point, double s, const reference::Place& d) const {
    const double* const r = &result_.positions[3 * static_cast<std::size_t>(point)];
    return {r[0] - s * d[0].value(), r[1] - s * d[1].value(), r[2] - s * d[2].value()};
  }

  // ---- forces and velocities ----

  void add_forces() {
    auto& forces = result_.system.forces;
    forces.push_back(Gravity{"", {0.3, -0.2, -9.81}});
    if (happens(0.5)) {
      ConstantForce force{"", any_points(3), through(any_vector(), 1.0, moves_in_time())};
      forces.push_back(std::move(force));
    }
    if (happens(0.5) && num_points_ >= 2) {
      Springs springs{"", {}, uniform(1.0, 20.0), happens(0.5) ? uniform(0.1, 2.0) : 0.0, uniform(0.0, 1.0)};
      for (int k = 0; k < 3; ++k) {
        const std::vector<Index> pair = any_points(2);
        springs.pairs.push_back({pair[0], pair[1]});
      }
      forces.push_back(std::move(springs));
    }
    if (happens(0.3)) forces.push_back(Drag{"", any_points(5), uniform(0.0, 1.0), uniform(0.0, 1.0)});
  }

  void project_velocities() {
    Dynamics dynamics(result_.system);
    const ProjectionReport report = dynamics.project_velocities(
        {.time = result_.t, .positions = result_.positions, .velocities = result_.velocities});
    if (!report.outcome.ok()) throw std::logic_error(report.outcome.what);
  }

  using Add = void (RandomSystemMaker::*)();
  static constexpr Add adders[] = {
      &RandomSystemMaker::add_rods,    &RandomSystemMaker::add_rods,    &RandomSystemMaker::add_rods,
      &RandomSystemMaker::add_rods,    &RandomSystemMaker::add_rods,    &RandomSystemMaker::add_planes,
      &RandomSystemMaker::add_spheres, &RandomSystemMaker::add_line,    &RandomSystemMaker::add_circle,
      &RandomSystemMaker::add_angles,  &RandomSystemMaker::add_pulleys, &RandomSystemMaker::add_linears};

  const Index num_points_;
  const RandomSystemOptions options_;
  std::mt19937 random_;
  RandomSystem result_;
  std::vector<char> is_support_;
  std::vector<Eigen::VectorXd> gradients_;  // orthonormal, M^-1/2 K
};

}  // namespace

RandomSystem make_random_system(std::size_t num_points, std::uint32_t seed, const RandomSystemOptions& options) {
  return RandomSystemMaker(num_points, seed, options).make();
}

RandomSystem without_guides(RandomSystem random) {
  std::erase_if(random.system.constraints, [](const Constraint& constraint) {
    return !std::holds_alternative<Rods>(constraint) && !std::holds_alternative<Angles>(constraint);
  });
  return random;
}

RandomSystem any_system(const RandomSystemOptions& options) {
  const auto num_points = *rc::gen::inRange<std::size_t>(1, 31).as("points");
  const auto seed = *rc::gen::noShrink(rc::gen::arbitrary<std::uint32_t>()).as("seed");
  return make_random_system(num_points, seed, options);
}

}  // namespace tanor
