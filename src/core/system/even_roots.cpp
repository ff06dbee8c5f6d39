#include "system/even_roots.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace tanor::detail {

namespace {

using FormulaOperation = Formula::Operation;
using FormulaStep = Formula::Instruction;
using Operand = std::span<const FormulaStep>;

int count_operands(FormulaOperation operation) {
  return operation >= FormulaOperation::Add ? 2 : operation >= FormulaOperation::Negate ? 1 : 0;
}

/// Returns the operand at the end of a program.
Operand last_operand(Operand program) {
  std::size_t first = program.size();
  for (int wanted = 1; wanted > 0;) wanted += count_operands(program[--first].operation) - 1;
  return program.subspan(first);
}

bool are_same_operands(Operand one, Operand other) {
  return std::ranges::equal(one, other, [](const FormulaStep& a, const FormulaStep& b) {
    return a.operation == b.operation && a.operand == b.operand && a.constant == b.constant;
  });
}

bool is_even(double exponent) {
  return std::remainder(exponent, 2.0) == 0.0;
}

/// c times powers of operands.
struct Product {
  struct Factor {
    Operand base;
    double exponent;
  };
  double c = 1.0;
  std::vector<Factor> factors;

  /// Multiplies by the power of an operand with an integer exponent.
  void multiply(Operand by, double exponent) {
    const FormulaStep& last = by.back();
    const Operand rest = by.first(by.size() - 1);
    switch (last.operation) {
      case FormulaOperation::Constant:
        c *= std::pow(last.constant, exponent);
        return;
      case FormulaOperation::Negate:
        c *= is_even(exponent) ? 1.0 : -1.0;
        return multiply(rest, exponent);
      case FormulaOperation::IntegerPower:
        return multiply(rest, exponent * last.operand);
      case FormulaOperation::Multiply:
      case FormulaOperation::Divide: {
        const Operand second = last_operand(rest);
        multiply(rest.first(rest.size() - second.size()), exponent);
        return multiply(second, last.operation == FormulaOperation::Multiply ? exponent : -exponent);
      }
      default:
        break;
    }
    const auto known =
        std::ranges::find_if(factors, [&](const Factor& factor) { return are_same_operands(factor.base, by); });
    if (known == factors.end())
      factors.push_back({by, exponent});
    else
      known->exponent += exponent;
  }
};

}  // namespace

bool append_even_root(double p, std::vector<FormulaStep>* program) {
  const Operand operand = last_operand(*program);
  Product product;
  product.multiply(operand, 1.0);
  const auto is_root = [](const Product::Factor& factor) { return factor.exponent != 0.0 && is_even(factor.exponent); };
  if (!(product.c > 0.0) || product.factors.empty() || !std::ranges::all_of(product.factors, is_root)) return false;
  std::vector<FormulaStep> result(program->begin(), program->end() - static_cast<std::ptrdiff_t>(operand.size()));
  for (const auto& [base, exponent] : product.factors) {
    const bool is_first = &base == &product.factors.front().base;
    const double power = exponent * p;
    result.insert(result.end(), base.begin(), base.end());
    if (!is_even(power)) result.push_back({FormulaOperation::Abs});
    if (detail::is_small_integer(power)) {
      if (power != 1.0) result.push_back({FormulaOperation::IntegerPower, static_cast<int>(power)});
    } else {
      result.push_back({FormulaOperation::Constant, 0, power});
      result.push_back({FormulaOperation::Power});
    }
    if (!is_first) result.push_back({FormulaOperation::Multiply});
  }
  if (product.c != 1.0) {
    result.push_back({FormulaOperation::Constant, 0, std::pow(product.c, p)});
    result.push_back({FormulaOperation::Multiply});
  }
  *program = std::move(result);
  return true;
}

}  // namespace tanor::detail
