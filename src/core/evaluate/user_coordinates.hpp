#pragma once

#include <cmath>

#include <tanor/kernel.hpp>

#include "base/dense.hpp"
#include "evaluate/coordinate_family.hpp"

namespace tanor::detail {

/// A user's map from s coordinates to p points, with one kernel and one loop.
class UserCoordinateFamily final : public CoordinatesOfMembers<UserCoordinateFamily, CoordinateFamily> {
 public:
  using Group = UserCoordinates;
  static constexpr bool is_of_one_group = true;

  CoordinateKernel kernel;
  std::vector<double> q_start, q_dot_start;  ///< [member][s]

  static bool takes(const UserCoordinates&) { return true; }
  void add(const UserCoordinates& group, const CoordinateStart& start) {
    kernel = group.kernel;
    for (const auto& tuple : group.tuples) {
      for (const Index point : tuple) points.push_back(start.inner(point));
    }
    q_start = group.q;
    q_dot_start = group.q_dot;
    q_dot_start.resize(group.q.size(), 0.0);
  }

  std::size_t points_per_member() const { return static_cast<std::size_t>(kernel.num_points); }
  std::size_t coordinates_per_member() const { return static_cast<std::size_t>(kernel.num_coordinates); }
  bool depends_on_time() const override { return kernel.depends_on_time; }
  void set_time(double t) override { t_ = t; }

  void evaluate(const Parallel& parallel, const double* q, const double* q_dot, double* r, double* v, double* psi,
                double* blocks) const override {
    const std::size_t width = 3 * points_per_member();
    const auto evaluate_range = [&](std::size_t first, std::size_t last) {
      // Coordinates of members lie side by side, as the kernel wants them; points are scattered from chunks.
      constexpr std::size_t chunk = 32;
      thread_local std::vector<double> places, rates, seconds;  // kept: no allocation in a steady step
      for (std::vector<double>* array : {&places, &rates, &seconds}) {
        if (array->size() < chunk * width) array->resize(chunk * width);
      }
      for (std::size_t begin = first; begin < last; begin += chunk) {
        const std::size_t count = std::min(chunk, last - begin);
        const auto own = static_cast<std::size_t>(first_coordinate_of(begin));
        const bool rates_too = v != nullptr || psi != nullptr;
        kernel.evaluate(kernel.context.get(), {count, t_, q + own, q_dot + own, places.data(),
                                               rates_too ? rates.data() : nullptr, rates_too ? seconds.data() : nullptr,
                                               blocks != nullptr ? blocks + 3 * block(begin) : nullptr});
        for (std::size_t i = 0; i < count * points_per_member(); ++i) {
          const Index point = points[begin * points_per_member() + i];
          store(r, point, load(places.data(), i));
          if (v != nullptr) store(v, point, load(rates.data(), i));
          if (psi != nullptr) store(psi, point, load(seconds.data(), i));
        }
      }
    };
    if (kernel.thread_safe) {
      parallel.for_ranges(size(), evaluate_range, 256);
    } else {
      evaluate_range(0, size());
    }
  }

  /// Searches near the given q. If that leads nowhere, takes the best of searches from other places around it.
  void locate(const double* r, double* q) override {
    const auto rows = static_cast<Eigen::Index>(3 * points_per_member()),
               columns = static_cast<Eigen::Index>(coordinates_per_member());
    Eigen::VectorXd wanted(rows), own(columns), other(columns);
    for (std::size_t k = 0; k < size(); ++k) {
      for (std::size_t p = 0; p < points_per_member(); ++p) {
        store(wanted.data(), p, load(r, points[k * points_per_member() + p]));
      }
      Eigen::Map<Eigen::VectorXd> given(q + first_coordinate_of(k), columns);
      own = given;
      double best = approach(wanted, &own);
      constexpr int most_searches = 24;
      for (int search = 1; search <= most_searches && best > 0.01; ++search) {
        // The distance left is large relative to the tangents times |q| + 1. Multiples of the golden ratio's powers
        // give other places, which fill a box evenly.
        for (Eigen::Index j = 0; j < columns; ++j) {
          const double turns = search * std::pow(0.6180339887498949, static_cast<double>(j + 1));
          other[j] =
              given[j] + (1.0 + 0.25 * search) * (1.0 + std::abs(given[j])) * (2.0 * (turns - std::floor(turns)) - 1.0);
        }
        const double found = approach(wanted, &other);
        if (found < best) {
          best = found;
          own = other;
        }
      }
      given = own;
    }
  }

  bool has_charts() const override { return false; }
  void recentre(double, double*, double*, double*) override {}
  void exchange_memory(Memory&) override {}

  /// Writes the start that the user gave.
  void write_start(double* q, double* q_dot) const {
    std::copy(q_start.begin(), q_start.end(), q + first_coordinate);
    std::copy(q_dot_start.begin(), q_dot_start.end(), q_dot + first_coordinate);
  }
  /// Copies `from` to `to` at the family's points [3n].
  void copy_where_given(const double* from, double* to) const {
    for (const Index point : points) store(to, point, load(from, point));
  }

 private:
  /// Runs Gauss-Newton from q, and halves a step that leads away. Returns the distance that is left, over |tangents|
  /// (|q| + 1).
  double approach(const Eigen::VectorXd& wanted, Eigen::VectorXd* q) const {
    Eigen::VectorXd place(wanted.size()), trial(q->size()), step(q->size());
    Eigen::MatrixXd tangents(wanted.size(), q->size());
    const auto miss = [&](const double* at, bool with_tangents) {
      kernel.evaluate(kernel.context.get(),
                      {1, t_, at, at, place.data(), nullptr, nullptr, with_tangents ? tangents.data() : nullptr});
      return (wanted - place).norm();
    };
    constexpr int most_iterations = 50;
    double left = miss(q->data(), true);
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
      step = dense::solve_by_qr(tangents, wanted - place);
      if (!step.allFinite() || step.norm() <= 1e-16 * (1.0 + q->norm())) break;
      double length = 1.0;
      for (; length > 1e-3; length *= 0.5) {
        trial = *q + length * step;
        if (miss(trial.data(), false) < left) break;
      }
      if (length <= 1e-3) break;
      *q = trial;
      left = miss(q->data(), true);
    }
    return left / (tangents.norm() * (1.0 + q->norm()));
  }

  double t_ = 0.0;
};

}  // namespace tanor::detail
