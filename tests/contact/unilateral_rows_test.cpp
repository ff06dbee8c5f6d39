/// Ropes at one instant: which of them carry, and impacts, against an enumeration of all sets.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/Core>
#include <tanor/motion.hpp>

#include "dense.hpp"
#include "measures.hpp"

namespace tanor {
namespace {

/// Points that hang on ropes over shared points and on rods. All ropes are taut at the start.
struct RopesAndRods {
  System system{};
  Eigen::MatrixXd ropes{}, rods{};          // gradients of the moving points, one row each
  Eigen::VectorXd inverse_mass{}, force{};  // [3 moving points]
  double restitution = 0.0;
};

RopesAndRods make_ropes(std::mt19937& generator, double restitution) {
  std::uniform_real_distribution<double> number(-1.0, 1.0), mass(0.5, 2.0);
  const auto count = [&](int least, int most) { return std::uniform_int_distribution<int>(least, most)(generator); };
  RopesAndRods made{.restitution = restitution};
  const Index moving = count(2, 5), all = moving + 2;
  System& system = made.system;
  for (Index i = 0; i < all; ++i) {
    const Point point = i < moving
                            ? system.add_point({{number(generator), number(generator), number(generator)}})
                            : system.add_support({number(generator), number(generator), 2.0 + number(generator)});
    if (i < moving) system.masses[static_cast<std::size_t>(point.index)] = mass(generator);
  }
  made.inverse_mass.resize(3 * moving);
  made.force.resize(3 * moving);
  for (Index i = 0; i < moving; ++i) {
    const Vector3 f{3.0 * number(generator), 3.0 * number(generator), 3.0 * number(generator)};
    system.forces.push_back(ConstantForce{.points = {i}, .force = f});
    for (Index c = 0; c < 3; ++c) {
      made.force[3 * i + c] = f[static_cast<std::size_t>(c)];
      made.inverse_mass[3 * i + c] = 1.0 / system.masses[static_cast<std::size_t>(i)];
    }
  }
  const auto add_row = [&](const std::vector<Index>& path, Eigen::MatrixXd* rows) {
    rows->conservativeResize(rows->rows() + 1, 3 * moving);
    rows->row(rows->rows() - 1).setZero();
    for (std::size_t p = 1; p < path.size(); ++p) {
      const Eigen::Vector3d along =
          (reference::place(system.positions, path[p]) - reference::place(system.positions, path[p - 1])).normalized();
      if (path[p] < moving) rows->row(rows->rows() - 1).segment<3>(3 * path[p]) += along;
      if (path[p - 1] < moving) rows->row(rows->rows() - 1).segment<3>(3 * path[p - 1]) -= along;
    }
  };
  std::vector<Index> order(static_cast<std::size_t>(all));
  Ropes ropes{.restitution = restitution};
  for (int k = count(1, std::min(8, 3 * static_cast<int>(moving) - 2)); k > 0; --k) {
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), generator);
    std::vector<Index> path(order.begin(), order.begin() + count(2, 3));
    if (std::ranges::all_of(path, [&](Index i) { return i >= moving; })) continue;
    add_row(path, &made.ropes);
    ropes.paths.push_back(path);
  }
  if (ropes.paths.empty()) {
    ropes.paths.push_back({0, moving});
    add_row(ropes.paths.back(), &made.ropes);
  }
  system.constraints.push_back(ropes);
  made.rods.resize(0, 3 * moving);
  if (count(0, 1) == 1) {
    system.constraints.push_back(Rods{.pairs = {{0, 1}}});
    add_row({0, 1}, &made.rods);
  }
  return made;
}

/// Returns x of the closed rows, K'M^-1 K x = -b, and the change of the points M^-1 K x; rods come behind the ropes.
Eigen::VectorXd solve_closed(const RopesAndRods& made, unsigned closed, const Eigen::VectorXd& b, Eigen::VectorXd* x) {
  const Eigen::Index n = made.ropes.rows(), m = made.rods.rows();
  Eigen::MatrixXd K(0, made.inverse_mass.size());
  Eigen::VectorXd right(0);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < n + m; ++k) {
    if (k < n && (closed >> k & 1u) == 0) continue;
    K.conservativeResize(K.rows() + 1, Eigen::NoChange);
    K.row(K.rows() - 1) = k < n ? made.ropes.row(k) : made.rods.row(k - n);
    right.conservativeResize(K.rows());
    right[K.rows() - 1] = -b[k];
    rows.push_back(k);
  }
  *x = Eigen::VectorXd::Zero(n + m);
  if (rows.empty()) return Eigen::VectorXd::Zero(made.inverse_mass.size());
  const Eigen::MatrixXd S = K * made.inverse_mass.asDiagonal() * K.transpose();
  const Eigen::VectorXd solution = reference::solve_least_squares(S, right, 1e-11);
  for (std::size_t k = 0; k < rows.size(); ++k) (*x)[rows[k]] = solution[static_cast<Eigen::Index>(k)];
  return made.inverse_mass.asDiagonal() * K.transpose() * solution;
}

/// Returns the only change of the points for which no closed rope pushes and no other one lengthens: b + K'change <= 0
/// with 0 for closed ones. `wanted` [ropes and rods] are the rates that closed rows get rid of.
template <class IsOpenWrong>
Eigen::VectorXd enumerate(const RopesAndRods& made, const Eigen::VectorXd& b, const IsOpenWrong& is_wrong) {
  const Eigen::Index n = made.ropes.rows();
  double best = std::numeric_limits<double>::infinity();
  Eigen::VectorXd result;
  for (unsigned closed = 0; closed < 1u << n; ++closed) {
    Eigen::VectorXd x;
    const Eigen::VectorXd change = solve_closed(made, closed, b, &x);
    double wrong = 0.0;
    for (Eigen::Index k = 0; k < n; ++k)
      wrong = std::max(wrong, (closed >> k & 1u) != 0 ? x[k] : is_wrong(k, made.ropes.row(k).dot(change)));
    if (wrong >= best) continue;
    best = wrong;
    result = change;
  }
  EXPECT_LT(best, 1e-9);
  return result;
}

TEST(UnilateralRows, AccelerationsOfTautRopesAreThoseOfTheOnlyComplementarySet) {
  std::mt19937 generator(1);
  for (int scene = 0; scene < 1000; ++scene) {
    const RopesAndRods made = make_ropes(generator, 0.0);
    const Eigen::VectorXd free = made.inverse_mass.cwiseProduct(made.force);
    Eigen::VectorXd b(made.ropes.rows() + made.rods.rows());
    b << made.ropes * free, made.rods * free;
    const Eigen::VectorXd w = free + enumerate(made, b, [&](Eigen::Index k, double change) { return b[k] + change; });
    const Simulation simulation(made.system, {.method = Method::Dop853}, {.threads = 1});
    ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
    EXPECT_LT(largest_difference(simulation.accelerations().first(static_cast<std::size_t>(w.size())),
                                 {w.data(), static_cast<std::size_t>(w.size())}),
              1e-9 * (1.0 + free.cwiseAbs().maxCoeff()))
        << scene;
  }
}

TEST(UnilateralRows, ImpactsOfRopesAreThoseOfTheOnlyComplementarySetAndGainNoEnergy) {
  std::mt19937 generator(2);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (int scene = 0; scene < 1000; ++scene) {
    RopesAndRods made = make_ropes(generator, scene % 2 == 0 ? 0.0 : 0.5 * (1.0 + number(generator)));
    made.system.forces.clear();
    const Eigen::Index size = made.inverse_mass.size();
    Eigen::VectorXd v(size), x;
    for (double& each : v) each = number(generator);
    Eigen::VectorXd rates(made.ropes.rows() + made.rods.rows());
    rates << Eigen::VectorXd::Zero(made.ropes.rows()), made.rods * v;
    v += solve_closed(made, 0, rates, &x);  // the rods allow it
    rates << made.ropes * v, Eigen::VectorXd::Zero(made.rods.rows());
    // Ropes that shorten take no part: no set that closes them is tried.
    RopesAndRods parts = made;
    Eigen::VectorXd b = rates;
    parts.ropes.resize(0, size);
    std::vector<double> wanted;
    for (Eigen::Index k = 0; k < made.ropes.rows(); ++k) {
      if (rates[k] < 0.0) continue;
      parts.ropes.conservativeResize(parts.ropes.rows() + 1, Eigen::NoChange);
      parts.ropes.row(parts.ropes.rows() - 1) = made.ropes.row(k);
      wanted.push_back((1.0 + made.restitution) * rates[k]);
    }
    b = Eigen::VectorXd::Zero(parts.ropes.rows() + made.rods.rows());
    for (std::size_t k = 0; k < wanted.size(); ++k) b[static_cast<Eigen::Index>(k)] = wanted[k];
    const Eigen::VectorXd after = v + enumerate(parts, b, [&](Eigen::Index k, double change) { return b[k] + change; });
    if ((made.ropes * after - 1e-9 * Eigen::VectorXd::Ones(made.ropes.rows())).maxCoeff() > 0.0)
      continue;  // a second one

    made.system.velocities.assign(3 * made.system.num_points(), 0.0);
    std::copy(v.begin(), v.end(), made.system.velocities.begin());
    const Simulation simulation(made.system, {.method = Method::Dop853}, {.threads = 1});
    ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
    const auto found = simulation.velocities().first(static_cast<std::size_t>(size));
    EXPECT_LT(largest_difference(found, {after.data(), static_cast<std::size_t>(size)}), 1e-9) << scene;
    const auto energy = [&](const auto& u) {
      double sum = 0.0;
      for (Eigen::Index i = 0; i < size; ++i)
        sum += 0.5 * u[static_cast<std::size_t>(i)] * u[static_cast<std::size_t>(i)] / made.inverse_mass[i];
      return sum;
    };
    const std::vector<double> before(v.begin(), v.end());
    EXPECT_LE(energy(found), energy(before) * (1.0 + 1e-14)) << scene;
  }
}

}  // namespace
}  // namespace tanor
