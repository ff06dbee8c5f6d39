#include <tanor/time_function.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <tanor/error.hpp>
#include <tanor/recorded.hpp>

#include "system/corner_terms.hpp"
#include "system/formula.hpp"
#include "system/lanes.hpp"
#include "system/spline.hpp"

namespace tanor {
using namespace detail;

class ScalarFunction::Source {
 public:
  virtual ~Source() = default;
  virtual Jet<2> evaluate(double t) const = 0;
  virtual bool expand(double t, std::span<double> coefficients) const = 0;
  virtual std::shared_ptr<const Expression> expression() const = 0;
  virtual double smooth_until(double) const { return std::numeric_limits<double>::infinity(); }
  virtual void append_knots(double, double, std::vector<double>*) const {}
  virtual void sample(std::span<const double> times, double* values) const {
    for (std::size_t i = 0; i < times.size(); ++i) values[i] = evaluate(times[i]).value();
  }
};

namespace {

class FormulaSource final : public ScalarFunction::Source {
 public:
  explicit FormulaSource(Formula formula) : formula_(std::move(formula)), corners_(*expression()) {}
  std::shared_ptr<const Expression> expression() const override {
    return record_expression(
        1, [this](const std::vector<Traced>& t) { return std::vector{formula_.evaluate(std::span(t))}; });
  }
  Jet<2> evaluate(double t) const override {
    const auto variable = Jet<2>::variable(t);
    return formula_.evaluate(std::span(&variable, 1));
  }
  bool expand(double t, std::span<double> coefficients) const override {
    const auto variable = Jet<largest_order>::variable(t);
    const auto series = formula_.evaluate(std::span(&variable, 1));
    std::copy_n(series.c.begin(), coefficients.size(), coefficients.begin());
    return true;
  }
  /// Samples many times at once, since an instruction is then read once for all of them.
  void sample(std::span<const double> times, double* values) const override {
    constexpr std::size_t width = Lanes<double>::width;
    for (std::size_t first = 0; first < times.size(); first += width) {
      const std::size_t count = std::min(width, times.size() - first);
      const auto f = formula_.evaluate_loading<Lanes<double>>([&](int, Lanes<double>* t) {
        t->fill(times[first]);
        std::copy_n(times.data() + first, count, t->c[0]);
      });
      std::copy_n(f.c[0], count, values + first);
    }
  }
  /// Appends the last instants before a term of the formula takes its other branch. Two such instants of one term must
  /// be further apart than a piece of the interval.
  void append_knots(double begin, double end, std::vector<double>* knots) const override {
    if (corners_.empty() || !(begin < end)) return;
    constexpr int pieces = 64;
    const auto first = static_cast<std::ptrdiff_t>(knots->size());
    std::vector<double> from(corners_.size()), to(corners_.size());
    corners_.evaluate(&begin, from.data());
    double low = begin;
    for (int i = 1; i <= pieces; ++i) {
      const double high = i < pieces ? begin + i * (end - begin) / pieces : end;
      corners_.evaluate(&high, to.data());
      for (std::size_t k = 0; k < to.size(); ++k) {
        if ((from[k] < 0.0) != (to[k] < 0.0)) knots->push_back(narrow(k, low, high));
      }
      low = high;
      from.swap(to);
    }
    std::sort(knots->begin() + first, knots->end());
  }

 private:
  static constexpr int largest_order = ScalarFunction::largest_order;

  /// Returns the last number before which term k has the branch that it has at `low`, and not at `high`.
  double narrow(std::size_t k, double low, double high) const {
    std::vector<double> at(corners_.size());
    corners_.evaluate(&low, at.data());
    const bool is_negative = at[k] < 0.0;
    for (double middle = 0.5 * (low + high); low < middle && middle < high; middle = 0.5 * (low + high)) {
      corners_.evaluate(&middle, at.data());
      ((at[k] < 0.0) == is_negative ? low : high) = middle;
    }
    return low;
  }

  Formula formula_;
  CornerTerms corners_;
};

class TableSource final : public ScalarFunction::Source {
 public:
  explicit TableSource(Spline spline) : spline_(std::move(spline)) {}
  Jet<2> evaluate(double t) const override { return spline_.evaluate(t); }
  std::shared_ptr<const Expression> expression() const override {
    const std::optional<std::array<double, 3>> parabola = spline_.find_parabola();
    if (!parabola) return nullptr;
    return record_expression(1, [&](const std::vector<Traced>& t) {
      const Traced distance = t[0] - spline_.first_time();
      return std::vector<Traced>{(*parabola)[0] + distance * ((*parabola)[1] + (*parabola)[2] * distance)};
    });
  }
  void sample(std::span<const double> times, double* values) const override {
    for (std::size_t i = 0; i < times.size(); ++i)
      values[i] = spline_.evaluate(std::clamp(times[i], spline_.first_time(), spline_.last_time())).value();
  }
  bool expand(double t, std::span<double> coefficients) const override {
    spline_.expand(t, coefficients);
    return true;
  }
  double smooth_until(double t) const override { return spline_.next_knot(t); }
  void append_knots(double begin, double end, std::vector<double>* knots) const override {
    spline_.append_knots(begin, end, knots);
  }

 private:
  Spline spline_;
};

class CustomSource final : public ScalarFunction::Source {
 public:
  using Function = std::function<Jet<2>(const Jet<2>&)>;
  using Series = std::function<Jet<ScalarFunction::largest_order>(const Jet<ScalarFunction::largest_order>&)>;
  CustomSource(Function function, Series series, std::shared_ptr<const Expression> recorded)
      : function_(std::move(function)), series_(std::move(series)), recorded_(std::move(recorded)) {}
  std::shared_ptr<const Expression> expression() const override { return recorded_; }
  Jet<2> evaluate(double t) const override { return function_(Jet<2>::variable(t)); }
  bool expand(double t, std::span<double> coefficients) const override {
    if (!series_) return false;
    const auto series = series_(Jet<ScalarFunction::largest_order>::variable(t));
    std::copy_n(series.c.begin(), coefficients.size(), coefficients.begin());
    return true;
  }

 private:
  Function function_;
  Series series_;
  std::shared_ptr<const Expression> recorded_;
};

}  // namespace

ScalarFunction::ScalarFunction(double constant) : constant_(constant) {}

ScalarFunction::ScalarFunction(std::shared_ptr<const Source> source) : source_(std::move(source)) {}

ScalarFunction ScalarFunction::formula(std::string_view text, const Constants& constants) {
  static const std::array<std::string, 1> variables = {"t"};
  Formula formula(text, variables, constants);
  if (formula.is_constant()) return formula.evaluate(std::span<const double>());
  return ScalarFunction(std::make_shared<FormulaSource>(std::move(formula)));
}

// NOLINTNEXTLINE(performance-unnecessary-value-param): a caller gives both lists in the same way.
ScalarFunction ScalarFunction::table(std::vector<double> times, std::vector<double> values) {
  return ScalarFunction(std::make_shared<TableSource>(Spline(std::move(times), values)));
}

ScalarFunction ScalarFunction::custom(std::function<Jet<2>(const Jet<2>&)> function, SeriesFunction series,
                                      std::shared_ptr<const Expression> recorded) {
  if (!function) throw InputError("", "custom function: it is empty, nothing to call");
  return ScalarFunction(std::make_shared<CustomSource>(std::move(function), std::move(series), std::move(recorded)));
}

Jet<2> ScalarFunction::operator()(double t) const {
  return source_ ? source_->evaluate(t) : Jet<2>(constant_);
}

bool ScalarFunction::expand(double t, std::span<double> coefficients) const {
  if (source_) return source_->expand(t, coefficients);
  std::fill(coefficients.begin(), coefficients.end(), 0.0);
  coefficients[0] = constant_;
  return true;
}

std::shared_ptr<const Expression> ScalarFunction::expression() const {
  if (source_) return source_->expression();
  return record_expression(1, [this](const std::vector<Traced>&) { return std::vector<Traced>{constant_}; });
}

double ScalarFunction::smooth_until(double t) const {
  return source_ ? source_->smooth_until(t) : std::numeric_limits<double>::infinity();
}

void ScalarFunction::sample(std::span<const double> times, double* values) const {
  if (source_) return source_->sample(times, values);
  std::fill_n(values, times.size(), constant_);
}

void ScalarFunction::append_knots(double begin, double end, std::vector<double>* knots) const {
  if (source_) source_->append_knots(begin, end, knots);
}

VectorFunction::VectorFunction(const Vector3& constant) : components{constant[0], constant[1], constant[2]} {}

VectorFunction::VectorFunction(ScalarFunction x, ScalarFunction y, ScalarFunction z)
    : components{std::move(x), std::move(y), std::move(z)} {}

bool VectorFunction::is_constant() const {
  return components[0].is_constant() && components[1].is_constant() && components[2].is_constant();
}

std::array<Jet<2>, 3> VectorFunction::operator()(double t) const {
  return {components[0](t), components[1](t), components[2](t)};
}

}  // namespace tanor
