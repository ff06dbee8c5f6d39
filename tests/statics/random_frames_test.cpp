/// Random scenes that turn or accelerate rest and vibrate as the dense dynamics in the frame at rest says.

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>
#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>
#include <tanor/user_kernel.hpp>

#include "dense.hpp"
#include "reference.hpp"

namespace tanor {
namespace {

using Eigen::MatrixXd, Eigen::Vector3d, Eigen::VectorXd;

// ---- random scenes -----------------------------------------------------------------------------------------------

/// A steady motion x -> axis point + R(spin t) (x - axis point) + velocity t + acceleration t^2/2, with the velocity
/// and the acceleration along the axis if it turns.
struct Motion {
  Vector3d axis, point, velocity, acceleration;
  double spin;

  /// Returns what carries x along, a function of the component and of t; without shifts for directions.
  auto terms_of(const Vector3d& x, bool is_direction = false) const {
    const Vector3d arm = is_direction ? x : Vector3d(x - point), along = axis.dot(arm) * axis, out = arm - along,
                   side = axis.cross(out), still = is_direction ? along : Vector3d(along + point);
    const double shifts = is_direction ? 0.0 : 1.0;
    return [=, v = Vector3d(shifts * velocity), a = Vector3d(shifts * acceleration), w = spin](int i, const auto& t) {
      using std::cos, std::sin;
      return still[i] + out[i] * cos(w * t) + side[i] * sin(w * t) + v[i] * t + 0.5 * a[i] * t * t;
    };
  }
  ScalarFunction component(const Vector3d& x, int i, bool is_direction) const {
    return ScalarFunction::custom([=, terms = terms_of(x, is_direction)](const auto& t) { return terms(i, t); });
  }
  VectorFunction place(const Vector3d& x) const {
    return {component(x, 0, false), component(x, 1, false), component(x, 2, false)};
  }
  VectorFunction direction(const Vector3d& x) const {
    return {component(x, 0, true), component(x, 1, true), component(x, 2, true)};
  }
  VectorFunction displacement(const Vector3d& x) const {
    const auto moved = [&](int i) {
      return ScalarFunction::custom([=, x0 = x[i], terms = terms_of(x)](const auto& t) { return terms(i, t) - x0; });
    };
    return {moved(0), moved(1), moved(2)};
  }
};

/// Draws beads on guides, pendulums and springs that all turn or accelerate together.
class RandomFrame {
 public:
  explicit RandomFrame(unsigned seed) : random_(seed) {
    motion.axis = vector().normalized();
    motion.point = vector();
    motion.spin = draw(0.0, 1.0) < 0.75 ? draw(0.3, 3.0) : 0.0;
    motion.velocity = motion.acceleration = Vector3d::Zero();
    if (draw(0.0, 1.0) < 0.5) motion.velocity = motion.spin > 0.0 ? Vector3d(vector()[0] * motion.axis) : vector();
    if (draw(0.0, 1.0) < 0.5)
      motion.acceleration = motion.spin > 0.0 ? Vector3d(2.0 * vector()[0] * motion.axis) : vector();
    at = draw(0.0, 2.0);
    // Some lifts fall freely.
    const Vector3d weight = motion.spin > 0.0      ? Vector3d(10.0 * motion.axis)
                            : draw(0.0, 1.0) < 0.3 ? motion.acceleration
                                                   : Vector3d(5.0 * vector());
    system.add_gravity({weight[0], weight[1], weight[2]});
    const int beads = 1 + static_cast<int>(draw(0.0, 3.0));
    for (int k = 0; k < beads; ++k) add_bead();
  }

  struct Well {
    Index bead;
    double stiffness;
    VectorFunction centre;
  };
  Motion motion;
  System system;
  std::vector<Well> wells;  // potentials, which the dense program takes from here
  double at = 0.0;

 private:
  double draw(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vector3d vector() { return {draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-1.0, 1.0)}; }
  Index add(const Vector3d& x) {
    system.positions.insert(system.positions.end(), {x[0], x[1], x[2]});
    system.masses.push_back(draw(0.5, 2.0));
    return static_cast<Index>(system.masses.size() - 1);
  }
  Index add_support() {
    const Vector3d x = motion.point + 1.5 * vector();
    const Index point = add(x);
    system.supports.push_back({"", {point}, motion.displacement(x)});
    return point;
  }
  void add_spring(Index i, Index j) {
    Springs springs{.pairs = {{i, j}}, .stiffness = draw(60.0, 200.0)};
    springs.rest_length.constants = {draw(0.2, 1.0)};
    system.forces.push_back(springs);
  }
  /// Adds k/2 |r - c(t)|^2, whose centre moves with the frame.
  void add_well(Index bead, const Vector3d& x, double stiffness) {
    const VectorFunction centre = motion.place(x);
    const auto energy = [=, turn = motion.terms_of(x)](const auto& r, const auto& t) {
      const auto dx = r[0] - turn(0, t), dy = r[1] - turn(1, t), dz = r[2] - turn(2, t);
      return 0.5 * stiffness * (dx * dx + dy * dy + dz * dz);
    };
    system.forces.push_back(Potential{.points = {{bead}}, .kernel = make_potential_kernel<1>(energy)});
    wells.push_back({bead, stiffness, centre});
  }
  void add_bead() {
    const Vector3d centre = motion.point + 1.5 * vector(), normal = vector();
    const Index bead = add(centre + 0.8 * vector());
    switch (static_cast<int>(draw(0.0, 6.0))) {
      case 0:
        system.constraints.push_back(Circles{
            .points = {bead}, .center = motion.place(centre), .normal = motion.direction(normal), .radius = 0.8});
        return;
      case 1:
        system.constraints.push_back(Spheres{.points = {bead}, .center = motion.place(centre), .radius = 0.8});
        return;
      case 2:
        system.constraints.push_back(
            Lines{.points = {bead}, .origin = motion.place(centre), .direction = motion.direction(normal)});
        break;
      case 3: {
        Rods rods{.pairs = {{add_support(), bead}}, .length = 0.9};
        if (draw(0.0, 1.0) < 0.5) rods.pairs.push_back({bead, add(centre + vector())});
        system.constraints.push_back(rods);
        return;
      }
      case 4:
        add_well(bead, centre, draw(20.0, 60.0));
        return;
      default:
        break;
    }
    for (int k = 0; k < 3; ++k) add_spring(add_support(), bead);
  }

  std::mt19937 random_;
};

/// Accelerations beside the frame at the time t0, dense: w(r, v) - a - 2 Omega x v_rel, where a is that of the frame.
struct DenseFrame {
  explicit DenseFrame(const RandomFrame& given) : scene(given), system(given.system) {
    std::erase_if(system.forces, [](const Force& force) { return std::holds_alternative<Potential>(force); });
  }

  const RandomFrame& scene;
  System system;  // without wells

  Vector3d spin() const { return scene.motion.spin * scene.motion.axis; }
  Vector3d place_velocity(const Vector3d& x) const {
    return spin().cross(x - axis_point()) + scene.motion.velocity + scene.at * scene.motion.acceleration;
  }
  Vector3d axis_point() const { return scene.motion.point; }
  Vector3d place_acceleration(const Vector3d& x) const {
    return spin().cross(spin().cross(x - axis_point())) + scene.motion.acceleration;
  }
  /// `r` and `relative` are [3n].
  VectorXd relative_acceleration(const std::vector<double>& r, const VectorXd& relative) const {
    std::vector<double> v(r.size());
    for (Index i = 0; i < static_cast<Index>(r.size() / 3); ++i) {
      const Vector3d own = place_velocity(reference::point(r, i)) + relative.segment<3>(3 * i);
      std::copy_n(own.data(), 3, v.data() + 3 * i);
    }
    reference::Mechanics mechanics = reference::make_mechanics(system, scene.at, r, v);
    for (const RandomFrame::Well& well : scene.wells) {
      for (int i = 0; i < 3; ++i) {
        const auto k = std::ranges::find(mechanics.coordinates, 3 * well.bead + i) - mechanics.coordinates.begin();
        mechanics.f[k] -= well.stiffness * (reference::point(r, well.bead)[i] -
                                            well.centre.components[static_cast<std::size_t>(i)](scene.at).value());
      }
    }
    VectorXd w = reference::solve_kkt(mechanics).w;
    for (Eigen::Index k = 0; k < w.size(); k += 3) {
      const auto point = static_cast<Index>(mechanics.coordinates[static_cast<std::size_t>(k)] / 3);
      w.segment<3>(k) -=
          place_acceleration(reference::point(r, point)) + 2.0 * spin().cross(Vector3d(relative.segment<3>(3 * point)));
    }
    return w;
  }
};

/// Vibrations s'' + B s' + A s = 0 along the moves Z that the constraints allow, by differences of the dense
/// accelerations.
struct DenseVibrations {
  DenseVibrations(const DenseFrame& dense, const std::vector<double>& r) {
    const std::vector<double> at_rest(r.size(), 0.0);
    const reference::Mechanics mechanics = reference::make_mechanics(dense.system, dense.scene.at, r, at_rest);
    coordinates = mechanics.coordinates;
    const VectorXd root = mechanics.M.cwiseSqrt();
    const MatrixXd scaled = root.cwiseInverse().asDiagonal() * mechanics.K;
    const MatrixXd basis = reference::orthonormal_basis(scaled).rightCols(root.size() - mechanics.K.cols());
    const MatrixXd Z = root.cwiseInverse().asDiagonal() * basis;
    project = (mechanics.M.asDiagonal() * Z).transpose();
    const auto differentiate = [&](const auto& evaluate) {
      constexpr double h = 1e-3;
      const auto at = [&](double x) { return VectorXd(-project * evaluate(x)); };
      return VectorXd((8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h));
    };
    A.resize(Z.cols(), Z.cols());
    B.resize(Z.cols(), Z.cols());
    for (Eigen::Index j = 0; j < Z.cols(); ++j) {
      VectorXd move = VectorXd::Zero(static_cast<Eigen::Index>(r.size()));
      for (Eigen::Index k = 0; k < Z.rows(); ++k) move[coordinates[static_cast<std::size_t>(k)]] = Z(k, j);
      A.col(j) = differentiate([&](double h) {
        std::vector<double> moved = r;
        for (std::size_t i = 0; i < r.size(); ++i) moved[i] += h * move[static_cast<Eigen::Index>(i)];
        return dense.relative_acceleration(moved, VectorXd::Zero(move.size()));
      });
      B.col(j) = differentiate([&](double h) { return dense.relative_acceleration(r, h * move); });
    }
  }

  /// Returns the largest misfit of (lambda^2 + B lambda + A) s = 0 over all modes.
  double misfit(const Modes& found) const {
    double worst = 0.0;
    for (std::size_t k = 0; k < found.count(); ++k) {
      const bool has_rates = !found.decay.empty();
      const std::complex<double> lambda = has_rates ? std::complex<double>(-found.decay[k], found.omega[k])
                                          : found.omega[k] >= 0.0 ? std::complex<double>(0.0, found.omega[k])
                                                                  : std::complex<double>(-found.omega[k], 0.0);
      Eigen::VectorXcd q(project.cols());
      for (Eigen::Index i = 0; i < q.size(); ++i) {
        const std::size_t numbers = found.shapes.size() / found.count();
        const auto at = k * numbers + static_cast<std::size_t>(coordinates[static_cast<std::size_t>(i)]);
        q[i] = {found.shapes[at], has_rates ? found.shapes_imaginary[at] : 0.0};
      }
      const Eigen::VectorXcd s = project * q, rest = lambda * lambda * s + lambda * (B * s) + A * s;
      worst = std::max(worst, rest.norm() / (1.0 + A.norm()));
    }
    return worst;
  }

  /// Checks the stability against the signs of A and the roots lambda, where these are clear of the differences'
  /// errors.
  void expect_alike(const StabilityReport& found, unsigned seed) const {
    constexpr double zero = 1e-7, of_double_roots = 1e-4;
    const Eigen::Index n = A.rows();
    const VectorXd energies = reference::eigenvalues(0.5 * (A + A.transpose()));
    const double scale = 1.0 + energies.cwiseAbs().maxCoeff();
    const auto num_zero = (energies.array().abs() < zero * scale).count(),
               num_falling = (energies.array() < -zero * scale).count();
    MatrixXd companion = MatrixXd::Zero(2 * n, 2 * n);
    companion.topRightCorner(n, n).setIdentity();
    companion.bottomLeftCorner(n, n) = -A;
    companion.bottomRightCorner(n, n) = -B;
    const auto growing = (companion.eigenvalues().real().array() > of_double_roots * std::sqrt(scale)).count();
    EXPECT_EQ(found.zero_modes, static_cast<std::size_t>(num_zero)) << seed;
    EXPECT_EQ(found.unstable_directions, static_cast<std::size_t>(growing)) << seed;
    EXPECT_EQ(found.status, growing > 0                                                    ? Stability::Unstable
                            : num_falling > 0 || found.zero_modes > found.rigid_zero_modes ? Stability::Marginal
                                                                                           : Stability::Stable)
        << seed;
  }

  std::vector<Eigen::Index> coordinates;
  MatrixXd project, A, B;  // Z'M
};

/// The frame's accelerations at rest are those that the dense equations of motion have at the positions and velocities
/// found, and the vibrations are theirs too.
TEST(RandomFrames, RestAndVibrateAsTheDenseDynamicsSays) {
  constexpr int scenes = 300;
  int found_of = 0, stable = 0, marginal = 0, with_rates = 0;
  for (unsigned seed = 0; seed < scenes; ++seed) {
    const RandomFrame scene(seed + 1);
    const EquilibriumResult found =
        find_equilibrium(scene.system, {.accept = AcceptedEquilibria::Any, .at = scene.at, .solver = {.threads = 1}});
    if (!found.outcome.ok()) {
      EXPECT_FALSE(found.outcome.what.empty());
      continue;
    }
    ++found_of;
    const DenseFrame dense(scene);
    const std::vector<double>& r = found.positions;
    for (Index i = 0; i < static_cast<Index>(r.size() / 3); ++i)
      EXPECT_LT((reference::point(found.velocities, i) - dense.place_velocity(reference::point(r, i))).norm(), 1e-8)
          << seed;
    const VectorXd nothing = VectorXd::Zero(static_cast<Eigen::Index>(r.size()));
    EXPECT_LT(dense.relative_acceleration(r, nothing).norm(), 1e-8) << seed;

    const Modes swing =
        modes(scene.system, r, {.count = ModesOptions::all, .time = scene.at, .solver = {.threads = 1}});
    ASSERT_TRUE(swing.outcome.ok()) << seed << ": " << swing.outcome.what;
    const DenseVibrations vibrations(dense, r);
    EXPECT_LT(vibrations.misfit(swing), 1e-8) << seed;
    vibrations.expect_alike(found.stability, seed);
    EXPECT_EQ(swing.unstable_directions, found.stability.unstable_directions) << seed;
    stable += found.stability.status == Stability::Stable ? 1 : 0;
    marginal += found.stability.status == Stability::Marginal ? 1 : 0;
    with_rates += swing.decay.empty() ? 0 : 1;
  }
  EXPECT_GT(found_of, scenes * 9 / 10);
  EXPECT_GT(stable, scenes / 2);
  EXPECT_GT(marginal, scenes / 50);
  EXPECT_GT(with_rates, scenes / 5);
}

}  // namespace
}  // namespace tanor
