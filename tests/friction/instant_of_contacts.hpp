#pragma once

/// \file One instant of a system with friction, made ready for the tests of its parts.

#include <Eigen/Core>
#include <vector>

#include "base/dense.hpp"
#include "dynamics/contact_response.hpp"
#include "dynamics/workspace.hpp"

namespace tanor {
using namespace detail;

/// Makes beads on lines in space, each joined to the next by a rod, under gravity. All of them slide.
inline System make_beads_on_lines(const std::vector<Vector3>& positions, const std::vector<Vector3>& directions,
                                  double mu) {
  System system;
  Rods rods{"rods", {}, {}, {}};
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      system.positions.push_back(positions[i][k]);
      system.velocities.push_back(directions[i][k]);
    }
    system.masses.push_back(1.0 + 0.5 * static_cast<double>(i));
    lines.push_back("line" + std::to_string(i));
    system.constraints.push_back(Lines{lines.back(), {static_cast<Index>(i)}, positions[i], directions[i]});
    if (i > 0) rods.pairs.push_back({static_cast<Index>(i) - 1, static_cast<Index>(i)});
  }
  if (!rods.pairs.empty()) system.constraints.push_back(rods);
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  system.friction = {Coulomb{.name = "rough", .at = lines, .coefficient = mu}};
  return system;
}

struct InstantOfContacts {
  explicit InstantOfContacts(const System& system)
      : work(system, {}, 0.0),
        r(3 * model.num_points()),
        v(r),
        w0(r),
        b(model.num_rows()),
        blocks(3 * work.constraints.num_blocks()) {
    model.numbering.gather_points(model.system.positions, r);
    model.numbering.gather_points(model.system.velocities, v);
    work.set_time(0.0);
    work.constraints.choose_frames();
    work.constraints.evaluate_gradients(model.parallel, r.data(), blocks.data());
    work.measure_velocity_scale(0.0, r.data(), v.data());
    (void)work.evaluate_free(0.0, r.data(), v.data(), w0.data());
    work.constraints.evaluate_right_side(model.parallel, r.data(), v.data(), w0.data(), b.data(), blocks.data());
  }

  /// Returns K [3n][rows].
  Eigen::MatrixXd K() const {
    Eigen::MatrixXd result =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(r.size()), static_cast<Eigen::Index>(b.size()));
    for (const Incidence& i : model.incidences) {
      const Vec3 g = load(blocks.data(), i.block);
      result.block<3, 1>(3 * i.point, i.row) += i.sign * Eigen::Vector3d(g.x, g.y, g.z);
    }
    return result;
  }
  /// Returns the diagonal of M^-1, [3n].
  Eigen::VectorXd inverse_mass() const {
    Eigen::VectorXd result(static_cast<Eigen::Index>(r.size()));
    for (Eigen::Index i = 0; i < result.size(); ++i) result(i) = model.inverse_mass[static_cast<std::size_t>(i / 3)];
    return result;
  }
  /// Returns S = K'M^-1 K, with 1 for the rows of contacts that slide, which have no gradient.
  Eigen::MatrixXd S() const {
    Eigen::MatrixXd result = K().transpose() * inverse_mass().asDiagonal() * K();
    for (Eigen::Index a = 0; a < result.rows(); ++a) {
      if (result(a, a) == 0.0) result(a, a) = 1.0;
    }
    return result;
  }

  Workspace work;
  const Model& model{work.model()};
  std::vector<double> r, v, w0;  // [3n]
  std::vector<double> b;         // [rows] phi + K'w0
  std::vector<double> blocks;
};

/// Solves S x = -b by a dense factor.
class DenseResponse final : public ContactResponse {
 public:
  explicit DenseResponse(const InstantOfContacts& at)
      : factor_(at.S()), M_inverse_K_(at.inverse_mass().asDiagonal() * at.K()) {}

  void solve_once(const double* b, double* x) override { solve_refined(b, x, nullptr); }
  void solve_refined(const double* b, double* x, double* dw) override {
    ++num_solves;
    const Eigen::VectorXd lambda = -factor_.solve(Eigen::Map<const Eigen::VectorXd>(b, M_inverse_K_.cols()));
    Eigen::Map<Eigen::VectorXd>(x, lambda.size()) = lambda;
    if (dw != nullptr) Eigen::Map<Eigen::VectorXd>(dw, M_inverse_K_.rows()) = M_inverse_K_ * lambda;
  }
  void minimize_multiplier_norm(double*) override {}

  int num_solves = 0;

 private:
  dense::Lu factor_;
  Eigen::MatrixXd M_inverse_K_;
};

}  // namespace tanor
