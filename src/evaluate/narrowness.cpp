#include "evaluate/narrowness.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace tanor {

namespace {

using Operation = Expression::Operation;
using Instruction = Expression::Instruction;

constexpr double infinity = std::numeric_limits<double>::infinity();

struct Operands {
  bool a = false, b = false;
};
Operands operands_of(Operation operation) {
  switch (operation) {
    case Operation::Variable:
    case Operation::Constant:
      return {};
    case Operation::Add:
    case Operation::Subtract:
    case Operation::Multiply:
    case Operation::Divide:
    case Operation::Atan2:
    case Operation::Min:
    case Operation::Max:
      return {true, true};
    default:  // what else stands at b is there for series alone
      return {true, false};
  }
}

bool is_smooth(Operation operation) {
  switch (operation) {
    case Operation::Variable:
    case Operation::Constant:
    case Operation::Scale:
    case Operation::Shift:
    case Operation::Add:
    case Operation::Subtract:
    case Operation::Multiply:
      return true;
    default:
      return false;
  }
}

/// How far an argument runs between a and b, where it counts.
double run_within(Interval x, double a, double b) {
  return std::max(std::min(x.high, b) - std::max(x.low, a), 0.0);
}
/// How many times it changes by a factor sqrt(e): 1/(1 + x^2) comes and goes within two of each.
double count_factors(Interval x) {
  if (x.low == x.high) return 0.0;
  // Beyond a quotient by it is nothing beside any other number.
  constexpr double nothing_beyond = 1e45;
  const Interval size = abs(x);
  if (!(size.low > 0.0)) return infinity;
  return 2.0 * std::log(std::min(size.high, nothing_beyond) / std::min(size.low, nothing_beyond));
}
double count_at_kink(Interval x) {
  return x.low < 0.0 && x.high > 0.0 ? infinity : 0.0;
}

constexpr double faint = 60.0;      // e^-60 is nothing beside any other number
constexpr double saturated = 20.0;  // tanh is 1 to rounding

}  // namespace

Narrowness::Narrowness(const Expression& expression) {
  // Equal instructions are one.
  std::map<std::tuple<Operation, int, int, double>, int> known;
  std::vector<int> place(expression.instructions.size());
  for (std::size_t i = 0; i < expression.instructions.size(); ++i) {
    Instruction instruction = expression.instructions[i];
    const Operands operands = operands_of(instruction.operation);
    instruction.a = operands.a ? place[static_cast<std::size_t>(instruction.a)] : 0;
    instruction.b = operands.b ? place[static_cast<std::size_t>(instruction.b)] : 0;
    instruction.c = 0;
    const std::tuple key{instruction.operation, instruction.a, instruction.b, instruction.constant};
    const auto found = known.find(key);
    if (instruction.operation != Operation::Variable && found != known.end()) {
      place[i] = found->second;
      continue;
    }
    place[i] = static_cast<int>(instructions_.size());
    known[key] = place[i];
    instructions_.push_back(instruction);
  }
  for (const int variable : expression.variables) variables_.push_back(place[static_cast<std::size_t>(variable)]);
  for (const int result : expression.results) results_.push_back(place[static_cast<std::size_t>(result)]);

  // Backwards: the functions that results need, and all that these need.
  std::vector<char> is_needed(instructions_.size(), 0);
  for (const int result : results_) is_needed[static_cast<std::size_t>(result)] = 1;
  counts_.assign(instructions_.size(), 0);
  for (std::size_t i = instructions_.size(); i-- > 0;) {
    const Instruction& instruction = instructions_[i];
    const bool counts = is_needed[i] && !is_smooth(instruction.operation);
    if (counts) ++num_to_count_;
    if (counts) counts_[i] = 1;
    const Operands operands = operands_of(instruction.operation);
    for (const auto& [is_there, operand] : {std::pair{operands.a, instruction.a}, {operands.b, instruction.b}}) {
      if (!is_there) continue;
      is_needed[static_cast<std::size_t>(operand)] |= is_needed[i];
      counts_[static_cast<std::size_t>(operand)] |= counts_[i];
    }
  }
}

/// Of sinh(a)/cosh(a), which large arguments would make a quotient of infinities; -1: another quotient.
int Narrowness::argument_of_tanh(const Instruction& quotient) const {
  const Instruction& over = instructions_[static_cast<std::size_t>(quotient.a)];
  const Instruction& under = instructions_[static_cast<std::size_t>(quotient.b)];
  return over.operation == Operation::Sinh && under.operation == Operation::Cosh && over.a == under.a ? over.a : -1;
}

double Narrowness::count(const Interval* variables) const {
  thread_local std::vector<Interval> values;
  values.resize(instructions_.size());
  for (std::size_t i = 0; i < variables_.size(); ++i) values[static_cast<std::size_t>(variables_[i])] = variables[i];
  double most = 0.0;
  for (std::size_t i = 0; i < instructions_.size(); ++i) {
    if (!counts_[i]) continue;
    const Instruction& instruction = instructions_[i];
    const Interval a = values[static_cast<std::size_t>(instruction.a)];
    const Interval b = values[static_cast<std::size_t>(instruction.b)];
    Interval& result = values[i];
    double passes = 0.0;
    switch (instruction.operation) {
      case Operation::Variable:
        break;
      case Operation::Constant:
        result = instruction.constant;
        break;
      case Operation::Scale:
        result = instruction.constant * a;
        break;
      case Operation::Shift:
        result = a + instruction.constant;
        break;
      case Operation::Add:
        result = a + b;
        break;
      case Operation::Subtract:
        result = a - b;
        break;
      case Operation::Multiply:
        result = instruction.a == instruction.b ? square(a) : a * b;
        break;
      case Operation::Divide: {
        const int argument = argument_of_tanh(instruction);
        result = argument >= 0 ? tanh(values[static_cast<std::size_t>(argument)]) : a / b;
        passes = argument >= 0 ? 0.0 : count_factors(b);
        break;
      }
      case Operation::Sqrt:
        result = sqrt(a);
        passes = count_factors(a);
        break;
      case Operation::Exp:
        result = exp(a);
        passes = run_within(a, -faint, infinity);
        break;
      case Operation::Log:
        result = log(a);
        passes = count_factors(a);
        break;
      case Operation::Sin:
        result = sin(a);
        passes = a.width();
        break;
      case Operation::Cos:
        result = cos(a);
        passes = a.width();
        break;
      case Operation::Sinh:
        result = sinh(a);
        passes = run_within(a, -saturated, saturated);
        break;
      case Operation::Cosh:
        result = cosh(a);
        passes = run_within(a, -saturated, saturated);
        break;
      case Operation::Asin:
        result = asin(a);
        passes = a.magnitude() < 1.0 ? 0.0 : infinity;
        break;
      case Operation::Atan:
        result = atan(a);
        passes = std::asinh(a.high) - std::asinh(a.low);
        break;
      case Operation::Atan2: {
        const Interval &y = a, &x = b;
        const bool may_turn = y.contains(0.0) && x.low <= 0.0;
        const std::array corners{std::atan2(y.low, x.low), std::atan2(y.low, x.high), std::atan2(y.high, x.low),
                                 std::atan2(y.high, x.high)};
        const auto [least, largest] = std::minmax_element(corners.begin(), corners.end());
        result = may_turn ? Interval(-M_PI, M_PI) : Interval(*least, *largest);
        passes = may_turn ? infinity : result.width();
        break;
      }
      case Operation::Abs:
        result = abs(a);
        passes = count_at_kink(a);
        break;
      case Operation::Min:
        result = min(a, b);
        passes = count_at_kink(a - b);
        break;
      case Operation::Max:
        result = max(a, b);
        passes = count_at_kink(a - b);
        break;
    }
    if (!result.is_known()) result = Interval::everything();
    if (!(passes < infinity)) return infinity;
    most = std::max(most, passes);
  }
  return most;
}

void Narrowness::evaluate(const double* variables, double* results) const {
  thread_local std::vector<double> values;
  values.resize(instructions_.size());
  for (std::size_t i = 0; i < variables_.size(); ++i) values[static_cast<std::size_t>(variables_[i])] = variables[i];
  for (std::size_t i = 0; i < instructions_.size(); ++i) {
    const Instruction& instruction = instructions_[i];
    const double a = values[static_cast<std::size_t>(instruction.a)];
    const double b = values[static_cast<std::size_t>(instruction.b)];
    double& result = values[i];
    // clang-format off
    switch (instruction.operation) {
      case Operation::Variable: break;
      case Operation::Constant: result = instruction.constant; break;
      case Operation::Scale: result = instruction.constant * a; break;
      case Operation::Shift: result = a + instruction.constant; break;
      case Operation::Add: result = a + b; break;
      case Operation::Subtract: result = a - b; break;
      case Operation::Multiply: result = a * b; break;
      case Operation::Divide: {
        const int argument = argument_of_tanh(instruction);
        result = argument >= 0 ? std::tanh(values[static_cast<std::size_t>(argument)]) : a / b;
        break;
      }
      case Operation::Sqrt: result = std::sqrt(a); break;
      case Operation::Exp: result = std::exp(a); break;
      case Operation::Log: result = std::log(a); break;
      case Operation::Sin: result = std::sin(a); break;
      case Operation::Cos: result = std::cos(a); break;
      case Operation::Sinh: result = std::sinh(a); break;
      case Operation::Cosh: result = std::cosh(a); break;
      case Operation::Asin: result = std::asin(a); break;
      case Operation::Atan: result = std::atan(a); break;
      case Operation::Atan2: result = std::atan2(a, b); break;
      case Operation::Abs: result = std::abs(a); break;
      case Operation::Min: result = std::min(a, b); break;
      case Operation::Max: result = std::max(a, b); break;
    }
    // clang-format on
  }
  for (std::size_t m = 0; m < results_.size(); ++m) results[m] = values[static_cast<std::size_t>(results_[m])];
}

}  // namespace tanor
