#pragma once

#include <array>
#include <concepts>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tanor/export.hpp>
#include <tanor/expression.hpp>
#include <tanor/jet.hpp>

namespace tanor {

using Vector3 = std::array<double, 3>;

/// Named constants of formulas, `{"omega": 3.0}`.
using Constants = std::map<std::string, double, std::less<>>;

/// A number that may depend on time, with its first two derivatives. Immutable and cheap to copy.
class TANOR_API ScalarFunction {
 public:
  static constexpr int largest_order = 24;  ///< higher derivatives are not asked for

  ScalarFunction(double constant = 0.0);  // NOLINT(google-explicit-constructor): a constant is a function
  /// Makes a function from text in `t`, `pi` and the given constants, e.g. "0.1*sin(omega*t)".
  /// Throws InputError naming the position inside the text.
  static ScalarFunction formula(std::string_view text, const Constants& constants = {});
  /// Makes the C4 interpolation of samples. `times` are strictly increasing and at least 2. An evaluation outside the
  /// table throws InputError.
  static ScalarFunction table(std::vector<double> times, std::vector<double> values);
  // clang-format off
  /// Makes a function from a user's own one, written over jets (`[](auto t) { return sin(3.0 * t); }` fits). One that
  /// also takes Traced is recorded.
  template <class Function>
    requires std::invocable<const Function&, const Jet<largest_order>&>
  static ScalarFunction custom(Function function) {
    std::shared_ptr<const Expression> recorded;
    if constexpr (std::invocable<const Function&, const Traced&>)
      recorded = record_expression(1, [&](const std::vector<Traced>& t) { return std::vector<Traced>{function(t[0])}; });
    return custom(std::function<Jet<2>(const Jet<2>&)>(function), SeriesFunction(function), std::move(recorded));
  }
  // clang-format on
  /// The same for a function that runs on Jet<2> alone, which has no series.
  static ScalarFunction custom(std::function<Jet<2>(const Jet<2>&)> function) {
    return custom(std::move(function), {}, nullptr);
  }

  bool is_constant() const { return source_ == nullptr; }
  /// Returns the Taylor coefficients at t: value(), derivative(1), derivative(2).
  Jet<2> operator()(double t) const;

  /// Writes the Taylor coefficients 0 … P at t, at most `largest_order` + 1 numbers. Returns false if they are not
  /// known (a custom function).
  bool expand(double t, std::span<double> coefficients) const;
  /// Returns the function as recorded operations on t; null if it is not known for all times: a custom function that
  /// was not recorded, or a table whose numbers lie on no parabola.
  std::shared_ptr<const Expression> expression() const;
  /// Returns the time after t, s, at which the next piece of a table begins, infinity if there is none. The series at t
  /// does not hold beyond it.
  double smooth_until(double t) const;

  /// Writes the values at many times at once; beyond the ends of a table they are those at its ends.
  void sample(std::span<const double> times, double* values) const;
  /// Appends the times between begin and end at which pieces of a table meet, s, ascending.
  void append_knots(double begin, double end, std::vector<double>* knots) const;

  /// Source of the numbers if they are not constant.
  class TANOR_LOCAL Source;

 private:
  using SeriesFunction = std::function<Jet<largest_order>(const Jet<largest_order>&)>;
  static ScalarFunction custom(std::function<Jet<2>(const Jet<2>&)> function, SeriesFunction series,
                               std::shared_ptr<const Expression> recorded);
  explicit ScalarFunction(std::shared_ptr<const Source> source);

  double constant_ = 0.0;
  std::shared_ptr<const Source> source_;
};

/// A 3-vector that may depend on time.
struct TANOR_API VectorFunction {
  std::array<ScalarFunction, 3> components{};

  VectorFunction() = default;
  VectorFunction(const Vector3& constant);  // NOLINT(google-explicit-constructor)
  VectorFunction(ScalarFunction x, ScalarFunction y, ScalarFunction z);

  bool is_constant() const;
  std::array<Jet<2>, 3> operator()(double t) const;
};

}  // namespace tanor
