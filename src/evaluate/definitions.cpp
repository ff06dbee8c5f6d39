#include "evaluate/definitions.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <tanor/forward.hpp>

#include "evaluate/line_frame.hpp"
#include "system/members.hpp"
#include "system/tuples.hpp"

namespace tanor {

namespace {

// ---- places over a scalar type
// ---------------------------------------------------------------------------------------

template <class T>
struct Place {
  T x, y, z;

  friend Place operator+(const Place& a, const Place& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Place operator-(const Place& a, const Place& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Place operator*(const T& s, const Place& a) { return {s * a.x, s * a.y, s * a.z}; }
  friend Place operator/(const Place& a, const T& s) { return {a.x / s, a.y / s, a.z / s}; }
};

template <class T>
[[gnu::always_inline]] inline T inner_product(const Place<T>& a, const Place<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
[[gnu::always_inline]] inline T length(const Place<T>& a) {
  using std::sqrt;
  return sqrt(inner_product(a, a));
}
template <class T>
[[gnu::always_inline]] inline Place<T> vector_product(const Place<T>& a, const Place<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
Place<T> place(const Vector3& a) {
  return {T(a[0]), T(a[1]), T(a[2])};
}

/// Functions of time: a jet runs along with time, all others look at it standing still.
template <class T>
struct Clock {
  double t;

  T operator()(const ScalarFunction& function) const {
    if constexpr (std::is_same_v<T, Jet<2>>) return function(t);
    return T(function(t).value());
  }
  Place<T> operator()(const VectorFunction& function) const {
    return {(*this)(function.components[0]), (*this)(function.components[1]), (*this)(function.components[2])};
  }
};

/// Taken down, a function of time that moves is a variable. One instant serves all: `recording` outlives the clocks.
struct Recording {
  RecordedDefinition definition;
  std::optional<Traced> parameter;
};
template <>
struct Clock<Traced> {
  double t;
  Recording* recording;

  Traced operator()(const ScalarFunction& function) const {
    if (function.is_constant()) return function(t).value();
    recording->definition.functions.push_back(function);
    return Traced::variable(recording->definition.expression);
  }
  Place<Traced> operator()(const VectorFunction& function) const {
    return {(*this)(function.components[0]), (*this)(function.components[1]), (*this)(function.components[2])};
  }
};

/// A parameter's number for each member; a function that all share is evaluated once.
template <class T>
class Given {
 public:
  Given(const Parameter& parameter, std::span<const double> initial, const Clock<T>& clock)
      : parameter_(parameter), initial_(initial), clock_(clock) {
    if (parameter.functions.size() == 1) shared_ = clock(parameter.functions[0]);
  }
  T operator[](std::size_t k) const {
    if (parameter_.is_initial()) return T(initial_[k]);
    if (parameter_.functions.size() == 1) return shared_;
    if (!parameter_.functions.empty()) return clock_(parameter_.functions[k]);
    return T(parameter_.constants[parameter_.constants.size() == 1 ? 0 : k]);
  }

 private:
  const Parameter& parameter_;
  std::span<const double> initial_;
  Clock<T> clock_;
  T shared_{};
};

template <>
class Given<Traced> {
 public:
  Given(const Parameter& parameter, std::span<const double>, const Clock<Traced>& clock)
      : parameter_(parameter), clock_(clock) {}
  Traced operator[](std::size_t) const {
    if (parameter_.functions.size() == 1) return clock_(parameter_.functions[0]);
    if (parameter_.constants.size() == 1) return parameter_.constants[0];
    clock_.recording->definition.has_parameter = true;
    return *clock_.recording->parameter;
  }

 private:
  const Parameter& parameter_;
  Clock<Traced> clock_;
};

// ---- the definitions
// ------------------------------------------------------------------------------------------------- Each is made once
// for an instant. xi(k, at) are the rows of member k, `at(i)` the place of point i; measure(k, at) is what a parameter
// that is "initial" takes from the start.

template <class Group, class T>
struct Definition;

template <class T>
struct Definition<Rods, T> {
  const Rods& rods;
  Given<T> wanted;

  Definition(const Rods& group, const Clock<T>& clock, std::span<const double> initial)
      : rods(group), wanted(group.length, initial, clock) {}

  template <class At>
  T measure(std::size_t k, const At& at) const {
    const auto [i, j] = rods.pairs[k];
    return length(at(j) - at(i) + place<T>(rods.offsets.empty() ? Vector3{} : rods.offsets[k]));
  }
  template <class At>
  std::array<T, 1> xi(std::size_t k, const At& at) const {
    return {measure(k, at) - wanted[k]};
  }
};

template <class T>
struct Definition<Planes, T> {
  const Planes& planes;
  Place<T> normal;
  Given<T> offset;

  Definition(const Planes& group, const Clock<T>& clock, std::span<const double> initial)
      : planes(group), normal(clock(group.normal)), offset(group.offset, initial, clock) {}

  template <class At>
  T measure(std::size_t k, const At& at) const {
    return inner_product(normal, at(planes.points[k]));
  }
  template <class At>
  std::array<T, 1> xi(std::size_t k, const At& at) const {
    return {(measure(k, at) - offset[k]) / length(normal)};
  }
};

template <class T>
struct Definition<Spheres, T> {
  const Spheres& spheres;
  Place<T> center;
  Given<T> radius;

  Definition(const Spheres& group, const Clock<T>& clock, std::span<const double> initial)
      : spheres(group), center(clock(group.center)), radius(group.radius, initial, clock) {}

  template <class At>
  T measure(std::size_t k, const At& at) const {
    return length(at(spheres.points[k]) - center);
  }
  template <class At>
  std::array<T, 1> xi(std::size_t k, const At& at) const {
    return {measure(k, at) - radius[k]};
  }
};

template <class T>
struct Definition<Lines, T> {
  const Lines& lines;
  Place<T> origin, first, second;

  /// `axis` instead of the rule's one.
  Definition(const Lines& group, const Clock<T>& clock, std::span<const double>, std::optional<LineAxis> axis = {})
      : lines(group), origin(clock(group.origin)) {
    const Place<T> along = clock(group.direction);
    const std::array<T, 3> d{along.x, along.y, along.z};
    const auto [e1, e2] = line_frame(d, axis ? *axis : line_axis(d));
    first = {e1[0], e1[1], e1[2]};
    second = {e2[0], e2[1], e2[2]};
  }

  template <class At>
  std::array<T, 2> xi(std::size_t k, const At& at) const {
    const Place<T> a = at(lines.points[k]) - origin;
    return {inner_product(first, a), inner_product(second, a)};
  }
};

template <class T>
struct Definition<Circles, T> {
  const Circles& circles;
  Place<T> center, normal;
  Given<T> radius;

  Definition(const Circles& group, const Clock<T>& clock, std::span<const double> initial)
      : circles(group),
        center(clock(group.center)),
        normal(clock(group.normal)),
        radius(group.radius, initial, clock) {}

  /// |n x a|/|n|, the distance from the axis.
  template <class At>
  T measure(std::size_t k, const At& at) const {
    return length(vector_product(normal, at(circles.points[k]) - center)) / length(normal);
  }
  template <class At>
  std::array<T, 2> xi(std::size_t k, const At& at) const {
    return {inner_product(normal, at(circles.points[k]) - center) / length(normal), measure(k, at) - radius[k]};
  }
};

template <class T>
struct Definition<Angles, T> {
  const Angles& angles;
  Given<T> cosine;

  Definition(const Angles& group, const Clock<T>& clock, std::span<const double> initial)
      : angles(group), cosine(group.cosine, initial, clock) {}

  template <class At>
  T measure(std::size_t m, const At& at) const {
    const auto [i, j, k] = angles.triples[m];
    const Place<T> a = at(i) - at(j), b = at(k) - at(j);
    return inner_product(a, b) / (length(a) * length(b));
  }
  template <class At>
  std::array<T, 1> xi(std::size_t k, const At& at) const {
    return {measure(k, at) - cosine[k]};
  }
};

template <class T>
struct Definition<Pulleys, T> {
  const Pulleys& pulleys;
  Given<T> rope;

  Definition(const Pulleys& group, const Clock<T>& clock, std::span<const double> initial)
      : pulleys(group), rope(group.length, initial, clock) {}

  template <class At>
  T measure(std::size_t k, const At& at) const {
    const auto [i, j] = pulleys.pairs[k];
    return length(at(i) - place<T>(pulleys.a)) + T(pulleys.ratio) * length(at(j) - place<T>(pulleys.b));
  }
  template <class At>
  std::array<T, 1> xi(std::size_t k, const At& at) const {
    return {measure(k, at) - rope[k]};
  }
};

template <class T>
struct Definition<Linears, T> {
  const Linears& linears;
  Given<T> value;

  Definition(const Linears& group, const Clock<T>& clock, std::span<const double> initial)
      : linears(group), value(group.value, initial, clock) {}

  template <class At>
  T measure(std::size_t k, const At& at) const {
    T sum(0.0);
    for (std::size_t p = 0; p < linears.coefficients.size(); ++p) {
      sum += inner_product(place<T>(linears.coefficients[p]), at(linears.tuples[k][p]));
    }
    return sum;
  }
  template <class At>
  std::array<T, 1> xi(std::size_t k, const At& at) const {
    return {measure(k, at) - value[k]};
  }
};

/// What members have one number each of; null: lines, and what users define.
template <class Group>
const Parameter* parameter_of(const Group& group) {
  if constexpr (requires { group.length; }) return &group.length;
  if constexpr (requires { group.offset; }) return &group.offset;
  if constexpr (requires { group.radius; }) return &group.radius;
  if constexpr (requires { group.cosine; }) return &group.cosine;
  if constexpr (requires { group.value; }) return &group.value;
  return nullptr;
}

// ---- points
// ----------------------------------------------------------------------------------------------------------

/// r + e v + e^2/2 w
struct Along {
  const double *r, *v, *w;

  Place<Jet<2>> operator()(Index i) const {
    const auto first = 3 * static_cast<std::size_t>(i);
    Place<Jet<2>> result;
    for (std::size_t k = 0; k < 3; ++k) {
      Jet<2>& x = k == 0 ? result.x : k == 1 ? result.y : result.z;
      x.c = {r[first + k], v[first + k], 0.5 * w[first + k]};
    }
    return result;
  }
};

/// r + e u, to first order
struct Straight {
  const double *r, *u;

  Place<Forward<1>> operator()(Index i) const {
    const auto first = 3 * static_cast<std::size_t>(i);
    Place<Forward<1>> result{r[first], r[first + 1], r[first + 2]};
    result.x.d[0] = u[first];
    result.y.d[0] = u[first + 1];
    result.z.d[0] = u[first + 2];
    return result;
  }
};

/// Point `active` varies, the others stand.
struct Varying {
  const double* r;
  Index active;

  Place<Forward<3>> operator()(Index i) const {
    const double* const p = r + 3 * static_cast<std::size_t>(i);
    if (i != active) return {p[0], p[1], p[2]};
    using Number = Forward<3>;
    return {Number::variable(p[0], 0), Number::variable(p[1], 1), Number::variable(p[2], 2)};
  }
};

/// Tuples of a user's group, one after the other.
std::vector<Index> flatten(const UserConstraints& user) {
  std::vector<Index> points;
  for (const auto& tuple : user.tuples) points.insert(points.end(), tuple.begin(), tuple.end());
  return points;
}

/// Member `first + k` of a user's group: its gradient times w of its points.
double along_gradient(const UserConstraints& group, const TupleValues& values, std::size_t k, const double* w) {
  const std::vector<Index>& tuple = group.tuples[values.first + k];
  double sum = 0.0;
  for (std::size_t p = 0; p < tuple.size(); ++p) {
    sum += dot(load(values.gradient + k * values.size, p), load(w, tuple[p]));
  }
  return sum;
}

}  // namespace

Definitions::Definitions(const System& system, double t0) : system_(system), starts_(system.constraints.size()) {
  const auto at = [&](Index i) {
    const Vec3 r = load(system.positions.data(), i);
    return Place<double>{r.x, r.y, r.z};
  };
  for (std::size_t g = 0; g < starts_.size(); ++g) {
    std::visit(
        [&]<class Group>(const Group& group) {
          Start& start = starts_[g];
          start.first_row = num_rows_;
          num_rows_ += num_members(group) * rows_per_member<Group>();
          const Clock<double> clock{t0};
          if constexpr (!std::is_same_v<Group, UserConstraints> && !std::is_same_v<Group, Lines>) {
            if (!parameter_of(group)->is_initial()) return;
            const Definition<Group, double> definition(group, clock, {});
            for (std::size_t k = 0; k < num_members(group); ++k) start.values.push_back(definition.measure(k, at));
          }
        },
        system.constraints[g]);
  }
}

std::optional<RecordedDefinition> Definitions::record(std::size_t g, std::optional<LineAxis> axis) const {
  return std::visit(
      [&]<class Group>(const Group& group) -> std::optional<RecordedDefinition> {
        if (num_members(group) == 0) return std::nullopt;
        if constexpr (std::is_same_v<Group, UserConstraints>) {
          if (group.kernel.expression == nullptr) return std::nullopt;
          return RecordedDefinition{*group.kernel.expression, {ScalarFunction::formula("t")}, false};
        } else {
          Recording recording;
          Expression& expression = recording.definition.expression;
          const std::span<const Index> points = member_points(group, 0);
          std::vector<Place<Traced>> places;
          for (std::size_t p = 0; p < points.size(); ++p) {
            const Traced x = Traced::variable(expression), y = Traced::variable(expression);
            places.push_back({x, y, Traced::variable(expression)});
          }
          const auto at = [&](Index i) {
            return places[static_cast<std::size_t>(std::ranges::find(points, i) - points.begin())];
          };
          recording.parameter = Traced::variable(expression);
          try {
            const Clock<Traced> clock{0.0, &recording};
            const auto definition = [&] {
              if constexpr (std::is_same_v<Group, Lines>)
                return Definition<Lines, Traced>(group, clock, starts_[g].values, axis);
              else
                return Definition<Group, Traced>(group, clock, starts_[g].values);
            }();
            for (const Traced& xi : definition.xi(0, at)) expression.results.push_back(xi.number_in(expression));
          } catch (const detail::NotTraceable&) {
            return std::nullopt;
          }
          // Its variable stands before those of the functions: to the end, or away.
          const auto parameter = expression.variables.begin() + static_cast<std::ptrdiff_t>(3 * points.size());
          std::rotate(parameter, parameter + 1, expression.variables.end());
          if (!recording.definition.has_parameter) expression.variables.pop_back();
          return recording.definition;
        }
      },
      system_.constraints[g]);
}

ScalarFunction Definitions::parameter(std::size_t g, std::size_t k) const {
  return std::visit(
      [&]<class Group>(const Group& group) -> ScalarFunction {
        const Parameter* const parameter = parameter_of(group);
        if (parameter == nullptr) return 0.0;
        if (parameter->is_initial()) return starts_[g].values[k];
        const auto pick = [k](const auto& each) { return each[each.size() == 1 ? 0 : k]; };
        return parameter->functions.empty() ? ScalarFunction(pick(parameter->constants)) : pick(parameter->functions);
      },
      system_.constraints[g]);
}

template <class T, class At, class Use, class UseTuples>
void Definitions::for_each_row(const Parallel& parallel, double t, const double* r, const double* v, const At& at,
                               const Use& use, const UseTuples& use_tuples) const {
  for (std::size_t g = 0; g < starts_.size(); ++g) {
    const Start& start = starts_[g];
    std::visit(
        [&]<class Group>(const Group& group) {
          if constexpr (std::is_same_v<Group, UserConstraints>) {
            const std::vector<Index> points = flatten(group);
            const Parallel serial(1);
            const Parallel& loop = group.kernel.thread_safe ? parallel : serial;
            loop.for_ranges(num_members(group), [&](std::size_t begin, std::size_t end) {
              for_each_chunk(group.kernel, points, begin, end, t, r, v,
                             [&](const TupleValues& values) { use_tuples(start.first_row, group, values); });
            });
          } else {
            const Definition<Group, T> definition(group, Clock<T>{t}, start.values);
            parallel.for_ranges(num_members(group), [&](std::size_t begin, std::size_t end) {
              for (std::size_t k = begin; k < end; ++k) {
                std::size_t row = start.first_row + k * rows_per_member<Group>();
                for (const T& xi : definition.xi(k, at)) use(row++, xi);
              }
            });
          }
        },
        system_.constraints[g]);
  }
}

void Definitions::taylor(const Parallel& parallel, double t, std::span<const double> r, std::span<const double> v,
                         std::span<const double> w, std::span<double> xi, std::span<double> rate,
                         std::span<double> second) const {
  for_each_row<Jet<2>>(
      parallel, t, r.data(), v.data(), Along{r.data(), v.data(), w.data()},
      [&](std::size_t row, const Jet<2>& jet) {
        xi[row] = jet.value();
        rate[row] = jet.derivative(1);
        second[row] = jet.derivative(2);
      },
      [&](std::size_t first_row, const UserConstraints& group, const TupleValues& values) {
        for (std::size_t k = 0; k < values.count; ++k) {
          const std::size_t row = first_row + values.first + k;
          xi[row] = values.xi[k];
          rate[row] = values.rate[k];
          second[row] = values.phi[k] + along_gradient(group, values, k, w.data());
        }
      });
}

void Definitions::transposed(const Parallel& parallel, double t, std::span<const double> r, std::span<const double> u,
                             std::span<double> y) const {
  for_each_row<Forward<1>>(
      parallel, t, r.data(), nullptr, Straight{r.data(), u.data()},
      [&](std::size_t row, const Forward<1>& xi) { y[row] = xi.d[0]; },
      [&](std::size_t first_row, const UserConstraints& group, const TupleValues& values) {
        for (std::size_t k = 0; k < values.count; ++k) {
          y[first_row + values.first + k] = along_gradient(group, values, k, u.data());
        }
      });
}

template <class Use>
void Definitions::for_each_gradient(double t, std::span<const double> r, const Use& use) const {
  for (std::size_t g = 0; g < starts_.size(); ++g) {
    const Start& start = starts_[g];
    std::visit(
        [&]<class Group>(const Group& group) {
          if constexpr (std::is_same_v<Group, UserConstraints>) {
            for_each_chunk(group.kernel, flatten(group), 0, num_members(group), t, r.data(), nullptr,
                           [&](const TupleValues& values) {
                             for (std::size_t k = 0; k < values.count; ++k) {
                               const std::size_t member = values.first + k;
                               for (std::size_t p = 0; p < group.tuples[member].size(); ++p) {
                                 use(start.first_row + member, group.tuples[member][p],
                                     load(values.gradient + k * values.size, p));
                               }
                             }
                           });
          } else {
            const Definition<Group, Forward<3>> definition(group, Clock<Forward<3>>{t}, start.values);
            for (std::size_t k = 0; k < num_members(group); ++k) {
              for (const Index point : member_points(group, k)) {
                std::size_t row = start.first_row + k * rows_per_member<Group>();
                for (const Forward<3>& xi : definition.xi(k, Varying{r.data(), point})) {
                  use(row++, point, Vec3{xi.d[0], xi.d[1], xi.d[2]});
                }
              }
            }
          }
        },
        system_.constraints[g]);
  }
}

void Definitions::reactions(double t, std::span<const double> r, std::span<const double> lambda,
                            std::span<double> eta) const {
  std::ranges::fill(eta, 0.0);
  for_each_gradient(
      t, r, [&](std::size_t row, Index point, Vec3 gradient) { add_to(eta.data(), point, lambda[row] * gradient); });
}

}  // namespace tanor
