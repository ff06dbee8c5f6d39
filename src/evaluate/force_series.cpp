#include "evaluate/force_series.hpp"

#include <memory>
#include <variant>

#include "base/text.hpp"

namespace tanor {

namespace {

using Source = SeriesVariable::Source;

std::vector<SeriesVariable> list_variables(int num_points, bool with_velocities, int num_functions) {
  std::vector<SeriesVariable> variables;
  for (const Source source : {Source::Position, Source::Velocity}) {
    if (source == Source::Velocity && !with_velocities) continue;
    for (int i = 0; i < 3 * num_points; ++i) variables.push_back({source, i / 3, i % 3, 0});
  }
  for (int i = 0; i < num_functions; ++i) variables.push_back({Source::Time, 0, 0, i});
  return variables;
}

/// On point j: -(k (L - rest) + c dL/dt) a/L with a = r_j - r_i, L = |a|; variables r_i, r_j, v_i, v_j, rest.
Expression record_spring(double stiffness, double damping, bool has_rest_length) {
  const auto spring = [&](const std::vector<Traced>& x) {
    const std::size_t velocities = damping > 0.0 ? 6 : 0;
    std::vector<Traced> a, b;
    for (std::size_t c = 0; c < 3; ++c) a.push_back(x[3 + c] - x[c]);
    for (std::size_t c = 0; c < 3 && damping > 0.0; ++c) b.push_back(x[9 + c] - x[6 + c]);
    Traced factor = stiffness;
    if (has_rest_length || damping > 0.0) {
      const Traced square = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
      if (has_rest_length) factor -= stiffness * x[6 + velocities] / sqrt(square);
      if (damping > 0.0) factor += damping * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) / square;
    }
    return std::vector{-factor * a[0], -factor * a[1], -factor * a[2]};
  };
  return *record_expression(6 + (damping > 0.0 ? 6 : 0) + (has_rest_length ? 1 : 0), spring);
}

/// -(c1 + c2 |v|) v; variables r, v.
Expression record_drag(double linear, double quadratic) {
  return *record_expression(6, [&](const std::vector<Traced>& x) {
    Traced factor = linear;
    if (quadratic > 0.0) factor += quadratic * sqrt(x[3] * x[3] + x[4] * x[4] + x[5] * x[5]);
    return std::vector{-factor * x[3], -factor * x[4], -factor * x[5]};
  });
}

}  // namespace

void ForceSeries::append(const std::vector<Index>& points, Index block, bool is_pair) {
  incidences_.push_back({points.back(), 0, block, 1.0});
  if (is_pair) incidences_.push_back({points.front(), 0, block, -1.0});
}

ForceSeries::ForceSeries(const System& system, const Numbering& numbering, double t0) {
  const auto inner = [&](Index point) { return numbering.inner_point[static_cast<std::size_t>(point)]; };
  const auto add_group = [&](Expression expression, int num_points, bool has_velocities, int num_functions) -> Group& {
    groups_.push_back(
        {ProgramFamily(SeriesProgram(std::move(expression), false),
                       list_variables(num_points, has_velocities, num_functions), num_points, num_functions),
         num_blocks_});
    return groups_.back();
  };
  const auto add_member = [&](Group& group, const std::vector<Index>& points, std::span<const std::size_t> slots) {
    group.family.append_member(points, slots);
    append(points, num_blocks_++, points.size() == 2);
  };
  for (std::size_t g = 0; g < system.forces.size() && obstacle_.empty(); ++g) {
    const Force& force = system.forces[g];
    if (const auto* gravity = std::get_if<Gravity>(&force)) {
      gravity_ = gravity_ + make_vec3(gravity->acceleration);
    } else if (const auto* given = std::get_if<ConstantForce>(&force)) {
      Expression expression;
      for (int c = 0; c < 3; ++c) (void)Traced::variable(expression);
      expression.results = expression.variables;
      groups_.push_back(
          {ProgramFamily(SeriesProgram(std::move(expression), false),
                         {{Source::Time, 0, 0, 0}, {Source::Time, 0, 0, 1}, {Source::Time, 0, 0, 2}}, 1, 3),
           num_blocks_});
      std::vector<std::size_t> slots;
      for (const ScalarFunction& component : given->force.components) slots.push_back(table_.add(component));
      for (const Index point : given->points) add_member(groups_.back(), {inner(point)}, slots);
    } else if (const auto* springs = std::get_if<Springs>(&force)) {
      const Parameter& rest = springs->rest_length;
      const bool has_rest = rest.is_initial() || rest.constants != std::vector{0.0};
      Group& group = add_group(record_spring(springs->stiffness, springs->damping, has_rest), 2, springs->damping > 0.0,
                               has_rest ? 1 : 0);
      for (std::size_t k = 0; k < springs->pairs.size(); ++k) {
        const auto [i, j] = springs->pairs[k];
        const auto pick = [k](const auto& each) { return each[each.size() == 1 ? 0 : k]; };
        std::vector<std::size_t> slots;
        if (has_rest) {
          const double length = rest.is_initial()
                                    ? norm(load(system.positions.data(), j) - load(system.positions.data(), i))
                                : rest.functions.empty() ? pick(rest.constants)
                                                         : pick(rest.functions)(0.0).value();
          slots.push_back(table_.add(length));
        }
        add_member(group, {inner(i), inner(j)}, slots);
      }
    } else if (const auto* drag = std::get_if<Drag>(&force)) {
      Group& group = add_group(record_drag(drag->linear, drag->quadratic), 1, true, 0);
      for (const Index point : drag->points) add_member(group, {inner(point)}, {});
    } else if (const auto* formula = std::get_if<FormulaForce>(&force); formula && formula->kernel.expression) {
      Group& group = add_group(*formula->kernel.expression, 1, true, 1);
      const std::size_t time = table_.add(ScalarFunction::formula("t"));
      for (const Index point : formula->points) add_member(group, {inner(point)}, std::span(&time, 1));
    } else {
      const bool is_pairs = std::holds_alternative<PairForces>(force);
      obstacle_ = "forces[" + text(g) + "] cannot be expanded in time: " +
                  (is_pairs ? "pair forces have no series" : "it is known as a function alone");
    }
  }
  if (obstacle_.empty() && table_.has_unknown(t0)) obstacle_ = "a force is known as a function of time alone";
  std::erase_if(groups_, [](const Group& group) { return group.family.size() == 0; });
}

void ForceSeries::begin(double t, int order) {
  table_.expand(t, order);
  for (Group& group : groups_) group.family.resize(order);
}

void ForceSeries::advance(const Parallel& parallel, int k, std::span<double* const> coefficients, double* blocks) {
  for (Group& group : groups_) {
    ProgramFamily& family = group.family;
    const SeriesProgram& program = family.program();
    parallel.for_ranges(
        family.num_chunks(),
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t chunk = begin; chunk < end; ++chunk) {
            family.load(chunk, k, coefficients, table_);
            SeriesLane* const lanes = family.lanes(chunk);
            program.evaluate(lanes, family.order(), k);
            const std::size_t first = chunk * series_width, count = std::min(series_width, family.size() - first);
            const auto force = [&](std::size_t c, std::size_t lane) {
              return program.result(lanes, family.order(), c)[k][lane];
            };
            for (std::size_t lane = 0; lane < count; ++lane) {
              store(blocks, static_cast<std::size_t>(group.first_block) + first + lane,
                    {force(0, lane), force(1, lane), force(2, lane)});
            }
          }
        },
        16);
  }
}

}  // namespace tanor
