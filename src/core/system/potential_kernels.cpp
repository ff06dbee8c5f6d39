#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <tanor/curved.hpp>
#include <tanor/error.hpp>
#include <tanor/forward.hpp>
#include <tanor/recorded.hpp>

#include "base/text.hpp"
#include "system/formula.hpp"
#include "system/formula_names.hpp"
#include "system/operations.hpp"

/// \file Energies of tuples, as text and as recorded operations.
namespace tanor {
using namespace detail;

namespace {

/// The context of an energy by its operations.
struct Energy {
  std::shared_ptr<const Expression> expression;
  std::size_t size, num_constants;  // 3p, numbers of a member
};

/// Evaluates one member with numbers of type T. variable(i, x) makes number i a variable of differentiation, or a
/// constant.
template <class T, class Variable>
T evaluate_member(const Energy& of, const PotentialBatch& batch, std::size_t k, const Variable& variable) {
  thread_local std::vector<T> values;
  const Expression& expression = *of.expression;
  values.resize(std::max(values.size(), expression.instructions.size()));
  for (std::size_t i = 0; i < expression.variables.size(); ++i) {
    const bool is_time = i == of.size + of.num_constants;
    values[static_cast<std::size_t>(expression.variables[i])] =
        variable(i, is_time       ? batch.t
                    : i < of.size ? batch.r[of.size * k + i]
                                  : batch.constants[of.num_constants * k + i - of.size]);
  }
  for (std::size_t i = 0; i < expression.instructions.size(); ++i) {
    const Expression::Instruction& instruction = expression.instructions[i];
    if (instruction.operation != Expression::Operation::Variable) values[i] = perform(instruction, values);
  }
  return values[static_cast<std::size_t>(expression.results[0])];
}

/// Evaluates with the derivatives in the coordinates of points a and b.
Curved<6> evaluate_curved(const Energy& of, const PotentialBatch& batch, std::size_t k, std::size_t a, std::size_t b) {
  return evaluate_member<Curved<6>>(of, batch, k, [&](std::size_t i, double x) {
    const int first = i < of.size && i / 3 == a ? 0 : i < of.size && i / 3 == b ? 3 : -1;
    return first < 0 ? Curved<6>(x) : Curved<6>::variable(x, first + static_cast<int>(i % 3));
  });
}

void evaluate_hessian(const Energy& of, const PotentialBatch& batch, std::size_t k) {
  double* const hessian = batch.hessian + of.size * of.size * k;
  const auto write = [&](const Curved<6>& u, std::size_t a, std::size_t first, std::size_t b, std::size_t second) {
    for (std::size_t entry = 0; entry < 9; ++entry) {
      const double value = u.second(first + entry / 3, second + entry % 3);
      hessian[(3 * a + entry / 3) * of.size + 3 * b + entry % 3] = value;
      hessian[(3 * b + entry % 3) * of.size + 3 * a + entry / 3] = value;
    }
  };
  const std::size_t p = of.size / 3;
  for (std::size_t a = 0; a < p; ++a) {
    write(evaluate_curved(of, batch, k, a, a), a, 0, a, 0);
    for (std::size_t b = a + 1; b < p; ++b) write(evaluate_curved(of, batch, k, a, b), a, 0, b, 3);
  }
}

void evaluate_potential(const void* context, const PotentialBatch& batch) {
  const auto& of = *static_cast<const Energy*>(context);
  for (std::size_t k = 0; k < batch.count; ++k) {
    batch.energy[k] = evaluate_member<double>(of, batch, k, [](std::size_t, double x) { return x; });
    for (std::size_t first = 0; first < of.size && batch.gradient != nullptr; first += 3) {
      const auto u = evaluate_member<Forward<3>>(of, batch, k, [&](std::size_t i, double x) {
        return first <= i && i < first + 3 ? Forward<3>::variable(x, static_cast<int>(i - first)) : Forward<3>(x);
      });
      std::copy_n(u.d.begin(), 3, batch.gradient + of.size * k + first);
    }
    if (batch.hessian != nullptr) evaluate_hessian(of, batch, k);
    if (batch.rate == nullptr) continue;
    const auto u = evaluate_member<Forward<1>>(of, batch, k, [&](std::size_t i, double x) {
      return i == of.size + of.num_constants ? Forward<1>::variable(x, 0) : Forward<1>(x);
    });
    batch.rate[k] = u.d[0];
  }
}

void check_num_points(int num_points) {
  if (num_points < 1 || num_points > PotentialKernel::most_points) {
    throw InputError("", "an energy of " + text_of_count(num_points, "point") + "; 1 to " +
                             text(PotentialKernel::most_points) + " are right");
  }
}

/// Throws if the text would be a valid energy if it could read velocities.
void refuse_velocities(std::string_view energy, int num_points, std::vector<std::string> variables,
                       const Constants& constants) {
  const std::size_t first = variables.size();
  std::vector<std::string> velocities{"vx", "vy", "vz"};
  for (const std::string& name : name_coordinates(num_points)) velocities.push_back("v" + name);
  for (const std::string& name : velocities) {
    if (!constants.contains(name) && std::ranges::count(variables, name) == 0) variables.push_back(name);
  }
  const auto find_velocity = [&]() -> std::string {
    try {
      const Formula formula(energy, variables, constants);
      for (std::size_t i = first; i < variables.size(); ++i) {
        if (formula.depends_on(static_cast<int>(i))) return variables[i];
      }
    } catch (const InputError&) {  // this error is reported where the text is parsed as what it is
    }
    return {};
  };
  const std::string found = find_velocity();
  if (!found.empty())
    throw InputError("", "'" + found + "': a potential depends on positions and time; use kind formula");
}

}  // namespace

PotentialKernel formula_potential(std::string_view energy, int num_points, const Constants& constants,
                                  std::span<const std::string> own_constants) {
  check_num_points(num_points);
  std::vector<std::string> variables = name_coordinates(num_points);
  for (const std::string& name : own_constants) {
    if (!is_variable_name(name) || name == "t" || constants.contains(name) || std::ranges::count(variables, name) > 0)
      throw InputError("/constants/" + name,
                       "the constant '" + show_name(name) + "' has a name that is taken or is none");
    variables.push_back(name);
  }
  variables.emplace_back("t");
  refuse_velocities(energy, num_points, variables, constants);
  const Formula formula(energy, variables, constants);
  auto recorded = record_expression(static_cast<int>(variables.size()), [&](const std::vector<Traced>& x) {
    return std::vector{formula.evaluate(std::span(x))};
  });
  return expression_potential(std::move(recorded), num_points, static_cast<int>(own_constants.size()));
}

PotentialKernel expression_potential(std::shared_ptr<const Expression> energy, int num_points, int num_constants) {
  check_num_points(num_points);
  const int size = 3 * num_points;
  if (num_constants < 0 || energy == nullptr || energy->results.size() != 1 ||
      energy->variables.size() != static_cast<std::size_t>(size + num_constants + 1)) {
    throw InputError("", "the operations of an energy of " + text_of_count(num_points, "point") + " and " +
                             text_of_count(num_constants, "constant") + " have one result and " +
                             text(size + num_constants + 1) + " variables");
  }
  PotentialKernel kernel{.num_points = num_points, .num_constants = num_constants, .evaluate = evaluate_potential};
  const int time = energy->variables.back();
  kernel.depends_on_time = energy->results[0] == time ||
                           std::ranges::any_of(energy->instructions, [&](const Expression::Instruction& instruction) {
                             return instruction.a == time || instruction.b == time;
                           });
  kernel.expression = energy;
  kernel.context = std::make_shared<const Energy>(
      Energy{std::move(energy), static_cast<std::size_t>(size), static_cast<std::size_t>(num_constants)});
  return kernel;
}

}  // namespace tanor
