#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include "evaluate/charts.hpp"
#include "evaluate/coordinate_family.hpp"

namespace tanor::detail {

/// Coordinates of rigid bodies, q = (c, theta), with r_p = c + R(theta) rho_p and rho measured from the centre of mass.
/// With y = R rho, v = c' + omega x y and psi = omega x (omega x y) + alpha x y.
///
/// A body's part of H = A'MA needs no sum over its points, since sum m rho = 0 and sum m |a x rho|^2 = |Q a|^2 for any
/// a, where Q is a root of its tensor of inertia, Q'Q = J. Three more blocks, Q R'axis_j, make its 9 products.
class BodyCoordinates final : public CoordinateFamily {
 public:
  using Group = RigidBody;

  std::vector<Index> points;          ///< inner, body after body
  std::vector<Index> point_start{0};  ///< [body + 1]
  std::vector<Vec3> rho;              ///< beside `points`, m, in the body's frame
  std::vector<double> mass;           ///< beside `points`, kg
  std::vector<RotationChart> chart;   ///< [body]
  std::vector<double> total_mass;     ///< [body] kg
  std::vector<Eigen::Matrix3d> root;  ///< [body] Q, kg^1/2 m

  static bool takes(const RigidBody&) { return true; }
  void add(const RigidBody& group, const CoordinateStart& start) {
    const auto mass_of = [&](Index point) { return start.system.masses[static_cast<std::size_t>(point)]; };
    Vec3 centre{};
    double total = 0.0;
    for (const Index point : group.points) {
      centre = centre + mass_of(point) * start.place(point);
      total += mass_of(point);
    }
    centre = (1.0 / total) * centre;
    // J = sum m (|rho|^2 I - rho rho')
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
    for (const Index point : group.points) {
      const Vec3 arm = start.place(point) - centre;
      const Eigen::Vector3d a(arm.x, arm.y, arm.z);
      inertia += mass_of(point) * (a.squaredNorm() * Eigen::Matrix3d::Identity() - a * a.transpose());
      points.push_back(start.inner(point));
      rho.push_back(arm);
      mass.push_back(mass_of(point));
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(inertia);
    root.push_back(eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose());
    total_mass.push_back(total);
    point_start.push_back(static_cast<Index>(points.size()));
    chart.emplace_back();
  }

  std::size_t size() const override { return chart.size(); }
  Index num_coordinates() const override { return 6 * static_cast<Index>(size()); }
  Index num_blocks() const override { return 3 + 3 * static_cast<Index>(points.size() + size()); }
  Index first_coordinate_of(std::size_t k) const override { return first_coordinate + 6 * static_cast<Index>(k); }
  bool depends_on_time() const override { return false; }
  void set_time(double) override {}

  void evaluate(const Parallel& parallel, const double* q, const double* q_dot, double* r, double* v, double* psi,
                double* blocks) const override {
    if (blocks != nullptr) {
      for (int j = 0; j < 3; ++j) store(blocks, first_block + j, unit(j));
    }
    for_bodies(parallel, [&](std::size_t k, Index begin, Index end) {
      const double* const x = q + first_coordinate_of(k);
      const double* const x_dot = q_dot + first_coordinate_of(k);
      const RotationChart::Value now = chart[k](x + 3, x_dot + 3);
      if (blocks != nullptr) {
        for (int j = 0; j < 3; ++j) {
          const Eigen::Vector3d axis(now.axis[j].x, now.axis[j].y, now.axis[j].z);
          const Eigen::Vector3d turned = root[k] * (now.rotation.transpose() * axis);
          store(blocks, inertia_block(k) + j, Vec3{turned[0], turned[1], turned[2]});
        }
      }
      for (Index p = begin; p < end; ++p) {
        const Eigen::Vector3d rotated = now.rotation * Eigen::Vector3d(rho[p].x, rho[p].y, rho[p].z);
        const Vec3 y{rotated[0], rotated[1], rotated[2]};
        store(r, points[p], load(x, 0) + y);
        const Vec3 turning = cross(now.omega, y);
        if (v != nullptr) store(v, points[p], load(x_dot, 0) + turning);
        if (psi != nullptr) store(psi, points[p], cross(now.omega, turning) + cross(now.alpha, y));
        if (blocks == nullptr) continue;
        for (int j = 0; j < 3; ++j) store(blocks, block(p) + j, cross(now.axis[j], y));
      }
    });
  }

  void apply(const Parallel& parallel, const double* blocks, const double* x, double* y) const override {
    for_bodies(parallel, [&](std::size_t k, Index begin, Index end) {
      const double* const at = x + first_coordinate_of(k);
      for (Index p = begin; p < end; ++p) {
        Vec3 sum = load(at, 0);
        for (int j = 0; j < 3; ++j) sum = sum + at[3 + j] * load(blocks, block(p) + j);
        store(y, points[p], sum);
      }
    });
  }

  void apply_transposed(const Parallel& parallel, const double* blocks, const double* y, double* x) const override {
    for_bodies(parallel, [&](std::size_t k, Index begin, Index end) {
      Vec3 force{};
      double torque[3] = {0.0, 0.0, 0.0};
      for (Index p = begin; p < end; ++p) {
        const Vec3 at = load(y, points[p]);
        force = force + at;
        for (int j = 0; j < 3; ++j) torque[j] += dot(load(blocks, block(p) + j), at);
      }
      double* const out = x + first_coordinate_of(k);
      store(out, 0, force);
      for (int j = 0; j < 3; ++j) out[3 + j] = torque[j];
    });
  }

  void append_products(const std::vector<double>& weights, std::vector<Product>* products) const override {
    for (std::size_t k = 0; k < size(); ++k) {
      const Index row = first_coordinate_of(k);
      if (are_masses(weights, k)) {
        for (Index i = 0; i < 3; ++i) {
          products->push_back({row + i, row + i, first_block + i, first_block + i, total_mass[k]});
        }
        for (Index i = 0; i < 3; ++i) {
          for (Index j = 0; j <= i; ++j) {
            products->push_back({row + 3 + i, row + 3 + j, inertia_block(k) + i, inertia_block(k) + j, 1.0});
          }
        }
        continue;
      }
      for (Index p = point_start[k]; p < point_start[k + 1]; ++p) {
        const double weight = weights[static_cast<std::size_t>(points[p])];
        for (Index i = 0; i < 6; ++i) {
          for (Index j = i < 3 ? i : 0; j <= i; ++j) {  // unit vectors are orthogonal
            products->push_back({row + i, row + j, block_of(i, p), block_of(j, p), weight});
          }
        }
      }
    }
  }

  /// Finds the rotation that brings rho nearest to r in the metric of the masses (Kabsch 1976).
  void locate(const double* r, double* q) override {
    for (std::size_t k = 0; k < size(); ++k) {
      Vec3 centre{};
      double total = 0.0;
      for (Index p = point_start[k]; p < point_start[k + 1]; ++p) {
        centre = centre + mass[p] * load(r, points[p]);
        total += mass[p];
      }
      centre = (1.0 / total) * centre;
      Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
      for (Index p = point_start[k]; p < point_start[k + 1]; ++p) {
        const Vec3 y = load(r, points[p]) - centre;
        covariance += mass[p] * Eigen::Vector3d(y.x, y.y, y.z) * Eigen::RowVector3d(rho[p].x, rho[p].y, rho[p].z);
      }
      const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
      const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
      const Eigen::Matrix3d rotation =
          svd.matrixU() * Eigen::Vector3d(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose();
      chart[k] = RotationChart(Eigen::Quaterniond(rotation));
      store(q + first_coordinate_of(k), 0, centre);
      store(q + first_coordinate_of(k), 1, Vec3{});
    }
  }

  bool has_charts() const override { return true; }
  void exchange_memory(Memory& memory) override {
    for (auto& each : chart) each.exchange_memory(memory);
  }
  void recentre(double, double* q, double* q_dot, double* q_ddot) override {
    for (std::size_t k = 0; k < size(); ++k) {
      const Index theta = first_coordinate_of(k) + 3;
      chart[k].recentre(q + theta, q_dot + theta, q_ddot + theta);
    }
  }

 private:
  static Vec3 unit(int j) { return {j == 0 ? 1.0 : 0.0, j == 1 ? 1.0 : 0.0, j == 2 ? 1.0 : 0.0}; }
  bool are_masses(const std::vector<double>& weights, std::size_t k) const {
    for (Index p = point_start[k]; p < point_start[k + 1]; ++p) {
      if (weights[static_cast<std::size_t>(points[p])] != mass[p]) return false;
    }
    return true;
  }

  // The blocks are three unit vectors for all translations, then three for each point, then three for each body.
  Index inertia_block(std::size_t k) const {
    return first_block + 3 + 3 * static_cast<Index>(points.size()) + 3 * static_cast<Index>(k);
  }
  Index block(Index p) const { return first_block + 3 + 3 * p; }
  Index block_of(Index i, Index p) const { return i < 3 ? first_block + i : block(p) + i - 3; }

  template <class Body>
  void for_bodies(const Parallel& parallel, const Body& body) const {
    for_members(parallel, points.size(), [&](std::size_t k) { body(k, point_start[k], point_start[k + 1]); });
  }
};

}  // namespace tanor::detail
