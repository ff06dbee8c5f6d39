/// The implicit step that `auto` tries on the way leaves the motion as it was, also where supports move.

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "scenes.hpp"

namespace tanor {
namespace {

// ---- chains that were lost ----

VectorFunction shaken_along_x(const std::string& formula) {
  return {ScalarFunction::formula(formula), 0.0, 0.0};
}

/// Returns a bob of 1 kg on a rod of 1 m.
System make_shaken_pendulum(const ScalarFunction& motion) {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  scenes::add_point({0.29552020666133955, 0, -0.955336489125606}, &system);
  system.velocities[3] = 0.5;
  system.masses = {1, 1};
  system.supports = {{"", {0}, {motion, 0.0, 0.0}}};
  system.constraints = {Rods{"rod", {{0, 1}}, {}, {}}};
  system.forces = {scenes::gravity};
  return system;
}

System make_shaken_chain_with_drag() {
  System system;
  for (const Vector3& place : {Vector3{0, 0, 0}, {0.3, 0, -0.4}, {0.3, 0.5, -0.4}, {0.6, 0.5, -0.8}})
    scenes::add_point(place, &system);
  for (const std::size_t point : {1, 2, 3}) system.velocities[3 * point] = 0.5;
  system.masses = {1, 1, 1, 1};
  system.supports = {{"", {0}, shaken_along_x("0.1*sin(5*t)")}};
  system.constraints = {Rods{"rods", {{0, 1}, {1, 2}, {2, 3}}, {}, {}}};
  system.forces = {scenes::gravity, Drag{"air", {1, 2, 3}, 0.5, 0.0}};
  return system;
}

System make_shaken_stiff_spring() {
  System system;
  for (const Vector3& place : {Vector3{0, 0, 0}, {0.3, 0, -0.9539392014169457}, {0.3, 0, -1.9}})
    scenes::add_point(place, &system);
  system.velocities = {0.3, 0, 0, 0.3, 0, 0, 0.3, 0, 0};
  system.masses = {1, 1, 1};
  system.supports = {{"", {0}, shaken_along_x("0.1*sin(3*t)")}};
  system.constraints = {Rods{"rod", {{0, 1}}, {}, {}}};
  system.forces = {scenes::gravity, Springs{"spring", {{1, 2}}, 1e6, 100.0, {}}};
  return system;
}

/// Runs with `auto` and compares the last point with (x, y, z).
void expect_last_point(const System& system, double t_end, double rtol, const Vector3& wanted, double allowed) {
  Simulation simulation(system, {.rtol = rtol});
  ASSERT_TRUE(simulation.advance_to(t_end).ok()) << simulation.outcome().what;

  const auto last = simulation.positions().last(3);
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(last[axis], wanted[axis], allowed) << "axis " << axis;
  EXPECT_EQ(simulation.report().accuracy_warning, "");
}

TEST(ImplicitTrial, KeepsTheMotionOfASupport) {
  expect_last_point(make_shaken_pendulum(ScalarFunction::formula("0.1*sin(5*t)")), 200.0, 1e-8,
                    {-0.1914529671, 0.0, -0.9616895317}, 1e-5);
  expect_last_point(make_shaken_chain_with_drag(), 150.0, 1e-8, {-0.1010007047, 0.0, -1.4759597130}, 1e-6);
  expect_last_point(make_shaken_stiff_spring(), 20.0, 1e-9, {-0.5326165225, 0.0, -1.8359998475}, 1e-6);
}

/// A pendulum never turns out stiff, so that the trials of `auto` are for nothing, and it ends where the method alone
/// ends, to the last bit. A table of time has as many knots as steps.
TEST(ImplicitTrial, ChangesNoBitOfAMotionThatIsNotStiff) {
  std::vector<double> times, places;
  for (int k = 0; k <= 400; ++k) {
    times.push_back(0.1 * k);
    places.push_back(0.1 * std::sin(0.5 * k));
  }
  System breathing = scenes::make_breathing_chain(2), driven = scenes::make_driven_chain(2);
  System lifted = make_shaken_pendulum(0.0);
  lifted.constraints.push_back(
      Planes{"lift", {1}, {ScalarFunction::formula("0.1*sin(t)"), 1.0, 0.0}, ScalarFunction::formula("0.1*sin(2*t)")});
  for (const System& system :
       {make_shaken_pendulum(ScalarFunction::formula("0.1*sin(5*t)")),
        make_shaken_pendulum(ScalarFunction::table(times, places)),
        make_shaken_pendulum(ScalarFunction::custom([](const Jet<2>& t) { return 0.1 * sin(5.0 * t); })), breathing,
        driven, lifted}) {
    MotionOptions options{.max_step = 0.01, .start = StartMode::Project};
    Simulation chosen(system, options);
    options.method = chosen.report().method;
    Simulation alone(system, options);

    ASSERT_TRUE(chosen.advance_to(30.0).ok()) << chosen.outcome().what;
    ASSERT_TRUE(alone.advance_to(30.0).ok());

    EXPECT_GE(chosen.report().steps, 3000U);
    EXPECT_EQ(chosen.report().method, options.method);
    EXPECT_EQ(chosen.report().steps, alone.report().steps);
    const auto as_vector = [](std::span<const double> x) { return std::vector(x.begin(), x.end()); };
    EXPECT_EQ(as_vector(chosen.positions()), as_vector(alone.positions()));
    EXPECT_EQ(as_vector(chosen.velocities()), as_vector(alone.velocities()));
    EXPECT_EQ(as_vector(chosen.accelerations()), as_vector(alone.accelerations()));
  }
}

// ---- random scenes beside a dense program ----

/// A tree of rods and springs that hangs on supports which shake, written down twice.
class ShakenTree {
 public:
  /// The kind of function that moves supports. A custom one has no series, so that `auto` takes dop853.
  enum Kind { Formula, Table, Custom };

  ShakenTree(unsigned seed, bool is_stiff)
      : random_(seed),
        kind_(seed % 8 == 0   ? Custom
              : seed % 2 == 0 ? Table
                              : Formula) {
    const int count = 2 + static_cast<int>(seed / 3 % 4);
    add_point({0, 0, 0}, true);
    for (int k = 1; k < count; ++k) hang_point(k == 1 || draw(0, 1) < 0.7);
    if (draw(0, 1) < 0.3) {
      const Index other = add_point({draw(-1, 1), draw(-1, 1), draw(-1, 1)}, true);
      springs_.push_back(make_spring(other, other - 1, draw(5, 50), draw(0, 0.5)));
    }
    if (is_stiff) {
      hang_point(false);
      springs_.back().stiffness = 1e5;
      springs_.back().damping = 1e5 * mass_.back();
    }
    drag_ = draw(0, 1) < 0.5 ? draw(0.0, 0.5) : 0.0;
  }

  System system() const {
    System result;
    result.positions = r0_;
    result.velocities.resize(r0_.size());
    result.masses = mass_;
    for (std::size_t k = 0; k < supports_.size(); ++k) {
      VectorFunction motion;
      for (std::size_t axis = 0; axis < 3; ++axis) motion.components[axis] = function(supports_[k].shakes[axis]);
      result.supports.push_back({"support" + std::to_string(k), {supports_[k].point}, motion});
    }
    if (!rods_.empty()) result.constraints = {Rods{"rods", rods_, {}, {}}};
    result.forces = {scenes::gravity};
    for (const Spring& spring : springs_)
      result.forces.push_back(
          Springs{"", {{spring.i, spring.j}}, spring.stiffness, spring.damping, spring.rest_length});
    Drag air{"air", {}, drag_, 0.0};
    for (std::size_t i = 0; i < mass_.size(); ++i)
      if (inverse_[i] > 0.0) air.points.push_back(static_cast<Index>(i));
    result.forces.push_back(air);
    return result;
  }

  /// Integrates from positions and velocities at t = 0 by extrapolated midpoint steps (Gragg, Bulirsch and Stoer) of
  /// one length, with as many columns. Knots of tables lie at their ends.
  void advance(double step, int num_steps, std::size_t columns, std::vector<double>* r, std::vector<double>* v) const {
    std::vector<double> y(*r);
    y.insert(y.end(), v->begin(), v->end());
    for (int k = 0; k < num_steps; ++k) extrapolate(k * step, step, columns, &y);
    std::copy_n(y.begin(), r->size(), r->begin());
    std::copy_n(y.begin() + static_cast<std::ptrdiff_t>(r->size()), v->size(), v->begin());
  }

 private:
  struct Shake {
    double amplitude, rate, phase;
    double start = amplitude * std::sin(phase);
  };
  struct Mover {
    Index point;
    std::array<Shake, 3> shakes;
  };
  struct Spring {
    Index i, j;
    double stiffness, damping, rest_length;
  };
  using Vector = std::vector<double>;

  double draw(double least, double most) { return std::uniform_real_distribution<double>(least, most)(random_); }

  Index add_point(const Vector3& place, bool is_support) {
    const auto point = static_cast<Index>(mass_.size());
    r0_.insert(r0_.end(), place.begin(), place.end());
    mass_.push_back(draw(0.1, 1.0));
    inverse_.push_back(is_support ? 0.0 : 1.0 / mass_.back());
    if (!is_support) return point;
    Mover mover{point, {}};
    for (Shake& shake : mover.shakes) shake = Shake{draw(-0.1, 0.1), draw(1, 15), draw(0, 6)};
    supports_.push_back(mover);
    return point;
  }
  /// Adds a point that a rod or a spring joins to an earlier one.
  void hang_point(bool by_rod) {
    const auto upper = static_cast<std::size_t>(draw(0, 0.999 * static_cast<double>(mass_.size())));
    Vector3 place{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      place[axis] = r0_[3 * upper + axis] + draw(0.1, 0.4) * (axis == 2 ? -1 : 1);
    const Index point = add_point(place, false);
    if (by_rod)
      rods_.push_back({static_cast<Index>(upper), point});
    else
      springs_.push_back(make_spring(static_cast<Index>(upper), point, draw(5, 50), draw(0, 0.5)));
  }
  Spring make_spring(Index i, Index j, double stiffness, double damping) const {
    double square = 0.0;
    for (Index axis = 0; axis < 3; ++axis) square += std::pow(at(r0_, j, axis) - at(r0_, i, axis), 2);
    return {i, j, stiffness, damping, 0.9 * std::sqrt(square)};
  }

  static double at(const Vector& array, Index point, Index axis) {
    return array[static_cast<std::size_t>(3 * point + axis)];
  }

  /// Returns a (sin(w t + p) - sin p) as the user gives it.
  ScalarFunction function(const Shake& shake) const {
    const auto [a, w, p, start] = shake;
    if (kind_ == Custom)
      return ScalarFunction::custom(
          [a = a, w = w, p = p, start = start](const Jet<2>& t) { return a * sin(w * t + p) - start; });
    if (kind_ == Formula)
      return ScalarFunction::formula("a*sin(w*t + p) - start", {{"a", a}, {"w", w}, {"p", p}, {"start", start}});
    Vector times, values;
    for (int k = 0; k <= 40; ++k) {
      times.push_back(0.05 * k);
      values.push_back(a * std::sin(w * times.back() + p) - start);
    }
    return ScalarFunction::table(times, values);
  }
  /// Returns the displacement and its two derivatives. A table is the user's own interpolant, which is read from it.
  std::array<double, 3> moved(std::size_t support, std::size_t axis, double t) const {
    const auto [a, w, p, start] = supports_[support].shakes[axis];
    if (kind_ != Table) {
      const double sine = std::sin(w * t + p);
      return {a * sine - start, a * w * std::cos(w * t + p), -a * w * w * sine};
    }
    while (tables_.size() < 3 * supports_.size())
      tables_.push_back(function(supports_[tables_.size() / 3].shakes[tables_.size() % 3]));
    const Jet<2> jet = tables_[3 * support + axis](t);
    return {jet.value(), jet.derivative(1), jet.derivative(2)};
  }

  /// Writes (v, w) at (t, y), where it puts supports as given.
  void find_slope(double t, Vector* y, Vector* slope) const {
    const auto n = static_cast<Index>(r0_.size());
    double *const r = y->data(), *const v = r + n, *const w = slope->data() + n;
    for (std::size_t k = 0; k < supports_.size(); ++k) {
      for (Index axis = 0; axis < 3; ++axis) {
        const Index place = 3 * supports_[k].point + axis;
        const auto [x, x_dot, x_ddot] = moved(k, static_cast<std::size_t>(axis), t);
        r[place] = r0_[static_cast<std::size_t>(place)] + x;
        v[place] = x_dot;
        w[place] = x_ddot;
      }
    }
    std::copy_n(v, n, slope->data());
    for (Index i = 0; i < n; ++i) {
      const double inverse = inverse_[static_cast<std::size_t>(i / 3)];
      if (inverse > 0.0) w[i] = (i % 3 == 2 ? -scenes::g : 0.0) - drag_ * inverse * v[i];
    }
    for (const Spring& s : springs_) {
      double square = 0.0, along = 0.0;
      for (Index k = 0; k < 3; ++k) {
        const double d = r[3 * s.j + k] - r[3 * s.i + k];
        square += d * d;
        along += d * (v[3 * s.j + k] - v[3 * s.i + k]);
      }
      const double length = std::sqrt(square);
      const double tension = s.stiffness * (length - s.rest_length) + s.damping * along / length;
      for (Index k = 0; k < 3; ++k) {
        const double force = tension * (r[3 * s.j + k] - r[3 * s.i + k]) / length;
        w[3 * s.i + k] += inverse_[static_cast<std::size_t>(s.i)] * force;
        w[3 * s.j + k] -= inverse_[static_cast<std::size_t>(s.j)] * force;
      }
    }
    pull_rods(r, v, w);
  }

  /// Solves (r_j - r_i)(w_j - w_i) = -|v_j - v_i|^2 for the tensions of all rods, over their lengths, and adds them.
  void pull_rods(const double* r, const double* v, double* w) const {
    constexpr std::size_t most = 6;
    const std::size_t d = rods_.size();
    double g[most][3], rows[most][most + 1];
    const auto sign = [&](std::size_t rod, Index point) {
      return (rods_[rod][1] == point ? 1.0 : 0.0) - (rods_[rod][0] == point ? 1.0 : 0.0);
    };
    for (std::size_t a = 0; a < d; ++a) {
      for (Index k = 0; k < 3; ++k) g[a][k] = r[3 * rods_[a][1] + k] - r[3 * rods_[a][0] + k];
    }
    for (std::size_t a = 0; a < d; ++a) {
      const auto [i, j] = rods_[a];
      for (std::size_t b = 0; b <= d; ++b) rows[a][b] = 0.0;
      for (Index k = 0; k < 3; ++k) {
        const double dv = v[3 * j + k] - v[3 * i + k];
        rows[a][d] -= dv * dv + g[a][k] * (w[3 * j + k] - w[3 * i + k]);
      }
      for (std::size_t b = 0; b < d; ++b) {
        const double cosine = g[a][0] * g[b][0] + g[a][1] * g[b][1] + g[a][2] * g[b][2];
        for (const Index point : {i, j})
          rows[a][b] += sign(a, point) * sign(b, point) * inverse_[static_cast<std::size_t>(point)] * cosine;
      }
    }
    for (std::size_t a = 0; a < d; ++a) {  // Gauss and Jordan; the matrix is positive definite
      for (std::size_t b = 0; b < d; ++b) {
        if (b == a) continue;
        const double factor = rows[b][a] / rows[a][a];
        for (std::size_t c = a; c <= d; ++c) rows[b][c] -= factor * rows[a][c];
      }
    }
    for (std::size_t a = 0; a < d; ++a) {
      for (const Index point : rods_[a]) {
        const double move = sign(a, point) * inverse_[static_cast<std::size_t>(point)] * rows[a][d] / rows[a][a];
        for (Index k = 0; k < 3; ++k) w[3 * point + k] += move * g[a][k];
      }
    }
  }

  /// Replaces y at t by y at t + step.
  void extrapolate(double t, double step, std::size_t columns, Vector* y) const {
    const std::size_t size = y->size();
    Vector first(size), rate(size), before, now;
    find_slope(t, y, &first);
    std::vector<Vector> table;
    for (std::size_t j = 0; j < columns; ++j) {
      const auto count = static_cast<double>(2 * (j + 1));
      const double h = step / count;
      before = now = *y;
      for (std::size_t i = 0; i < size; ++i) now[i] += h * first[i];
      for (int m = 1; m < static_cast<int>(count); ++m) {
        find_slope(t + m * h, &now, &rate);
        for (std::size_t i = 0; i < size; ++i) before[i] += 2.0 * h * rate[i];
        std::swap(before, now);
      }
      find_slope(t + step, &now, &rate);
      for (std::size_t i = 0; i < size; ++i) now[i] = 0.5 * (before[i] + now[i] + h * rate[i]);
      // Aitken and Neville in h^2
      table.push_back(now);
      for (std::size_t k = j; k-- > 0;) {
        const double ratio = count / static_cast<double>(2 * (k + 1)), divisor = 1.0 / (ratio * ratio - 1.0);
        for (std::size_t i = 0; i < size; ++i)
          table[k][i] = table[k + 1][i] + (table[k + 1][i] - table[k][i]) * divisor;
      }
    }
    *y = table[0];
  }

  std::mt19937 random_;
  Kind kind_;
  Vector r0_, mass_, inverse_;  // 1/m; 0 at supports
  std::vector<Mover> supports_;
  std::vector<std::array<Index, 2>> rods_;
  std::vector<Spring> springs_;
  double drag_ = 0.0;
  mutable std::vector<ScalarFunction> tables_;  // [support][axis], made when they are read first
};

/// Runs with `auto`. Returns the largest distance, m, from where the dense program ends, which halves its steps until
/// two of its runs agree.
double compare_with_dense(const ShakenTree& tree, double t_end, int num_steps, std::size_t columns,
                          Simulation* simulation) {
  const std::vector<double> r0(simulation->positions().begin(), simulation->positions().end()),
      v0(simulation->velocities().begin(), simulation->velocities().end());
  const Outcome outcome = simulation->advance_to(t_end);
  EXPECT_TRUE(outcome.ok()) << outcome.what;
  std::vector<double> r(r0), before;
  do {
    before = r;
    r = r0;
    std::vector<double> v(v0);
    tree.advance(t_end / num_steps, num_steps, columns, &r, &v);
    num_steps *= 2;
  } while (!(largest_difference(before, r) <= 1e-10));
  return largest_difference(simulation->positions(), r);
}

/// The tolerance is 1e-12, and these trees enlarge errors less than 1e3 times in 0.6 s. Steps are kept short, so that
/// the trial comes after 500 of them; it fails.
TEST(ImplicitTrial, KeepsRandomTreesThatShake) {
  constexpr double t_end = 0.6;
  for (unsigned seed = 0; seed < 280; ++seed) {
    SCOPED_TRACE(seed);
    const ShakenTree tree(seed, false);
    const MotionOptions options{.max_step = t_end / 600, .rtol = 1e-12, .atol = 1e-12, .start = StartMode::Project};
    Simulation simulation(tree.system(), options);

    EXPECT_LE(compare_with_dense(tree, t_end, 12, 8, &simulation), 1e-9);

    EXPECT_GE(simulation.report().steps, 600U);
    EXPECT_EQ(simulation.report().accuracy_warning, "");
  }
}

/// A point on a spring whose damper stops it in 1e-5 s keeps explicit steps short, and radau5 takes over.
TEST(ImplicitTrial, KeepsRandomTreesWithAStiffSpring) {
  constexpr double t_end = 0.04;
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    const ShakenTree tree(seed, true);
    const MotionOptions options{.rtol = 1e-10, .atol = 1e-10, .start = StartMode::Project};
    Simulation simulation(tree.system(), options);

    EXPECT_LE(compare_with_dense(tree, t_end, 1500, 4, &simulation), 1e-8);

    EXPECT_EQ(simulation.report().method, Method::Radau5);
  }
}

}  // namespace
}  // namespace tanor
