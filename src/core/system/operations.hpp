#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <tanor/recorded.hpp>

namespace tanor::detail {

/// Returns how many operands an operation reads; any other is there for series alone.
constexpr int num_operands(Expression::Operation operation) {
  using enum Expression::Operation;
  if (operation == Variable || operation == Constant) return 0;
  const bool has_two = (operation >= Add && operation <= Divide) || operation == Atan2;
  return has_two || operation == Min || operation == Max ? 2 : 1;
}

/// Returns the result of a recorded operation on `values` of those before it. The value of a variable is there already.
template <class T>
T perform(const Expression::Instruction& instruction, const std::vector<T>& values) {
  using Operation = Expression::Operation;
  using std::sqrt, std::exp, std::log, std::sin, std::cos, std::sinh, std::cosh, std::asin, std::atan, std::atan2,
      std::abs, std::min, std::max;
  const T& a = values[static_cast<std::size_t>(instruction.a)];
  const T& b = values[static_cast<std::size_t>(instruction.b)];
  // clang-format off
  switch (instruction.operation) {
    case Operation::Variable: break;  // it is there already
    case Operation::Constant: return T(instruction.constant);
    case Operation::Scale: return instruction.constant * a;
    case Operation::Shift: return a + T(instruction.constant);
    case Operation::Add: return a + b;
    case Operation::Subtract: return a - b;
    case Operation::Multiply: return a * b;
    case Operation::Divide: return a / b;
    case Operation::Sqrt: return sqrt(a);
    case Operation::Exp: return exp(a);
    case Operation::Log: return log(a);
    case Operation::Sin: return sin(a);
    case Operation::Cos: return cos(a);
    case Operation::Sinh: return sinh(a);
    case Operation::Cosh: return cosh(a);
    case Operation::Asin: return asin(a);
    case Operation::Atan: return atan(a);
    case Operation::Atan2: return atan2(a, b);
    case Operation::Abs: return abs(a);
    case Operation::Min: return min(a, b);
    case Operation::Max: return max(a, b);
  }
  // clang-format on
  return T(0.0);
}

/// Computes `values` of all instructions of an expression; variable(i) is that of the i-th variable.
template <class T, class Variable>
void perform_all(const Expression& expression, const Variable& variable, std::vector<T>* values) {
  values->resize(std::max(values->size(), expression.instructions.size()));
  for (std::size_t i = 0; i < expression.variables.size(); ++i)
    (*values)[static_cast<std::size_t>(expression.variables[i])] = variable(i);
  for (std::size_t i = 0; i < expression.instructions.size(); ++i) {
    const Expression::Instruction& instruction = expression.instructions[i];
    if (instruction.operation != Expression::Operation::Variable) (*values)[i] = perform(instruction, *values);
  }
}

}  // namespace tanor::detail
