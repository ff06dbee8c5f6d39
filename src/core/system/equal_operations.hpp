#pragma once

#include <map>
#include <tuple>
#include <vector>

#include <tanor/expression.hpp>

namespace tanor::detail {

/// Returns the same expression with equal operations on equal operands performed once. A sine and its cosine stay a
/// pair. Formulas of several components have most of their operations in common.
inline Expression join_equal_operations(const Expression& given) {
  Expression result;
  std::map<std::tuple<Expression::Operation, int, int, int, double>, int> known;
  std::vector<int> place;
  for (const Expression::Instruction& before : given.instructions) {
    Expression::Instruction instruction = before;
    const auto follow = [&](int* operand) { *operand = place.empty() ? 0 : place[static_cast<std::size_t>(*operand)]; };
    for (int* operand : {&instruction.a, &instruction.b, &instruction.c}) follow(operand);
    const int next = static_cast<int>(result.instructions.size());
    if (instruction.operation != Expression::Operation::Variable) {
      const auto [entry, is_new] = known.emplace(
          std::tuple{instruction.operation, instruction.a, instruction.b, instruction.c, instruction.constant}, next);
      place.push_back(entry->second);
      if (!is_new) continue;
    } else {
      place.push_back(next);
    }
    result.instructions.push_back(instruction);
  }
  for (const int variable : given.variables) result.variables.push_back(place[static_cast<std::size_t>(variable)]);
  for (const int number : given.results) result.results.push_back(place[static_cast<std::size_t>(number)]);
  return result;
}

}  // namespace tanor::detail
