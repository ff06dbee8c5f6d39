#include "dynamics/light_points.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/dense.hpp"
#include "base/groups.hpp"
#include "base/numbers.hpp"

namespace tanor::detail {

namespace {

constexpr double light = 1e-16;  // beside the heaviest point of each of its rows

/// Returns false if no point is light beside any other, as in nearly all systems.
bool may_have_light_points(const Model& model) {
  double least = std::numeric_limits<double>::infinity(), largest = 0.0;
  for (const Incidence& incidence : model.incidences) {
    const double inverse_mass = model.inverse_mass[static_cast<std::size_t>(incidence.point)];
    least = std::min(least, inverse_mass);
    largest = std::max(largest, inverse_mass);
  }
  return least < light * largest;
}

/// The rows of each point, as places in the incidences, for light points alone.
Groups<std::size_t> list_light_points(const Model& model) {
  std::vector<double> least_inverse(model.num_rows(), std::numeric_limits<double>::infinity());
  const auto inverse_mass = [&](const Incidence& incidence) {
    return model.inverse_mass[static_cast<std::size_t>(incidence.point)];
  };
  for (const Incidence& incidence : model.incidences) {
    double& least = least_inverse[static_cast<std::size_t>(incidence.row)];
    least = std::min(least, inverse_mass(incidence));
  }
  std::vector<char> is_light(model.num_points(), 1);
  for (const Incidence& incidence : model.incidences) {
    const double others = least_inverse[static_cast<std::size_t>(incidence.row)];
    if (!(others < light * inverse_mass(incidence))) is_light[static_cast<std::size_t>(incidence.point)] = 0;
  }
  return {model.num_points(), [&](const auto& add) {
            for (std::size_t k = 0; k < model.incidences.size(); ++k) {
              const Index point = model.incidences[k].point;
              if (is_light[static_cast<std::size_t>(point)] != 0) add(point, k);
            }
          }};
}

/// Returns the smallest x that minimizes the sum of (g'x + r)^2, by its normal equations; repeated, it is accurate.
Vec3 solve_point(const Eigen::Matrix3d& normal, const Eigen::Vector3d& right) {
  constexpr double rounding = 1e-13;
  const auto [values, vectors] = dense::find_eigen(normal);
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (values(k) > rounding * values(2)) x += vectors.col(k).dot(right) / values(k) * vectors.col(k);
  }
  return {x(0), x(1), x(2)};
}

}  // namespace

bool settle_light_points(const Model& model, const double* blocks, double* rows, double* dw) {
  constexpr int most_sweeps = 50;
  if (!may_have_light_points(model)) return false;
  const Groups<std::size_t> by_point = list_light_points(model);
  if (by_point.entries.empty()) return false;
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    bool has_changed = false;
    for (std::size_t i = 0; i < by_point.size(); ++i) {
      if (by_point[i].empty()) continue;
      Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
      Eigen::Vector3d right = Eigen::Vector3d::Zero();
      const auto gradient = [&](std::size_t k) {
        const Incidence& incidence = model.incidences[k];
        return incidence.sign * load(blocks, incidence.block);
      };
      for (const std::size_t k : by_point[i]) {
        const Vec3 g = gradient(k);
        const Eigen::Vector3d own(g.x, g.y, g.z);
        normal += own * own.transpose();
        right -= rows[model.incidences[k].row] * own;
      }
      const Vec3 change = solve_point(normal, right);
      add_to(dw, i, change);
      for (const std::size_t k : by_point[i]) rows[model.incidences[k].row] += dot(gradient(k), change);
      has_changed = has_changed || norm(change) > eps * norm(load(dw, i));
    }
    if (!has_changed) break;
  }
  return true;
}

}  // namespace tanor::detail
