#include <gtest/gtest.h>

#include <complex>
#include <random>
#include <vector>

#include <Eigen/Dense>

#include "assembly/newton_plan.hpp"

namespace tanor {
using namespace detail;
namespace {

/// The system has three moving points and a support (3), a constraint on 0 and 1, a compliant row on 1 and 2, and
/// couplings.
TEST(NewtonPlanTest, IsTheDenseMatrix) {
  using Complex = std::complex<double>;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const std::vector<double> masses{1.0, 2.0, 3.0};
  const std::vector<Coupling> couplings{{0, 1}, {1, 2}, {2, 3}};
  const std::vector<Incidence> incidences{{0, 0, 0, -1.0}, {1, 0, 0, 1.0}, {1, 1, 1, -1.0}, {2, 1, 1, 1.0}};
  const std::vector<Compliance> compliances{{50.0, 0.5}};
  const std::vector<Influence> influences{{0, 2}, {3, 1}, {1, 0}, {2, 3}};  // those of point 3, a support, do not count
  const NewtonPlan plan(masses, 2, couplings, influences, incidences, compliances, true);

  const auto make_blocks = [&](std::size_t count) {
    std::vector<Block3> blocks(count);
    for (Block3& block : blocks) {
      for (double& entry : block.entries) entry = uniform(random);
    }
    return blocks;
  };
  const std::vector<Block3> own_r = make_blocks(3), own_v = make_blocks(3), by_r = make_blocks(3),
                            by_v = make_blocks(3), other_r = make_blocks(4), other_v = make_blocks(4);
  std::vector<double> gradients(6);
  for (double& number : gradients) number = uniform(random);
  const NewtonPlan::Values values{own_r.data(),   own_v.data(),   by_r.data(),     by_v.data(),
                                  other_r.data(), other_v.data(), gradients.data()};
  const NewtonPlan::Weights<Complex> weights{{3.0, 1.0}, {0.7, -0.2}, {0.1, 0.4}};
  std::vector<Complex> entries(plan.rows().size());
  plan.assemble(weights, values, entries.data());

  Eigen::MatrixXd dr = Eigen::MatrixXd::Zero(12, 12), dv = dr;
  const auto add = [](const Block3& block, double sign, int i, int j, Eigen::MatrixXd* to) {
    for (int a = 0; a < 3; ++a) {
      for (int c = 0; c < 3; ++c) (*to)(3 * i + a, 3 * j + c) += sign * block(a, c);
    }
  };
  for (int i = 0; i < 3; ++i) {
    add(own_r[i], 1.0, i, i, &dr);
    add(own_v[i], 1.0, i, i, &dv);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [i, j] = couplings[k];
    for (const auto& [a, b, sign] : {std::tuple{i, i, 1.0}, {j, j, 1.0}, {i, j, -1.0}, {j, i, -1.0}}) {
      add(by_r[k], sign, a, b, &dr);
      add(by_v[k], sign, a, b, &dv);
    }
  }
  for (std::size_t k = 0; k < influences.size(); ++k) {
    add(other_r[k], 1.0, influences[k].on, influences[k].of, &dr);
    add(other_v[k], 1.0, influences[k].on, influences[k].of, &dv);
  }
  Eigen::MatrixXcd wanted = Eigen::MatrixXcd::Zero(11, 11);
  wanted.topLeftCorner(9, 9) = -weights.velocity * dv.topLeftCorner(9, 9) - weights.position * dr.topLeftCorner(9, 9);
  for (int i = 0; i < 9; ++i) wanted(i, i) += weights.mass * masses[static_cast<std::size_t>(i / 3)];
  for (const auto& [point, row, block, sign] : incidences) {
    for (int c = 0; c < 3; ++c) {
      wanted(3 * point + c, 9 + row) -= sign * gradients[static_cast<std::size_t>(3 * block + c)];
      wanted(9 + row, 3 * point + c) += sign * gradients[static_cast<std::size_t>(3 * block + c)];
    }
  }
  wanted(10, 10) = 1.0 / (weights.velocity * 0.5 + weights.position * 50.0);

  Eigen::MatrixXcd found = Eigen::MatrixXcd::Zero(11, 11);
  for (int j = 0; j < 11; ++j) {
    for (int k = plan.column_start()[j]; k < plan.column_start()[j + 1]; ++k) found(plan.rows()[k], j) = entries[k];
  }
  EXPECT_LT((found - wanted).cwiseAbs().maxCoeff(), 1e-9);  // the tiny compliance of the constraint
  EXPECT_GT(std::abs(found(9, 9)), 0.0);

  const NewtonPlan exact(masses, 2, couplings, influences, incidences, compliances, false);
  std::vector<Complex> exact_entries(exact.rows().size());
  exact.assemble(weights, values, exact_entries.data());
  for (int j = 0; j < 11; ++j) {
    for (int k = exact.column_start()[j]; k < exact.column_start()[j + 1]; ++k) {
      if (exact.rows()[k] == 9 && j == 9) {
        EXPECT_EQ(exact_entries[k], 0.0) << "no row depends on others";
      }
      EXPECT_LT(std::abs(exact_entries[k] - wanted(exact.rows()[k], j)), 1e-14);
    }
  }

  const Eigen::VectorXd x = Eigen::VectorXd::Random(12);
  Eigen::VectorXd moving = x, y = Eigen::VectorXd::Zero(12);
  moving.tail(3).setZero();
  plan.add_stiffness(values, x.data(), y.data());
  EXPECT_LT((y.head(9) - (dr * moving).head(9)).cwiseAbs().maxCoeff(), 1e-14);
}

}  // namespace
}  // namespace tanor
