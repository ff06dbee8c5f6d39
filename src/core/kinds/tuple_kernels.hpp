#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include <tanor/kinds/constraint/formula.hpp>
#include <tanor/kinds/constraint/linear.hpp>
#include <tanor/kinds/constraint/rope.hpp>

#include "base/index_ranges.hpp"
#include "base/vec3.hpp"
#include "kinds/kernel.hpp"
#include "kinds/tables.hpp"
#include "system/tuples.hpp"

/// \file Constraints with one row on tuples of any size. A kernel has evaluate(parallel, members, r, v, take), which
/// calls take(k, row) for each member k, where the row tells xi, rate, phi and norm, the length of the gradient, and
/// gradient() [3p]. v may be null unless rate or phi is asked for. Returns the largest number that `take` returns.
namespace tanor::detail {

/// The points of all members, one tuple after the other.
struct Tuples {
  static constexpr bool unit_gradient = false;

  std::vector<Index> start{0};  ///< [member + 1] first of its points
  std::vector<Index> points;
  std::vector<double> size;  ///< [member] m, of the neighbourhood

  double scale(std::size_t k) const { return size[k]; }
  std::span<const Index> tuple(std::size_t k) const {
    return std::span(points).subspan(static_cast<std::size_t>(start[k]),
                                     static_cast<std::size_t>(start[k + 1] - start[k]));
  }
  /// Returns the gradient [3p] of member k times x at its points.
  double transposed(std::size_t k, const double* gradient, const double* x) const {
    double sum = 0.0;
    for (Index i = start[k]; i < start[k + 1]; ++i) sum += dot(load(gradient, i - start[k]), load(x, points[i]));
    return sum;
  }
  void append_tuple(std::span<const Index> inner_points, double length) {
    points.insert(points.end(), inner_points.begin(), inner_points.end());
    start.push_back(static_cast<Index>(points.size()));
    size.push_back(length);
  }
};

/// xi is the sum over the tuple of c.r, minus the value. Gradients are constant.
struct LinearKernel : Tuples {
  using Group = Linears;

  std::vector<Vec3> coefficients;  ///< beside `points`
  std::vector<double> norms;       ///< [member] largest |c| of its tuple
  ScalarTable value;               ///< [member]

  void set_time(double t) { value.set_time(t); }
  bool depends_on_time() const { return !value.is_constant(); }
  static bool gradients_are_constant() { return true; }

  void add_member(const Linears& linears) {
    double norm2 = 0.0;
    for (const Vector3& coefficient : linears.coefficients) {
      coefficients.push_back(make_vec3(coefficient));
      norm2 = std::max(norm2, dot(coefficients.back(), coefficients.back()));
    }
    norms.push_back(std::sqrt(norm2));
  }

  double norm(std::size_t k, const double*) const { return norms[k]; }
  double squared_norm(std::size_t k, std::size_t p) const {
    const Vec3& c = coefficients[static_cast<std::size_t>(start[k]) + p];
    return dot(c, c);
  }

  struct Row {
    const LinearKernel& kernel;
    std::size_t k;
    const double *r, *v;

    double xi() const { return kernel.transposed(k, gradient(), r) - kernel.value[k].value; }
    double rate() const { return kernel.transposed(k, gradient(), v) - kernel.value[k].first; }
    double phi() const { return -kernel.value[k].second; }
    double norm() const { return kernel.norms[k]; }
    const double* gradient() const { return &kernel.coefficients[static_cast<std::size_t>(kernel.start[k])].x; }
  };
  template <class Take>
  double evaluate(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
                  const Take& take) const {
    return members.max_over_ranges(parallel, [&](std::size_t begin, std::size_t end) {
      double worst = 0.0;
      for (std::size_t k = begin; k < end; ++k) worst = larger(worst, take(k, Row{*this, k, r, v}));
      return worst;
    });
  }
};

/// xi = sum over the segments of a path of c |r_p - r_{p-1}|, minus the length.
struct RopeKernel : Tuples {
  using Group = Ropes;

  std::vector<double> coefficients;     ///< beside `points`: of the segment that ends there
  std::vector<double> norms;            ///< [member] largest coefficient
  ScalarTable length;                   ///< [member]
  mutable std::vector<Vec3> gradients;  ///< beside `points`; each member writes its own

  void set_time(double t) { length.set_time(t); }
  bool depends_on_time() const { return !length.is_constant(); }
  static bool gradients_are_constant() { return false; }
  double scale(std::size_t k) const { return length[k].value; }
  double norm(std::size_t k, const double*) const { return norms[k]; }

  /// Call this behind append_tuple.
  void add_member(const Ropes& ropes) {
    double largest = ropes.coefficients.empty() ? 1.0 : 0.0;
    for (std::size_t p = coefficients.size(); p < points.size(); ++p) {
      const std::size_t end = p - static_cast<std::size_t>(start[start.size() - 2]);
      coefficients.push_back(ropes.coefficients.empty() || end == 0 ? 1.0 : ropes.coefficients[end - 1]);
      if (end > 0) largest = std::max(largest, coefficients.back());
    }
    norms.push_back(largest);
    gradients.resize(points.size());
  }

  struct Row {
    const RopeKernel& kernel;
    std::size_t k;
    double value, first, second;  // of the sum

    double xi() const { return value - kernel.length[k].value; }
    double rate() const { return first - kernel.length[k].first; }
    double phi() const { return second - kernel.length[k].second; }
    double norm() const { return kernel.norms[k]; }
    const double* gradient() const { return &kernel.gradients[static_cast<std::size_t>(kernel.start[k])].x; }
  };
  Row row(std::size_t k, const double* r, const double* v) const {
    Row row{*this, k, 0.0, 0.0, 0.0};
    const auto begin = static_cast<std::size_t>(start[k]), end = static_cast<std::size_t>(start[k + 1]);
    gradients[begin] = {};
    for (std::size_t p = begin + 1; p < end; ++p) {
      const double c = coefficients[p];
      const Distance segment(load(r, points[p]) - load(r, points[p - 1]), load(v, points[p]) - load(v, points[p - 1]));
      row.value += c * segment.value;
      row.first += c * segment.first;
      row.second += c * segment.second;
      gradients[p - 1] = gradients[p - 1] - c * segment.unit;
      gradients[p] = c * segment.unit;
    }
    return row;
  }
  template <class Take>
  double evaluate(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
                  const Take& take) const {
    return members.max_over_ranges(parallel, [&](std::size_t begin, std::size_t end) {
      double worst = 0.0;
      for (std::size_t k = begin; k < end; ++k) worst = larger(worst, take(k, row(k, r, v != nullptr ? v : r)));
      return worst;
    });
  }
};

/// The members [first, last) of one group of user constraints, whose tuples have one size.
struct UserGroup {
  ConstraintKernel kernel;
  std::size_t first, last;
};

/// User constraints, where a kernel is called once for some dozens of members.
struct UserKernels : Tuples {
  using Group = UserConstraints;

  std::vector<UserGroup> groups;
  double t = 0.0;

  void set_time(double time) { t = time; }
  bool depends_on_time() const {
    return std::ranges::any_of(groups, [](const UserGroup& group) { return group.kernel.depends_on_time; });
  }
  static bool gradients_are_constant() { return false; }

  /// Returns the length of a gradient. Ratios to it stay finite where xi has no gradient, so that a violation of 0
  /// counts as none.
  double norm(std::size_t k, const double* gradient) const {
    return std::max(largest_block(gradient, 3 * tuple(k).size()), std::numeric_limits<double>::min());
  }

  struct Row {
    const UserKernels& kernel;
    const TupleValues& values;
    std::size_t k, i;  // among all members, and among the values

    double xi() const { return values.xi[i]; }
    double rate() const { return values.rate[i]; }
    double phi() const { return values.phi[i]; }
    double norm() const { return kernel.norm(k, gradient()); }
    const double* gradient() const { return values.gradient + i * values.size; }
  };
  template <class Take>
  double evaluate(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
                  const Take& take) const {
    const Parallel serial(1);
    double worst = 0.0;
    for (const UserGroup& group : groups) {
      const std::span own = std::span(points).subspan(static_cast<std::size_t>(start[group.first]));
      const auto evaluate_range = [&](std::size_t begin, std::size_t end) {
        double part = 0.0;
        for_each_chunk(group.kernel, own, begin - group.first, end - group.first, t, r, v,
                       [&](const TupleValues& values) {
                         for (std::size_t i = 0; i < values.count; ++i) {
                           const std::size_t k = group.first + values.first + i;
                           part = larger(part, take(k, Row{*this, values, k, i}));
                         }
                       });
        return part;
      };
      const Parallel& loop = group.kernel.thread_safe ? parallel : serial;
      worst = larger(worst, members.max_over_ranges(loop, group.first, group.last, evaluate_range));
    }
    return worst;
  }
};

}  // namespace tanor::detail
