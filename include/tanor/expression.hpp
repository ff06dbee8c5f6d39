#pragma once

/// \file
/// A function written once over a scalar type, recorded as a list of operations.
///
/// The recording is evaluated coefficient by coefficient on series in time, forwards for values and backwards for
/// gradients, many members side by side (method `taylor`). A callable that compares its arguments cannot be recorded,
/// since its branch depends on numbers; `abs`, `min` and `max` can.

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include <tanor/jet.hpp>

namespace tanor {

/// Operations in the order of their evaluation.
struct Expression {
  // clang-format off
  enum class Operation : std::uint8_t {
    Variable, Constant,               // constant
    Scale, Shift,                     // a * constant, a + constant
    Add, Subtract, Multiply, Divide,  // operands a and b
    Sqrt, Exp, Log,                   // operand a
    Sin, Cos, Sinh, Cosh,             // operand a, always both of a pair, one after the other
    Asin, Atan,                       // operand a; b is 1/derivative, sqrt(1 - a^2) or 1 + a^2
    Atan2,                            // operands a (y) and b (x); c is x^2 + y^2
    Abs, Min, Max,                    // operand a (and b), by their values
  };
  // clang-format on

  struct Instruction {
    Operation operation;
    int a = 0, b = 0, c = 0;  ///< numbers of earlier instructions
    double constant = 0.0;
  };

  std::vector<Instruction> instructions;
  std::vector<int> variables, results;  ///< numbers of instructions
};

namespace detail {

/// Thrown when a callable asks for the value of a variable, which has none during recording.
struct NotTraceable : std::logic_error {
  NotTraceable() : std::logic_error("a function that compares its arguments has no expression") {}
};

}  // namespace detail

/// A number that records the operations on it. Operations on constants are computed at once.
class Traced {
 public:
  using Operation = Expression::Operation;

  Traced() = default;
  Traced(double constant) : constant_(constant) {}  // NOLINT(google-explicit-constructor): constants are numbers

  /// Adds a variable to the expression, which has to outlive it.
  static Traced variable(Expression& expression) {
    expression.variables.push_back(append(expression, {.operation = Operation::Variable}));
    return {expression, expression.variables.back()};
  }

  bool is_constant() const { return expression_ == nullptr; }
  double value() const {
    if (!is_constant()) throw detail::NotTraceable();
    return constant_;
  }
  /// Returns its number among the instructions of `expression`; a constant is appended as an instruction.
  int number_in(Expression& expression) const {
    return is_constant() ? append(expression, {.operation = Operation::Constant, .constant = constant_}) : number_;
  }

  Traced& operator+=(const Traced& b) { return *this = *this + b; }
  Traced& operator-=(const Traced& b) { return *this = *this - b; }
  Traced& operator*=(const Traced& b) { return *this = *this * b; }
  Traced& operator/=(const Traced& b) { return *this = *this / b; }

  friend Traced operator+(const Traced& a) { return a; }
  friend Traced operator-(const Traced& a) { return a.scaled(-1.0); }
  friend Traced operator+(const Traced& a, const Traced& b) {
    if (a.is_constant()) return b.shifted(a.constant_);
    if (b.is_constant()) return a.shifted(b.constant_);
    return a.combined(Operation::Add, b);
  }
  friend Traced operator-(const Traced& a, const Traced& b) {
    if (b.is_constant()) return a.shifted(-b.constant_);
    if (a.is_constant()) return b.scaled(-1.0).shifted(a.constant_);
    return a.combined(Operation::Subtract, b);
  }
  friend Traced operator*(const Traced& a, const Traced& b) {
    if (a.is_constant()) return b.scaled(a.constant_);
    if (b.is_constant()) return a.scaled(b.constant_);
    return a.combined(Operation::Multiply, b);
  }
  friend Traced operator/(const Traced& a, const Traced& b) {
    if (b.is_constant()) return a.is_constant() ? Traced(a.constant_ / b.constant_) : a.scaled(1.0 / b.constant_);
    return a.combined(Operation::Divide, b);
  }

  friend bool operator==(const Traced& a, const Traced& b) { return a.value() == b.value(); }
  friend std::partial_ordering operator<=>(const Traced& a, const Traced& b) { return a.value() <=> b.value(); }

  friend Traced sqrt(const Traced& a) {
    return a.alone(Operation::Sqrt, [](double x) { return std::sqrt(x); });
  }
  friend Traced exp(const Traced& a) {
    return a.alone(Operation::Exp, [](double x) { return std::exp(x); });
  }
  friend Traced log(const Traced& a) {
    return a.alone(Operation::Log, [](double x) { return std::log(x); });
  }
  friend Traced sin(const Traced& a) {
    return a.is_constant() ? Traced(std::sin(a.constant_)) : a.pair(Operation::Sin, Operation::Cos).first;
  }
  friend Traced cos(const Traced& a) {
    return a.is_constant() ? Traced(std::cos(a.constant_)) : a.pair(Operation::Sin, Operation::Cos).second;
  }
  friend Traced tan(const Traced& a) { return sin(a) / cos(a); }
  friend Traced sinh(const Traced& a) {
    return a.is_constant() ? Traced(std::sinh(a.constant_)) : a.pair(Operation::Sinh, Operation::Cosh).first;
  }
  friend Traced cosh(const Traced& a) {
    return a.is_constant() ? Traced(std::cosh(a.constant_)) : a.pair(Operation::Sinh, Operation::Cosh).second;
  }
  friend Traced tanh(const Traced& a) { return sinh(a) / cosh(a); }
  friend Traced asin(const Traced& a) {
    if (a.is_constant()) return std::asin(a.constant_);
    return a.combined(Operation::Asin, sqrt((1.0 - a) * (1.0 + a)));
  }
  friend Traced acos(const Traced& a) {
    if (a.is_constant()) return std::acos(a.constant_);
    return 1.5707963267948966 - asin(a);
  }
  friend Traced atan(const Traced& a) {
    return a.is_constant() ? Traced(std::atan(a.constant_)) : a.combined(Operation::Atan, 1.0 + a * a);
  }
  friend Traced atan2(const Traced& y, const Traced& x) {
    if (y.is_constant() && x.is_constant()) return std::atan2(y.constant_, x.constant_);
    return y.combined(Operation::Atan2, x, x * x + y * y);
  }
  friend Traced abs(const Traced& a) {
    return a.alone(Operation::Abs, [](double x) { return std::abs(x); });
  }
  friend Traced min(const Traced& a, const Traced& b) { return a.chosen(Operation::Min, b); }
  friend Traced max(const Traced& a, const Traced& b) { return a.chosen(Operation::Max, b); }
  friend Traced pow(const Traced& a, double p) {
    if (a.is_constant()) return std::pow(a.constant_, p);
    if (detail::is_small_integer(p)) return detail::signed_integer_power(a, static_cast<int>(p));
    return p == 0.5 ? sqrt(a) : exp(p * log(a));
  }
  friend Traced pow(const Traced& a, const Traced& b) {
    return b.is_constant() ? pow(a, b.constant_) : exp(b * log(a));
  }
  friend Traced pow(double a, const Traced& b) { return pow(Traced(a), b); }

 private:
  Traced(Expression& expression, int number) : expression_(&expression), number_(number) {}

  static int append(Expression& expression, const Expression::Instruction& instruction) {
    expression.instructions.push_back(instruction);
    return static_cast<int>(expression.instructions.size()) - 1;
  }
  template <class Function>
  Traced alone(Operation operation, const Function& of_constant) const {
    if (is_constant()) return of_constant(constant_);
    return appended({.operation = operation, .a = number_});
  }
  Traced appended(const Expression::Instruction& instruction) const {
    return {*expression_, append(*expression_, instruction)};
  }
  Traced combined(Operation operation, const Traced& b) const { return combined(operation, b, Traced(0.0)); }
  Traced combined(Operation operation, const Traced& b, const Traced& c) const {
    Expression& expression = is_constant() ? *b.expression_ : *expression_;
    const int first = number_in(expression), second = b.number_in(expression);
    const int third = c.is_constant() ? 0 : c.number_;
    return {expression, append(expression, {.operation = operation, .a = first, .b = second, .c = third})};
  }
  Traced chosen(Operation operation, const Traced& b) const {
    if (is_constant() && b.is_constant())
      return operation == Operation::Min ? std::min(constant_, b.constant_) : std::max(constant_, b.constant_);
    return combined(operation, b);
  }
  Traced scaled(double factor) const {
    return is_constant() ? factor * constant_
                         : appended({.operation = Operation::Scale, .a = number_, .constant = factor});
  }
  Traced shifted(double shift) const {
    return is_constant() ? constant_ + shift
                         : appended({.operation = Operation::Shift, .a = number_, .constant = shift});
  }
  std::pair<Traced, Traced> pair(Operation first, Operation second) const {
    // The search looks at the last instructions only; else its time would grow with the square of the length of a text.
    constexpr std::size_t nearby = 256;
    const std::vector<Expression::Instruction>& all = expression_->instructions;
    for (std::size_t i = all.size() - std::min(all.size(), nearby); i < all.size(); ++i) {
      if (all[i].operation != first || all[i].a != number_) continue;
      return {Traced(*expression_, static_cast<int>(i)), Traced(*expression_, static_cast<int>(i) + 1)};
    }
    const Traced value = appended({.operation = first, .a = number_});
    return {value, appended({.operation = second, .a = number_})};
  }

  Expression* expression_ = nullptr;  // null for a constant
  int number_ = 0;
  double constant_ = 0.0;
};

/// Records callable(variables) -> std::vector<Traced>, which gets a std::vector<Traced> of `num_variables`. Returns
/// null if it cannot be recorded.
template <class Callable>
std::shared_ptr<const Expression> record_expression(int num_variables, const Callable& callable) {
  auto expression = std::make_shared<Expression>();
  std::vector<Traced> variables;
  for (int i = 0; i < num_variables; ++i) variables.push_back(Traced::variable(*expression));
  try {
    for (const Traced& result : callable(std::as_const(variables)))
      expression->results.push_back(result.number_in(*expression));
  } catch (const detail::NotTraceable&) {
    return nullptr;
  }
  return expression;
}

}  // namespace tanor
