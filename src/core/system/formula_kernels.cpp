#include <algorithm>
#include <utility>
#include <vector>

#include <tanor/error.hpp>
#include <tanor/user_kernel.hpp>

#include "base/text.hpp"
#include "system/formula.hpp"
#include "system/formula_names.hpp"
#include "system/lanes.hpp"

namespace tanor {
using namespace detail;

namespace {

constexpr std::size_t width = Lanes<double>::width;

/// Calls visit(rows) for each group of `width` rows of a batch. The last group is filled up with the last row.
template <class Visit>
void for_each_group(std::size_t count, const Visit& visit) {
  std::array<std::size_t, width> rows;
  for (std::size_t first = 0; first < count; first += width) {
    for (std::size_t lane = 0; lane < width; ++lane) rows[lane] = std::min(first + lane, count - 1);
    visit(rows);
  }
}
using Rows = std::array<std::size_t, width>;

/// Copy column `i` of rows that are `stride` long to a coefficient of the lanes, and back.
void gather(const double* array, const Rows& rows, std::size_t stride, std::size_t i, double* lanes) {
  for (std::size_t lane = 0; lane < width; ++lane) lanes[lane] = array[rows[lane] * stride + i];
}
void scatter(const double* lanes, const Rows& rows, std::size_t stride, std::size_t i, double* array) {
  for (std::size_t lane = 0; lane < width; ++lane) array[rows[lane] * stride + i] = lanes[lane];
}

/// The variables of a formula for one group of rows: the columns of x, those of `more`, then the time.
struct Variables {
  const double *x, *more;
  double t;
  const Rows& rows;
  std::size_t width, n;  // columns of each array, and of both

  Variables(const double* array, double time, const Rows& of, std::size_t count)
      : x(array), more(nullptr), t(time), rows(of), width(count), n(count) {}
  explicit Variables(const ForceBatch& batch, const Rows& of, std::size_t size)
      : x(batch.r), more(batch.v), t(batch.t), rows(of), width(size), n(2 * size) {}

  /// Loads the value. Its derivatives, if there are any, are 0.
  template <class T>
  void load(std::size_t i, Lanes<T>* a) const {
    a->fill(t);
    if (i < n) gather(i < width ? x : more, rows, width, i % width, a->c[0]);
  }
};

/// Evaluates the formula. seed(i, a) sets the derivatives of variable i, which are 0 before.
template <class T, class Seed>
Lanes<T> evaluate(const Formula& formula, const Variables& variables, const Seed& seed) {
  return formula.evaluate_loading<Lanes<T>>([&](int variable, Lanes<T>* a) {
    variables.load(static_cast<std::size_t>(variable), a);
    seed(static_cast<std::size_t>(variable), a);
  });
}

Lanes<double> evaluate_values(const Formula& formula, const Variables& variables) {
  return evaluate<double>(formula, variables, [](std::size_t, Lanes<double>*) {});
}

/// Writes the value of a formula, and its first two derivatives along (x + e x_dot, t + e) unless `first` is null, row
/// by row, to column i of arrays with rows that are `stride` long.
void scatter_along(const Formula& formula, const Variables& variables, const double* x_dot, std::size_t stride,
                   std::size_t i, double* value, double* first, double* second) {
  if (first == nullptr) return scatter(evaluate_values(formula, variables).c[0], variables.rows, stride, i, value);
  Lanes<Jet<2>> jets = evaluate<Jet<2>>(formula, variables, [&](std::size_t k, Lanes<Jet<2>>* a) {
    if (k < variables.n)
      gather(x_dot, variables.rows, variables.n, k, a->c[1]);
    else
      std::ranges::fill(a->c[1], 1.0);
  });
  for (double& each : jets.c[2]) each *= 2.0;
  for (const auto& [lanes, to] : {std::pair{jets.c[0], value}, {jets.c[1], first}, {jets.c[2], second}})
    scatter(lanes, variables.rows, stride, i, to);
}

/// Writes the partial derivatives of a formula in its n variables, row by row, to derivatives[row * stride]. A pass
/// takes three variables; those that do not occur cost nothing.
void scatter_partials(const Formula& formula, const Variables& variables, std::size_t stride, std::size_t step,
                      double* derivatives) {
  const std::size_t n = variables.n;
  for (std::size_t first = 0; first < n; first += 3) {
    const std::size_t last = std::min(first + 3, n);
    bool occur = false;
    for (std::size_t i = first; i < last; ++i) occur = occur || formula.depends_on(static_cast<int>(i));
    Lanes<Forward<3>> value(0.0);
    if (occur)
      value = evaluate<Forward<3>>(formula, variables, [&](std::size_t i, Lanes<Forward<3>>* a) {
        if (first <= i && i < last) std::ranges::fill(a->c[1 + i - first], 1.0);
      });
    for (std::size_t i = first; i < last; ++i)
      scatter(value.c[1 + i - first], variables.rows, stride, step * i, derivatives);
  }
}

// ---- constraints and coordinates -----------------------------------------------------------------------------------

/// Formulas of the numbers x and the time, with the derivatives along (x + e x_dot, t + e) and the partial ones.
struct Map {
  std::vector<Formula> components;
  std::size_t num_variables;
};
void evaluate_map(const Map& map, const MapBatch& batch) {
  const std::size_t size = map.components.size();
  for_each_group(batch.count, [&](const Rows& rows) {
    const Variables variables(batch.x, batch.t, rows, map.num_variables);
    for (std::size_t i = 0; i < size; ++i) {
      const Formula& formula = map.components[i];
      scatter_along(formula, variables, batch.x_dot, size, i, batch.value, batch.first, batch.second);
      if (batch.partials != nullptr)
        scatter_partials(formula, variables, map.num_variables * size, size, batch.partials + i);
    }
  });
}

void evaluate_constraint(const void* context, const ConstraintBatch& batch) {
  evaluate_map(*static_cast<const Map*>(context),
               {batch.count, batch.t, batch.r, batch.v, batch.xi, batch.rate, batch.phi, batch.gradient});
}

void evaluate_coordinates(const void* context, const CoordinateBatch& batch) {
  evaluate_map(*static_cast<const Map*>(context),
               {batch.count, batch.t, batch.q, batch.q_dot, batch.r, batch.v, batch.psi, batch.tangents});
}

void check_names(std::span<const std::string> names, const Constants& constants) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& name = names[i];
    if (name == "t" || std::ranges::count(names, name) > 1 || constants.contains(name)) {
      throw InputError("", "the coordinate '" + name + "' has the name of " +
                               (name == "t"                ? "time"
                                : constants.contains(name) ? "a constant"
                                                           : "another coordinate"));
    }
    if (!is_variable_name(name)) {
      throw InputError("", "the coordinate '" + show_name(name) +
                               "' has no name of letters, digits and '_' that is neither a function nor pi");
    }
  }
}

// ---- forces --------------------------------------------------------------------------------------------------------

using ForceFormulas = std::vector<Formula>;

/// Evaluates values alone, row by row.
void evaluate_forces_of_few(const ForceFormulas& formulas, const ForceBatch& batch) {
  const std::size_t size = formulas.size();
  for (std::size_t row = 0; row < batch.count; ++row) {
    const auto load = [&, r = batch.r + row * size, v = batch.v + row * size](int variable, double* x) {
      const auto i = static_cast<std::size_t>(variable);
      *x = i < size ? r[i] : i < 2 * size ? v[i - size] : batch.t;
    };
    for (std::size_t component = 0; component < size; ++component)
      batch.f[row * size + component] = formulas[component].evaluate_loading<double>(load);
  }
}

void evaluate_force(const void* context, const ForceBatch& batch) {
  constexpr std::size_t few = 4;  // rows that cost less one by one, with the same bits
  const auto& formulas = *static_cast<const ForceFormulas*>(context);
  const std::size_t size = formulas.size();  // 3p
  if (batch.count <= few && batch.derivative == nullptr) return evaluate_forces_of_few(formulas, batch);
  for_each_group(batch.count, [&](const Rows& rows) {
    const Variables variables(batch, rows, size);
    for (std::size_t component = 0; component < size; ++component) {
      const Formula& formula = formulas[component];
      scatter(evaluate_values(formula, variables).c[0], rows, size, component, batch.f);
      if (batch.derivative == nullptr) continue;
      scatter_partials(formula, variables, 2 * size * size, 1, batch.derivative + 2 * size * component);
    }
  });
}

/// Records formulas of so many variables.
std::shared_ptr<const Expression> record(std::size_t num_variables, std::span<const Formula> formulas) {
  return record_expression(static_cast<int>(num_variables), [&](const std::vector<Traced>& x) {
    std::vector<Traced> results;
    for (const Formula& formula : formulas) results.push_back(formula.evaluate(std::span(x)));
    return results;
  });
}

/// Parses a formula. An error gets the place of the text.
Formula parse_at(const std::string& place, std::string_view text, std::span<const std::string> variables,
                 const Constants& constants) {
  try {
    return Formula(text, variables, constants);
  } catch (const InputError& error) {
    throw InputError(place, error.what());
  }
}

}  // namespace

ConstraintKernel formula_constraint(std::string_view equation, int num_points, const Constants& constants) {
  if (num_points < 1 || num_points > ConstraintKernel::most_points) {
    throw InputError("", "a formula on " + text_of_count(num_points, "point") + "; 1 to " +
                             text(ConstraintKernel::most_points) + " are right");
  }
  std::vector<std::string> variables = name_coordinates(num_points);
  const std::size_t num_variables = variables.size();
  variables.emplace_back("t");
  Formula formula(equation, variables, constants);
  ConstraintKernel kernel{.num_points = num_points, .evaluate = evaluate_constraint};
  kernel.expression = record(variables.size(), {&formula, 1});
  kernel.depends_on_time = formula.depends_on(static_cast<int>(num_variables));
  kernel.context = std::make_shared<const Map>(Map{{std::move(formula)}, num_variables});
  return kernel;
}

CoordinateKernel formula_coordinates(std::span<const std::string> names, std::span<const std::string> components,
                                     const Constants& constants) {
  if (names.empty()) throw InputError("", "there are no coordinates; a map has at least one");
  if (components.empty() || components.size() % 3 != 0) {
    throw InputError("", text_of_count(components.size(), "component") + "; three for each point are right");
  }
  check_names(names, constants);
  std::vector<std::string> variables(names.begin(), names.end());
  variables.emplace_back("t");
  CoordinateKernel kernel{.num_points = static_cast<int>(components.size() / 3),
                          .num_coordinates = static_cast<int>(names.size()),
                          .evaluate = evaluate_coordinates,
                          .depends_on_time = false};
  Map formulas{{}, names.size()};
  for (std::size_t i = 0; i < components.size(); ++i) {
    formulas.components.push_back(parse_at("/" + text(i), components[i], variables, constants));
    const bool has_time = formulas.components.back().depends_on(kernel.num_coordinates);
    kernel.depends_on_time = kernel.depends_on_time || has_time;
  }
  kernel.expression = record(variables.size(), formulas.components);
  kernel.context = std::make_shared<const Map>(std::move(formulas));
  return kernel;
}

namespace {

/// Makes a force of the text of each component. The second half of the variables are velocities, and the last one is
/// time.
ForceKernel make_formula_force(std::span<const std::string> components, std::span<const std::string> places,
                               const std::vector<std::string>& variables, const Constants& constants) {
  ForceKernel kernel{.num_points = static_cast<int>(components.size() / 3),
                     .evaluate = evaluate_force,
                     .depends_on_velocity = false,
                     .depends_on_time = false,
                     .knows_derivatives = true};
  ForceFormulas formulas;
  for (std::size_t k = 0; k < components.size(); ++k) {
    formulas.push_back(parse_at(places[k], components[k], variables, constants));
    for (std::size_t i = components.size(); i + 1 < variables.size(); ++i)
      kernel.depends_on_velocity = kernel.depends_on_velocity || formulas.back().depends_on(static_cast<int>(i));
    kernel.depends_on_time =
        kernel.depends_on_time || formulas.back().depends_on(static_cast<int>(variables.size()) - 1);
  }
  kernel.expression = record(variables.size(), formulas);
  kernel.context = std::make_shared<const ForceFormulas>(std::move(formulas));
  return kernel;
}

}  // namespace

ForceKernel formula_force(const std::array<std::string, 3>& components, const Constants& constants) {
  return make_formula_force(components, std::array<std::string, 3>{"/x", "/y", "/z"},
                            {"x", "y", "z", "vx", "vy", "vz", "t"}, constants);
}

ForceKernel formula_tuple_force(std::span<const std::string> components, const Constants& constants) {
  const std::size_t num_points = components.size() / 3;
  if (components.size() % 3 != 0 || num_points < 1 || num_points > ForceKernel::most_points) {
    throw InputError("", text_of_count(components.size(), "component") + "; three for each of 1 to " +
                             text(ForceKernel::most_points) + " points are right");
  }
  const std::vector<std::string> coordinates = name_coordinates(static_cast<int>(num_points));
  std::vector<std::string> places, variables = coordinates;
  for (const std::string& name : coordinates) {
    places.push_back("/" + name);
    variables.push_back("v" + name);
  }
  variables.emplace_back("t");
  return make_formula_force(components, places, variables, constants);
}

}  // namespace tanor
