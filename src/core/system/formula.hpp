#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tanor/jet.hpp>
#include <tanor/time_function.hpp>

namespace tanor::detail {

/// A fault of a text and its place.
struct TextFault {
  std::size_t place;  ///< bytes from its beginning
  std::string problem;
};

/// Variables that the owner of a formula reads by itself.
struct OwnVariables {
  /// Reads what stands at a place of the text if it is one more variable, and moves the place behind it. Returns its
  /// number, or nothing where a name of the formula stands. Throws TextFault.
  std::function<std::optional<int>(std::string_view text, std::size_t* place)> read{};
  std::vector<std::string> names{};  ///< words with which such variables begin, for messages
  std::string_view all{};            ///< the text of which the formula is a part, for messages; empty if it is all
};

/// A formula such as `0.1*sin(omega*t)`. It is parsed once and evaluated often, on numbers and on jets.
///
///   sum      = product {(+|-) product}          power   = primary [^ unary]: 2^3^2 = 2^9, -x^2 = -(x^2), 2^-1 = 1/2
///   product  = unary {(*|/) unary}              primary = number | variable | constant | pi
///   unary    = {+|-} power                              | function(sum {, sum}) | (sum)
///
/// Functions: sqrt exp log sin cos tan asin acos atan atan2 sinh cosh tanh abs, min and max of two or more.
/// It is compiled to a postfix program without the operations on constants alone. It is immutable, so safe from any
/// thread.
class Formula {
 public:
  /// Parses the text. Names are letters, digits and '_', not beginning with a digit. Throws InputError with the text,
  /// the column (from 1, in characters), what stands there and what would be right.
  Formula(std::string_view text, std::span<const std::string> variables, const Constants& constants = {});

  /// Parses a text with variables of its owner beside those with names.
  Formula(std::string_view text, std::span<const std::string> variables, const Constants& constants,
          const OwnVariables& own);
  /// Throws the InputError that tells of a fault: the text, or all of which it is a part, the column, and the problem.
  [[noreturn]] static void refuse(std::string_view text, const TextFault& fault, std::string_view all = {});

  /// Returns the value at the variables, in the order of their names. Allocates nothing.
  template <class T>
  T evaluate(std::span<const T> variables) const;

  /// Does the same where load(i, &x) writes the value of variable i into x. It is called at each place where the
  /// variable stands.
  template <class T, class Load>
  T evaluate_loading(const Load& load) const;

  /// True if no variable takes part.
  bool is_constant() const { return program_.size() == 1 && program_[0].operation == Operation::Constant; }
  /// True if the formula is variable i and nothing else.
  bool is_variable(int i) const {
    return program_.size() == 1 && program_[0].operation == Operation::Variable && program_[0].operand == i;
  }
  /// True if variable i takes part.
  bool depends_on(int i) const {
    return std::ranges::any_of(program_, [i](const Instruction& instruction) {
      return instruction.operation == Operation::Variable && instruction.operand == i;
    });
  }

  // clang-format off
  enum class Operation : std::uint8_t {
    Constant, Variable,                                       // push
    Negate, IntegerPower,                                     // replace the top
    Sqrt, Exp, Log, Sin, Cos, Tan, Asin, Acos, Atan, Sinh, Cosh, Tanh, Abs,
    Add, Subtract, Multiply, Divide, Power, Atan2, Min, Max,  // replace the top two
  };
  // clang-format on

  struct Instruction {
    Operation operation;
    int operand = 0;        ///< number of a Variable, exponent of an IntegerPower
    double constant = 0.0;  ///< value of a Constant
  };

  /// Largest number of operands that wait for their operator; deeper formulas are refused.
  static constexpr int largest_depth = 64;

 private:
  class Parser;

  template <int depth, class T, class Load>
  static T run(std::span<const Instruction> program, const Load& load);

  std::vector<Instruction> program_;
  int depth_ = 0;  ///< largest number of operands on the stack
};

template <class T>
T Formula::evaluate(std::span<const T> variables) const {
  return evaluate_loading<T>([&](int i, T* x) { *x = variables[static_cast<std::size_t>(i)]; });
}

template <class T, class Load>
T Formula::evaluate_loading(const Load& load) const {
  constexpr int usual_depth = 8;  // a small stack is cheap to clear
  return depth_ <= usual_depth ? run<usual_depth, T>(program_, load) : run<largest_depth, T>(program_, load);
}

template <int depth, class T, class Load>
T Formula::run(std::span<const Instruction> program, const Load& load) {
  using detail::signed_integer_power;
  using std::sqrt, std::exp, std::log, std::sin, std::cos, std::tan, std::asin, std::acos, std::atan, std::atan2,
      std::sinh, std::cosh, std::tanh, std::abs, std::min, std::max, std::pow;
  std::array<T, depth + 1> stack;
  T* top = stack.data();  // slot 0 stays unused
  // clang-format off
  for (const Instruction& instruction : program) {
    switch (instruction.operation) {
      case Operation::Constant: *++top = T(instruction.constant); break;
      case Operation::Variable: load(instruction.operand, ++top); break;
      case Operation::Negate: *top = -*top; break;
      case Operation::IntegerPower: *top = signed_integer_power(*top, instruction.operand); break;
      case Operation::Sqrt: *top = sqrt(*top); break;
      case Operation::Exp: *top = exp(*top); break;
      case Operation::Log: *top = log(*top); break;
      case Operation::Sin: *top = sin(*top); break;
      case Operation::Cos: *top = cos(*top); break;
      case Operation::Tan: *top = tan(*top); break;
      case Operation::Asin: *top = asin(*top); break;
      case Operation::Acos: *top = acos(*top); break;
      case Operation::Atan: *top = atan(*top); break;
      case Operation::Sinh: *top = sinh(*top); break;
      case Operation::Cosh: *top = cosh(*top); break;
      case Operation::Tanh: *top = tanh(*top); break;
      case Operation::Abs: *top = abs(*top); break;
      case Operation::Add: --top; top[0] += top[1]; break;
      case Operation::Subtract: --top; top[0] -= top[1]; break;
      case Operation::Multiply: --top; top[0] *= top[1]; break;
      case Operation::Divide: --top; top[0] /= top[1]; break;
      case Operation::Power: --top; *top = pow(top[0], top[1]); break;
      case Operation::Atan2: --top; *top = atan2(top[0], top[1]); break;
      case Operation::Min: --top; *top = min(top[0], top[1]); break;
      case Operation::Max: --top; *top = max(top[0], top[1]); break;
    }
  }
  // clang-format on
  return *top;
}

}  // namespace tanor::detail
