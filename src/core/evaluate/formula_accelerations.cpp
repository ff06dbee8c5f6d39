#include <numeric>
#include <utility>

#include "evaluate/formula_features.hpp"

/// \file The accelerations that formulas cause at the points of their members, at which FormulaFeatures looks.
namespace tanor::detail {

namespace {

template <class Kernel>
std::size_t num_points_of(const Kernel& kernel) {
  return static_cast<std::size_t>(kernel.num_points);
}

/// Members are tuples of points that forces push, of which some may be supports.
class TupleFeatures : public FormulaFeatures {
 protected:
  TupleFeatures(const Expression& expression, Variables variables, bool thread_safe, const Members& members,
                std::span<const double> masses)
      : FormulaFeatures(expression, variables, thread_safe, members), masses_(masses) {}

  bool is_force() const override { return true; }
  std::size_t num_accelerations() const override { return num_numbers(); }
  /// Divides the forces by the masses in place; supports get 0.
  void divide_by_masses(std::size_t member, double* a) const {
    for (std::size_t i = 0; const Index point : points(member)) {
      const double inverse = moves(point) ? 1.0 / masses_[static_cast<std::size_t>(point)] : 0.0;
      store(a, i, inverse * load(a, i));
      ++i;
    }
  }

 private:
  std::span<const double> masses_;
};

/// Features of forces, with a = f/m.
class ForceFeatures final : public TupleFeatures {
 public:
  ForceFeatures(const ForceKernel& kernel, std::span<const Index> points, std::span<const double> masses)
      : TupleFeatures(*kernel.expression, Variables::OfPointsAndTheirRates, true,
                      {.points = points, .points_per_member = num_points_of(kernel), .num_moving = masses.size()},
                      masses) {}

 private:
  void accelerate(const PointPath& path, std::size_t member, double s, double* a) const override {
    thread_local std::vector<double> variables;
    variables.resize(2 * num_numbers() + 1);
    load_variables(path, member, s, variables.data());
    formula().evaluate(variables.data(), a);
    divide_by_masses(member, a);
  }
};

/// Features of energies, with a = -(dU/dr)/m. Where U changes its course, its gradient does, since both are made of the
/// same functions.
class EnergyFeatures final : public TupleFeatures {
 public:
  EnergyFeatures(const PotentialKernel& kernel, std::span<const Index> points, std::span<const double> constants,
                 std::span<const double> masses, Course course)
      : TupleFeatures(*kernel.expression, Variables::OfPoints, kernel.thread_safe,
                      {.points = points,
                       .points_per_member = num_points_of(kernel),
                       .constants = constants,
                       .num_moving = masses.size()},
                      masses),
        kernel_(kernel),
        course_(course) {}

 private:
  bool has_jumps() const override { return course_ == Course::Jumps; }
  void accelerate(const PointPath& path, std::size_t member, double s, double* a) const override {
    thread_local std::vector<double> r;
    r.resize(num_numbers());
    load_points(path, member, s, r.data(), nullptr);
    double energy = 0.0;
    kernel_.evaluate(kernel_.context.get(), {.count = 1,
                                             .t = path.t + s * path.h,
                                             .r = r.data(),
                                             .constants = constants(member).data(),
                                             .energy = &energy,
                                             .gradient = a});
    for (std::size_t i = 0; i < num_numbers(); ++i) a[i] = -a[i];
    divide_by_masses(member, a);
  }

  PotentialKernel kernel_;
  Course course_;
};

/// Writes G g/|g| and returns 1/|g|, or 0 where g vanishes.
double write_direction(std::span<const double> g, double acceleration, double* to) {
  const double length = norm_of(g), inverse = length > 0.0 ? 1.0 / length : 0.0;
  for (const double each : g) *to++ = acceleration * (inverse * each);
  return inverse;
}

/// Features of constraints. With the gradient g of xi and the largest acceleration G that may act there, they look at
///
///   -phi g/|g|^2   and   G g/|g|
///
/// The first holds the points on xi = 0 while they move, the second shows how the reactions to other forces turn.
class ConstraintFeatures final : public FormulaFeatures {
 public:
  ConstraintFeatures(const ConstraintKernel& kernel, std::span<const Index> points)
      : FormulaFeatures(*kernel.expression, Variables::OfPoints, kernel.thread_safe,
                        {.points = points, .points_per_member = num_points_of(kernel)}),
        kernel_(kernel) {}

 private:
  std::size_t num_accelerations() const override { return 2 * num_numbers(); }
  void accelerate(const PointPath& path, std::size_t member, double s, double* a) const override {
    thread_local std::vector<double> r, v, gradient;
    for (std::vector<double>* array : {&r, &v, &gradient}) array->resize(num_numbers());
    load_points(path, member, s, r.data(), v.data());
    double xi = 0.0, rate = 0.0, phi = 0.0;
    kernel_.evaluate(kernel_.context.get(),
                     {1, path.t + s * path.h, r.data(), v.data(), &xi, &rate, &phi, gradient.data()});
    const double inverse = write_direction(gradient, largest_acceleration(path, member), a + num_numbers());
    for (std::size_t i = 0; i < num_numbers(); ++i) a[i] = -inverse * phi * (inverse * gradient[i]);
  }

  ConstraintKernel kernel_;
};

/// Features of coordinates. With each column A_j of A and the largest acceleration G that may act there, they look at
///
///   -A_j'psi/|A_j|   and   G A_j/|A_j|
class CoordinateFeatures final : public FormulaFeatures {
 public:
  CoordinateFeatures(const CoordinateKernel& kernel, std::span<const Index> points, Index first_coordinate)
      : FormulaFeatures(
            *kernel.expression, Variables::OfMechanics, kernel.thread_safe,
            {.points = points, .points_per_member = num_points_of(kernel), .first_variable = first_coordinate}),
        kernel_(kernel) {}

 private:
  std::size_t width() const { return 3 * num_points_of(kernel_); }
  std::size_t num_accelerations() const override { return num_numbers() * (1 + width()); }
  void accelerate(const PointPath& path, std::size_t member, double s, double* a) const override {
    thread_local std::vector<double> q, q_dot, r, v, psi, tangents;
    const std::size_t count = num_numbers();
    for (std::vector<double>* array : {&q, &q_dot}) array->resize(count);
    for (std::vector<double>* array : {&r, &v, &psi}) array->resize(width());
    tangents.resize(count * width());
    for (std::size_t i = 0; const Index number : numbers(member)) {
      const PointPath::Number at = path.number(number, s, true);
      q[i] = at.x;
      q_dot[i++] = at.rate;
    }
    kernel_.evaluate(kernel_.context.get(),
                     {1, path.t + s * path.h, q.data(), q_dot.data(), r.data(), v.data(), psi.data(), tangents.data()});
    const double may_act = largest_acceleration(path, member);
    for (std::size_t j = 0; j < count; ++j) {
      const std::span tangent = std::span(tangents).subspan(j * width(), width());
      const double inverse = write_direction(tangent, may_act, a + count + j * width());
      a[j] = -inverse * std::inner_product(tangent.begin(), tangent.end(), psi.begin(), 0.0);
    }
  }

  CoordinateKernel kernel_;
};

template <class Features, class Kernel, class... Rest>
std::unique_ptr<FormulaFeatures> make_if_needed(const Kernel& kernel, const Rest&... rest) {
  if (kernel.expression == nullptr) return nullptr;
  auto features = std::make_unique<Features>(kernel, rest...);
  return features->is_needed() ? std::move(features) : nullptr;
}

}  // namespace

std::unique_ptr<FormulaFeatures> make_force_features(const ForceKernel& kernel, std::span<const Index> inner_points,
                                                     std::span<const double> masses) {
  return make_if_needed<ForceFeatures>(kernel, inner_points, masses);
}

std::unique_ptr<FormulaFeatures> make_energy_features(const PotentialKernel& kernel,
                                                      std::span<const Index> inner_points,
                                                      std::span<const double> constants, std::span<const double> masses,
                                                      Course course) {
  return make_if_needed<EnergyFeatures>(kernel, inner_points, constants, masses, course);
}

std::unique_ptr<FormulaFeatures> make_constraint_features(const ConstraintKernel& kernel,
                                                          std::span<const Index> inner_points) {
  return make_if_needed<ConstraintFeatures>(kernel, inner_points);
}

std::unique_ptr<FormulaFeatures> make_coordinate_features(const CoordinateKernel& kernel,
                                                          std::span<const Index> inner_points, Index first_coordinate) {
  return make_if_needed<CoordinateFeatures>(kernel, inner_points, first_coordinate);
}

}  // namespace tanor::detail
