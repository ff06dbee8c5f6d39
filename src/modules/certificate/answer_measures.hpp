#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/numbers.hpp"
#include "certificate/certificate.hpp"

namespace tanor::detail {

// ---- repeated corrections ----

/// Repeats pass(), which corrects and returns the size of its correction, until nothing is gained.
template <class Pass>
void repeat(int most, const Pass& pass) {
  double before = std::numeric_limits<double>::infinity();
  for (int k = 0; k < most; ++k) {
    const double size = pass();
    if (!(size < 0.5 * before)) break;
    before = size;
  }
}

/// Returns what one solve with a matrix of this reciprocal condition may lose.
inline double conditioned(double reciprocal_condition) {
  return std::max(1e-11, 1e3 * eps / reciprocal_condition);
}
/// Returns the same after one refinement.
inline double refined(double reciprocal_condition) {
  return std::max(1e-9, 10.0 * eps / reciprocal_condition);
}
/// Returns how often a solve is repeated on its residual: once if one solve proves nine digits, otherwise until nothing
/// is gained. Masses that differ by 1e9 leave a solve with S no digits, but refinement recovers them.
inline int most_passes(double reciprocal_condition) {
  return conditioned(reciprocal_condition) <= 1e-9 ? 1 : 10;
}

/// Measures errors of an answer: relative to which scales, in which order, and how much of them is rounding.
class AnswerMeasures {
 public:
  using Vector = std::vector<double>;

  AnswerMeasures(Forms& forms, const Answer& answer);

  /// The largest of some relative errors, and where it was.
  struct Worst {
    double error = 0.0;
    std::size_t index = 0;

    void see(double value, std::size_t i) {
      if (!(value <= error)) {
        error = value;
        index = i;
      }
    }
  };

  /// Returns the worst of the moving points, where measure(i) is the error of one.
  template <class Measure>
  Worst worst_of_points(const Measure& measure) const {
    Worst worst;
    for (std::size_t i = 0; i < model_.num_moving(); ++i) worst.see(measure(i), i);
    return worst;
  }
  /// Returns the worst point, relative to one scale.
  Worst worst_point(const Vector& difference, double scale) const {
    return worst_of_points([&](std::size_t i) { return norm(load(difference.data(), i)) / scale; });
  }
  /// Returns the worst point, each relative to the scale of its own neighbourhood, so that a fast point hides no other.
  Worst worst_point(const Vector& difference, const Vector& scale) const {
    return worst_of_points([&](std::size_t i) { return norm(load(difference.data(), i)) / at_point(scale, i); });
  }
  /// Returns the worst point of M^1/2 times the difference, relative to one scale.
  Worst worst_point_by_M(const Vector& difference, double scale) const {
    return worst_of_points(
        [&](std::size_t i) { return std::sqrt(model_.mass[i]) * norm(load(difference.data(), i)) / scale; });
  }
  double speed_at(std::size_t point) const { return work_.scales.speed(work_.scales.of_point(point)); }
  double at_point(const Vector& scale, std::size_t point) const { return scale[work_.scales.of_point(point)]; }
  Vector to_user(const Vector& inner) const;
  /// Returns [rows] from the user's [d]; rows of contacts are 0.
  Vector inner_rows(const Vector& user) const;

  /// Returns the sum of m x y over the moving points.
  double product(const Vector& x, const Vector& y) const;
  double norm_of(const Vector& x) const;
  /// Returns the rounding of directions, which are differences of positions: eps |r|/L, or more across nearly straight
  /// angles.
  double rounding_of_places() const;

 protected:
  bool is_users(std::size_t inner_row) const { return user_row(inner_row) < d_; }
  std::size_t user_row(std::size_t inner_row) const {
    return static_cast<std::size_t>(model_.numbering.user_row[inner_row]);
  }

  /// Projects u along K: repeats x = -(K'WK)^-1 (K'u + phi), u += W K x. `solve` replaces K'u + phi [rows] by x; phi
  /// may be null. Adds x to `lambda` unless that is null.
  template <class Solve>
  void project(const Vector& K, const Vector& weights, const double* phi, int most, const Solve& solve, Vector* u,
               Vector* lambda = nullptr) const {
    Vector rows(num_rows_), change(n_, 0.0);
    repeat(most, [&] {
      work_.constraints.apply_transposed(model_.parallel, K.data(), u->data(), phi, rows.data());
      solve(rows.data());
      for (std::size_t a = 0; lambda != nullptr && a < num_rows_; ++a) (*lambda)[a] += rows[a];
      model_.gather.write_scaled(model_.parallel, K.data(), rows.data(), weights.data(), model_.num_moving(),
                                 change.data());
      for (std::size_t i = 0; i < moving_; ++i) (*u)[i] += change[i];
      return norm_of(change);
    });
  }

  Forms& forms_;
  Workspace& work_;
  const Model& model_;
  const Answer& answer_;
  const std::size_t n_, moving_, d_, num_rows_;  // d_: the user's rows; num_rows_: with those of contacts

 private:
  double measure_angles() const;

  double inverse_sine_ = 1.0;  // see `measure_angles`
};

}  // namespace tanor::detail
