#include <array>
#include <utility>

#include "evaluate/formula_passages.hpp"

/// \file The accelerations that formulas cause at the points of their members, at which FormulaPassages looks.
namespace tanor::detail {

namespace {

/// Members are tuples of p points, of which some may be supports.
class TuplePassages : public FormulaPassages {
 protected:
  TuplePassages(const Expression& expression, Variables variables, bool thread_safe, std::size_t num_constants,
                std::span<const Index> points, std::span<const double> masses)
      : FormulaPassages(expression, variables, thread_safe, num_constants),
        points_(points.begin(), points.end()),
        masses_(masses) {
    append_points(points);
  }

  bool is_force() const override { return true; }
  std::size_t num_accelerations() const override { return num_numbers(); }
  std::span<const Index> own(std::size_t member) const {
    const std::size_t p = num_numbers() / 3;
    return std::span(points_).subspan(member * p, p);
  }
  /// Divides the forces by the masses in place; supports get 0.
  void divide_by_masses(std::size_t member, double* a) const {
    for (std::size_t i = 0; const Index point : own(member)) {
      const double inverse = moves(point) ? 1.0 / masses_[static_cast<std::size_t>(point)] : 0.0;
      store(a, i, inverse * load(a, i));
      ++i;
    }
  }

 private:
  bool moves(Index point) const { return static_cast<std::size_t>(point) < masses_.size(); }
  Allowed allow(const PointPath& path, std::size_t member) const override {
    std::array<Index, ForceKernel::most_points> moving;  // NOLINT: filled below
    std::size_t count = 0;
    for (const Index point : own(member))
      if (moves(point)) moving[count++] = point;
    return FormulaPassages::allow(path, std::span(moving).first(count));
  }

  std::vector<Index> points_;  // [member][p]
  std::span<const double> masses_;
};
static_assert(ForceKernel::most_points == PotentialKernel::most_points);

/// Passages of forces, with a = f/m.
class ForcePassages final : public TuplePassages {
 public:
  ForcePassages(const ForceKernel& kernel, std::span<const Index> points, std::span<const double> masses)
      : TuplePassages(*kernel.expression, Variables::OfPointsAndTheirRates, true, 0, points, masses) {}

 private:
  void accelerate(const PointPath& path, std::size_t member, double s, double* a) const override {
    thread_local std::vector<double> variables;
    variables.resize(2 * num_numbers() + 1);
    load_variables(path, member, s, variables.data());
    formula().evaluate(variables.data(), a);
    divide_by_masses(member, a);
  }
};

/// Passages of energies, with a = -(dU/dr)/m. Where U changes its course, its gradient does, since both are made of the
/// same functions.
class EnergyPassages final : public TuplePassages {
 public:
  EnergyPassages(const PotentialKernel& kernel, std::span<const Index> points, std::span<const double> constants,
                 std::span<const double> masses, Course course)
      : TuplePassages(*kernel.expression, Variables::OfPoints, kernel.thread_safe,
                      static_cast<std::size_t>(kernel.num_constants), points, masses),
        kernel_(kernel),
        course_(course) {
    append_constants(constants);
  }

 private:
  bool has_jumps() const override { return course_ == Course::Jumps; }
  void accelerate(const PointPath& path, std::size_t member, double s, double* a) const override {
    thread_local std::vector<double> r;
    r.resize(num_numbers());
    for (std::size_t i = 0; const Index point : own(member)) store(r.data(), i++, path.at(point, s).r);
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

/// Passages of constraints. With the gradient g of xi and the largest acceleration G that may act there, they look at
///
///   -phi g/|g|^2   and   G g/|g|
///
/// The first holds the points on xi = 0 while they move, the second shows how the reactions to other forces turn.
class ConstraintPassages final : public FormulaPassages {
 public:
  ConstraintPassages(const ConstraintKernel& kernel, std::span<const Index> points)
      : FormulaPassages(*kernel.expression, Variables::OfPoints, kernel.thread_safe),
        kernel_(kernel),
        points_(points.begin(), points.end()) {
    append_points(points);
  }

 private:
  std::span<const Index> own(std::size_t member) const {
    const auto p = static_cast<std::size_t>(kernel_.num_points);
    return std::span(points_).subspan(member * p, p);
  }
  Allowed allow(const PointPath& path, std::size_t member) const override {
    return FormulaPassages::allow(path, own(member));
  }
  std::size_t num_accelerations() const override { return 2 * num_numbers(); }
  void accelerate(const PointPath& path, std::size_t member, double s, double* a) const override {
    thread_local std::vector<double> r, v, gradient;
    for (std::vector<double>* array : {&r, &v, &gradient}) array->resize(num_numbers());
    double may_act = 0.0;
    for (std::size_t i = 0; const Index point : own(member)) {
      const auto place = path.at(point, s);
      store(r.data(), i, place.r);
      store(v.data(), i++, place.v);
      may_act = std::max(may_act, path.largest_acceleration(point));
    }
    double xi = 0.0, rate = 0.0, phi = 0.0;
    kernel_.evaluate(kernel_.context.get(),
                     {1, path.t + s * path.h, r.data(), v.data(), &xi, &rate, &phi, gradient.data()});
    const double length = norm_of(gradient), inverse = length > 0.0 ? 1.0 / length : 0.0;
    for (std::size_t i = 0; i < num_numbers(); ++i) {
      const double unit = inverse * gradient[i];
      a[i] = -inverse * phi * unit;
      a[num_numbers() + i] = may_act * unit;
    }
  }

  ConstraintKernel kernel_;
  std::vector<Index> points_;  // [member][p]
};

/// Passages of coordinates. With each column A_j of A and the largest acceleration G that may act there, they look at
///
///   -A_j'psi/|A_j|   and   G A_j/|A_j|
class CoordinatePassages final : public FormulaPassages {
 public:
  CoordinatePassages(const CoordinateKernel& kernel, std::span<const Index> points, Index first_coordinate)
      : FormulaPassages(*kernel.expression, Variables::OfMechanics, kernel.thread_safe),
        kernel_(kernel),
        points_(points.begin(), points.end()) {
    const std::size_t members = points_.size() / num_points();
    for (std::size_t i = 0; i < members * num_numbers(); ++i) append_number(first_coordinate + static_cast<Index>(i));
  }

 private:
  std::size_t num_points() const { return static_cast<std::size_t>(kernel_.num_points); }
  std::span<const Index> own(std::size_t member) const {
    return std::span(points_).subspan(member * num_points(), num_points());
  }
  Allowed allow(const PointPath& path, std::size_t member) const override {
    return FormulaPassages::allow(path, own(member));
  }
  std::size_t num_accelerations() const override { return num_numbers() * (1 + 3 * num_points()); }
  void accelerate(const PointPath& path, std::size_t member, double s, double* a) const override {
    thread_local std::vector<double> q, q_dot, r, v, psi, tangents;
    const std::size_t count = num_numbers(), width = 3 * num_points();
    for (std::vector<double>* array : {&q, &q_dot}) array->resize(count);
    for (std::vector<double>* array : {&r, &v, &psi}) array->resize(width);
    tangents.resize(count * width);
    for (std::size_t i = 0; const Index number : numbers(member)) {
      const PointPath::Number at = path.number(number, s, true);
      q[i] = at.x;
      q_dot[i++] = at.rate;
    }
    double may_act = 0.0;
    for (const Index point : own(member)) may_act = std::max(may_act, path.largest_acceleration(point));
    kernel_.evaluate(kernel_.context.get(),
                     {1, path.t + s * path.h, q.data(), q_dot.data(), r.data(), v.data(), psi.data(), tangents.data()});
    for (std::size_t j = 0; j < count; ++j) {
      const std::span tangent = std::span(tangents).subspan(j * width, width);
      const double length = norm_of(tangent), inverse = length > 0.0 ? 1.0 / length : 0.0;
      double along = 0.0;
      for (std::size_t i = 0; i < width; ++i) {
        along += inverse * tangent[i] * psi[i];
        a[count + j * width + i] = may_act * inverse * tangent[i];
      }
      a[j] = -along;
    }
  }

  CoordinateKernel kernel_;
  std::vector<Index> points_;  // [member][p]
};

std::unique_ptr<FormulaPassages> if_needed(std::unique_ptr<FormulaPassages> passages) {
  return passages->is_needed() ? std::move(passages) : nullptr;
}

}  // namespace

std::unique_ptr<FormulaPassages> make_force_passages(const ForceKernel& kernel, std::span<const Index> inner_points,
                                                     std::span<const double> masses) {
  if (kernel.expression == nullptr) return nullptr;
  return if_needed(std::make_unique<ForcePassages>(kernel, inner_points, masses));
}

std::unique_ptr<FormulaPassages> make_energy_passages(const PotentialKernel& kernel,
                                                      std::span<const Index> inner_points,
                                                      std::span<const double> constants, std::span<const double> masses,
                                                      Course course) {
  if (kernel.expression == nullptr) return nullptr;
  return if_needed(std::make_unique<EnergyPassages>(kernel, inner_points, constants, masses, course));
}

std::unique_ptr<FormulaPassages> make_constraint_passages(const ConstraintKernel& kernel,
                                                          std::span<const Index> inner_points) {
  if (kernel.expression == nullptr) return nullptr;
  return if_needed(std::make_unique<ConstraintPassages>(kernel, inner_points));
}

std::unique_ptr<FormulaPassages> make_coordinate_passages(const CoordinateKernel& kernel,
                                                          std::span<const Index> inner_points, Index first_coordinate) {
  if (kernel.expression == nullptr) return nullptr;
  return if_needed(std::make_unique<CoordinatePassages>(kernel, inner_points, first_coordinate));
}

}  // namespace tanor::detail
