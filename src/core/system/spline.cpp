#include "system/spline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>

#include <tanor/error.hpp>

#include "base/text.hpp"

namespace tanor::detail {

namespace {

constexpr int max_degree = 5;

void check_samples(const std::vector<double>& times, const std::vector<double>& values) {
  if (times.size() != values.size()) {
    throw InputError("", "table: " + text_of_count(times.size(), "time") + " but " +
                             text_of_count(values.size(), "value") + "; a row has one of each");
  }
  if (times.size() < 2) {
    throw InputError("", "table: " + text_of_count(times.size(), "row") + "; a table needs at least 2");
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto fail = [&](const std::string& problem) {
      throw InputError("", "table: row " + text(i + 1) + ": " + problem);
    };
    if (!std::isfinite(times[i])) fail("time " + text(times[i]) + " is not finite");
    if (!std::isfinite(values[i])) fail("value " + text(values[i]) + " is not finite");
    if (i > 0 && times[i] <= times[i - 1]) {
      const auto [time, before] = texts_apart(std::array{times[i], times[i - 1]});
      fail("time " + time + " after " + before + "; times must strictly increase");
    }
  }
}

/// B-splines of a degree over a knot sequence (de Boor, A Practical Guide to Splines, chapters IX and X). On the
/// interval [knots[m], knots[m+1]) the basis functions m - degree … m are not zero.
struct Basis {
  int degree;
  std::vector<double> knots;

  /// The ends have multiplicity degree + 1. Inside, all samples but the (degree + 1)/2 - 1 next to each end are knots.
  explicit Basis(std::span<const double> times)
      : degree(std::min<int>(max_degree, static_cast<int>(times.size()) - 1)) {
    knots.assign(degree + 1, times.front());
    constexpr std::size_t skipped = (max_degree + 1) / 2;
    if (times.size() > 2 * skipped) knots.insert(knots.end(), times.begin() + skipped, times.end() - skipped);
    knots.insert(knots.end(), degree + 1, times.back());
  }

  std::size_t first_interval() const { return degree; }
  std::size_t end_interval() const { return knots.size() - degree - 1; }

  std::size_t find_interval(double t) const {
    const auto begin = knots.begin() + first_interval() + 1, end = knots.begin() + end_interval();
    return std::upper_bound(begin, end, t) - knots.begin() - 1;
  }

  /// Returns the values at t of the functions m - degree … m, or their series if t is a jet.
  template <class T>
  std::array<T, max_degree + 1> evaluate(const T& t, std::size_t m) const {
    std::array<T, max_degree + 1> values{T(1.0)};
    for (int p = 1; p <= degree; ++p) {
      // N_{i,p} = (t - k_i)/(k_{i+p} - k_i) N_{i,p-1} + (k_{i+p+1} - t)/(k_{i+p+1} - k_{i+1}) N_{i+1,p-1}
      T carried(0.0);
      for (int j = 0; j < p; ++j) {
        const double left = knots[m + 1 + j - p], right = knots[m + 1 + j];
        const T share = values[j] / (right - left);
        values[j] = carried + (right - t) * share;
        carried = (t - left) * share;
      }
      values[p] = carried;
    }
    return values;
  }
};

/// Returns the coefficients c of sum over i of c_i N_i(times_j) = values_j, a banded system.
Eigen::VectorXd interpolate(const Basis& basis, std::span<const double> times, std::span<const double> values) {
  const auto size = static_cast<Eigen::Index>(times.size());
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(times.size() * (basis.degree + 1));
  for (Eigen::Index row = 0; row < size; ++row) {
    const std::size_t m = basis.find_interval(times[row]);
    const auto functions = basis.evaluate(times[row], m);
    for (int j = 0; j <= basis.degree; ++j) {
      entries.emplace_back(static_cast<int>(row), static_cast<int>(m) - basis.degree + j, functions[j]);
    }
  }
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());

  // The matrix is totally positive and banded, so its own order makes no fill.
  Eigen::SparseLU<Eigen::SparseMatrix<double>, Eigen::NaturalOrdering<int>> factor(matrix);
  const auto fail = [] {
    throw InputError("",
                     "table: its times are too unequal for a smooth curve; wanted steps that do not differ so much");
  };
  if (factor.info() != Eigen::Success) fail();
  Eigen::VectorXd coefficients = factor.solve(Eigen::Map<const Eigen::VectorXd>(values.data(), size));
  if (!coefficients.allFinite()) fail();
  return coefficients;
}

}  // namespace

Spline::Spline(std::vector<double> times, const std::vector<double>& values) {
  check_samples(times, values);
  first_time_ = times.front();
  last_time_ = times.back();

  const Basis basis(times);
  const Eigen::VectorXd coefficients = interpolate(basis, times, values);
  for (std::size_t m = basis.first_interval(); m < basis.end_interval(); ++m) {
    const auto functions = basis.evaluate(Jet<max_degree>::variable(basis.knots[m]), m);
    Jet<max_degree> piece;
    for (int j = 0; j <= basis.degree; ++j) piece += coefficients[m - basis.degree + j] * functions[j];
    pieces_.push_back({basis.knots[m], piece.c});
  }
}

/// Returns the last piece that starts at or before t.
const Spline::Piece& Spline::find_piece(double t) const {
  const double rounding =
      8.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(first_time_), std::abs(last_time_));
  if (!(first_time_ - rounding <= t && t <= last_time_ + rounding)) {
    const auto [time, first, last] = texts_apart(std::array{t, first_time_, last_time_});
    throw InputError("", "t = " + time + " is outside the table, which reaches from " + first + " to " + last);
  }
  return *(std::upper_bound(pieces_.begin() + 1, pieces_.end(), t,
                            [](double time, const Piece& next) { return time < next.start; }) -
           1);
}

Jet<2> Spline::evaluate(double t) const {
  const Piece& piece = find_piece(t);
  const auto distance = Jet<2>::variable(t - piece.start);
  Jet<2> value;
  for (int k = max_degree; k >= 0; --k) value = value * distance + piece.coefficients[k];
  return value;
}

void Spline::expand(double t, std::span<double> coefficients) const {
  const Piece& piece = find_piece(t);
  const auto distance = Jet<max_degree>::variable(t - piece.start);
  Jet<max_degree> value;
  for (int k = max_degree; k >= 0; --k) value = value * distance + piece.coefficients[k];
  for (std::size_t k = 0; k < coefficients.size(); ++k) coefficients[k] = k <= max_degree ? value.c[k] : 0.0;
}

std::optional<std::array<double, 3>> Spline::find_parabola() const {
  // The differences of three values give it; six values of a piece of degree 5 decide whether the piece lies on it.
  const double half = 0.5 * (last_time_ - first_time_);
  const auto value = [this](double t) { return evaluate(t).value(); };
  const double first = value(first_time_), middle = value(first_time_ + half), last = value(last_time_);
  std::array<double, 3> c{first, (4.0 * middle - 3.0 * first - last) / (2.0 * half),
                          (first - 2.0 * middle + last) / (2.0 * half * half)};
  double largest = 0.0, misfit = 0.0;
  for (std::size_t k = 0; k < pieces_.size(); ++k) {
    const double begin = pieces_[k].start, end = k + 1 < pieces_.size() ? pieces_[k + 1].start : last_time_;
    for (int i = 0; i <= max_degree; ++i) {
      const double t = begin + (end - begin) * i / max_degree, s = t - first_time_, x = value(t);
      largest = std::max(largest, std::abs(x));
      misfit = std::max(misfit, std::abs(x - (c[0] + s * (c[1] + s * c[2]))));
    }
  }
  constexpr double rounding = 1e-12;
  if (!(misfit <= rounding * largest)) return {};
  for (std::size_t k = 1; k < c.size(); ++k) {
    if (std::abs(c[k]) * std::pow(2.0 * half, static_cast<double>(k)) <= 8.0 * rounding * largest) c[k] = 0.0;
  }
  return c;
}

double Spline::next_knot(double t) const {
  const Piece* const next = &find_piece(t) + 1;
  return next == pieces_.data() + pieces_.size() ? std::numeric_limits<double>::infinity() : next->start;
}

void Spline::append_knots(double begin, double end, std::vector<double>* knots) const {
  const auto starts_later = [](double time, const Piece& piece) { return time < piece.start; };
  for (auto piece = std::upper_bound(pieces_.begin(), pieces_.end(), begin, starts_later);
       piece != pieces_.end() && piece->start < end; ++piece)
    knots->push_back(piece->start);
}

}  // namespace tanor::detail
