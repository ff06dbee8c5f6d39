#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <tanor/error.hpp>
#include <tanor/recorded.hpp>
#include <tanor/user_kernel.hpp>

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

void evaluate_potential(const void* context, const PotentialBatch& batch) {
  const auto& of = *static_cast<const Energy*>(context);
  evaluate_energies(batch, of.size / 3, of.num_constants, [&]<class T>(const auto& x) {
    thread_local std::vector<T> values;
    perform_all(*of.expression, x, &values);
    return values[static_cast<std::size_t>(of.expression->results[0])];
  });
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
