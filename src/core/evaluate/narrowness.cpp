#include "evaluate/narrowness.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "base/instruction_sets.hpp"
#include "system/equal_operations.hpp"
#include "system/operations.hpp"

namespace tanor::detail {

namespace {

using Operation = Expression::Operation;
using Instruction = Expression::Instruction;

constexpr double infinity = std::numeric_limits<double>::infinity();

bool is_smooth(Operation operation) {
  return operation <= Operation::Multiply;
}

bool turns(Operation operation) {
  return operation == Operation::Abs || operation == Operation::Min || operation == Operation::Max ||
         operation == Operation::Atan2;
}

constexpr double faint = 60.0;           // e^-60 is negligible beside any other number
constexpr double saturated = 20.0;       // tanh is 1 to rounding
constexpr double most_exponent = 104.0;  // e^104 = 1e45

// These functions work on lanes. The loops that call them are compiled for each instruction set.
#define TANOR_LANES [[gnu::always_inline]] inline

TANOR_LANES Pack<> smaller_of(const Pack<>& a, const Pack<>& b) {
  return a < b ? a : b;
}
TANOR_LANES Pack<> larger_of(const Pack<>& a, const Pack<>& b) {
  return a > b ? a : b;
}
TANOR_LANES Intervals product(const Intervals& a, const Intervals& b) {
  const Pack<> p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;
  return {smaller_of(smaller_of(p, q), smaller_of(r, s)), larger_of(larger_of(p, q), larger_of(r, s))};
}
TANOR_LANES Intervals absolute(const Intervals& a) {
  const Pack<> p = larger_of(a.low, -a.low), q = larger_of(a.high, -a.high);
  const Pack<> least = smaller_of(p, q), zero{};
  return {((a.low <= 0.0) & (a.high >= 0.0)) ? zero : least, larger_of(p, q)};
}
template <class Function>
TANOR_LANES Pack<> map(const Pack<>& a, const Function& function) {
  Pack<> result{};
  for (std::size_t lane = 0; lane < num_lanes; ++lane) result[lane] = function(a[lane]);
  return result;
}
/// Returns the image of `a` under a function that rises.
template <class Function>
TANOR_LANES Intervals rising(const Intervals& a, const Function& function) {
  return {map(a.low, function), map(a.high, function)};
}

/// Returns how far an argument runs between a and b, where it counts.
TANOR_LANES Pack<> run_within(const Intervals& x, double a, double b) {
  const Pack<> zero{}, from = x.low > a ? x.low : zero + a, to = x.high < b ? x.high : zero + b;
  return larger_of(to - from, zero);
}
/// Returns how many times x changes by a factor sqrt(e). 1/(1 + x^2) rises within two such changes and falls within
/// two.
TANOR_LANES Pack<> count_factors(const Intervals& x) {
  constexpr double nothing_beyond = 1e45;  // a quotient by it is negligible beside any other number
  const Intervals size = absolute(x);
  const Pack<> zero{}, most = zero + nothing_beyond;
  const Pack<> ratio = smaller_of(size.high, most) / smaller_of(size.low, most);
  Pack<> result = 2.0 * (ratio - 1.0);  // >= 2 log(ratio)
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    if (!(result[lane] < 0.5)) result[lane] = 2.0 * std::log(ratio[lane]);
  }
  const Pack<> bound = size.low > 0.0 ? result : zero + infinity;
  return x.low == x.high ? zero : bound;
}
TANOR_LANES Pack<> count_at_kink(const Intervals& x) {
  const Pack<> zero{};
  return ((x.low < 0.0) & (x.high > 0.0)) ? zero + infinity : zero;
}

Intervals cosine(const Intervals& a) {
  Intervals result{};
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double low = a.low[lane], high = a.high[lane];
    const double p = std::cos(low), q = std::cos(high);
    // cos is 1 at whole turns and -1 at half ones.
    const double begin = low / (2.0 * M_PI), end = high / (2.0 * M_PI);
    const bool has_top = !(end - begin < 1.0) || std::floor(end) >= std::ceil(begin);
    const bool has_bottom = !(end - begin < 1.0) || std::floor(end - 0.5) >= std::ceil(begin - 0.5);
    result.low[lane] = has_bottom ? -1.0 : std::min(p, q);
    result.high[lane] = has_top ? 1.0 : std::max(p, q);
  }
  return result;
}

/// Returns the angle's range from its corners, or all angles if the branch cut or the origin may be met.
Intervals angle(const Intervals& y, const Intervals& x) {
  Intervals result{};
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const bool may_turn = y.low[lane] <= 0.0 && y.high[lane] >= 0.0 && x.low[lane] <= 0.0;
    const std::array corners{std::atan2(y.low[lane], x.low[lane]), std::atan2(y.low[lane], x.high[lane]),
                             std::atan2(y.high[lane], x.low[lane]), std::atan2(y.high[lane], x.high[lane])};
    const auto [least, largest] = std::minmax_element(corners.begin(), corners.end());
    result.low[lane] = may_turn ? -M_PI : *least;
    result.high[lane] = may_turn ? M_PI : *largest;
  }
  return result;
}

/// The range of an instruction's value, and how often it may change its course.
struct Course {
  Intervals value;
  Pack<> passes;
};

/// Follows sums and products of smooth numbers, and choices. Returns false if the instruction is another function.
TANOR_LANES bool follow_arithmetic(const Instruction& instruction, const Intervals& a, const Intervals& b,
                                   Course* course) {
  const Pack<> zero{};
  const double constant = instruction.constant;
  Intervals& value = course->value;
  switch (instruction.operation) {
    case Operation::Constant:
      value = {zero + constant, zero + constant};
      return true;
    case Operation::Scale:
      value = constant >= 0.0 ? Intervals{constant * a.low, constant * a.high}
                              : Intervals{constant * a.high, constant * a.low};
      return true;
    case Operation::Shift:
      value = {a.low + constant, a.high + constant};
      return true;
    case Operation::Add:
      value = {a.low + b.low, a.high + b.high};
      return true;
    case Operation::Subtract:
      value = {a.low - b.high, a.high - b.low};
      return true;
    case Operation::Multiply:
      if (instruction.a == instruction.b) {
        const Intervals size = absolute(a);
        value = {size.low * size.low, size.high * size.high};
      } else {
        value = product(a, b);
      }
      return true;
    case Operation::Abs:
      value = absolute(a);
      course->passes = count_at_kink(a);
      return true;
    case Operation::Min:
      value = {smaller_of(a.low, b.low), smaller_of(a.high, b.high)};
      course->passes = instruction.c > 0 ? zero : count_at_kink({a.low - b.high, a.high - b.low});
      return true;
    case Operation::Max:
      value = {larger_of(a.low, b.low), larger_of(a.high, b.high)};
      course->passes = instruction.c > 0 ? zero : count_at_kink({a.low - b.high, a.high - b.low});
      return true;
    default:
      return false;
  }
}

/// Follows quotients. For tanh = sinh/cosh (see the constructor) and for 1/exp, the argument of the function counts.
TANOR_LANES void follow_quotient(const std::vector<Instruction>& instructions, const Instruction& instruction,
                                 const Intervals* values, Course* course) {
  if (instruction.c > 0) {
    course->value = rising(values[instruction.c - 1], [](double x) { return std::tanh(x); });
    return;
  }
  const Intervals& b = values[instruction.b];
  const Instruction& under = instructions[static_cast<std::size_t>(instruction.b)];
  course->passes = under.operation == Operation::Exp ? 2.0 * run_within(values[under.a], -most_exponent, most_exponent)
                                                     : count_factors(b);
  const auto has_pole = (b.low <= 0.0) & (b.high >= 0.0);
  const Intervals quotient = product(values[instruction.a], {1.0 / b.high, 1.0 / b.low});
  course->value = {has_pole ? course->value.low : quotient.low, has_pole ? course->value.high : quotient.high};
}

/// Returns how often a function of one number changes its course.
TANOR_LANES Pack<> count_function(Operation operation, const Intervals& a) {
  const Pack<> zero{}, none = zero + infinity;
  switch (operation) {
    case Operation::Sqrt:
      return count_factors(a);
    case Operation::Exp:
      return run_within(a, -faint, infinity);
    case Operation::Log:
      return a.low > 0.0 ? count_factors(a) : none;
    case Operation::Sin:
    case Operation::Cos:
      return a.high - a.low;
    case Operation::Sinh:
    case Operation::Cosh:
      return run_within(a, -saturated, saturated);
    case Operation::Asin:
      return ((a.low > -1.0) & (a.high < 1.0)) ? zero : none;
    case Operation::Atan: {
      const Intervals scaled = rising(a, [](double x) { return std::asinh(x); });
      return scaled.high - scaled.low;
    }
    default:
      return zero;
  }
}

TANOR_LANES Intervals value_of_function(Operation operation, const Intervals& a) {
  const Pack<> none = Pack<>{} + infinity;
  // clang-format off
  switch (operation) {
    case Operation::Sqrt: return rising(a, [](double x) { return std::sqrt(std::max(x, 0.0)); });
    case Operation::Exp: return rising(a, [](double x) { return std::exp(x); });
    case Operation::Log: return rising(a, [](double x) { return std::log(std::max(x, 0.0)); });
    case Operation::Sin: return cosine({a.low - 0.5 * M_PI, a.high - 0.5 * M_PI});
    case Operation::Cos: return cosine(a);
    case Operation::Sinh: return rising(a, [](double x) { return std::sinh(x); });
    case Operation::Cosh: return rising(absolute(a), [](double x) { return std::cosh(x); });
    case Operation::Asin: return rising(a, [](double x) { return std::asin(std::clamp(x, -1.0, 1.0)); });
    case Operation::Atan: return rising(a, [](double x) { return std::atan(x); });
    default: return {-none, none};
  }
  // clang-format on
}

/// Computes the `values` [instruction] that count; those of variables are given. Writes the largest count to `result`.
void count_all(const std::vector<Instruction>& instructions, const char* counts, Intervals* values, Pack<>* result) {
  dispatch([=, &instructions] {
    const Pack<> zero{}, none = zero + infinity;
    Pack<> most = zero;
    for (std::size_t i = 0; i < instructions.size(); ++i) {
      const Instruction& instruction = instructions[i];
      const Operation operation = instruction.operation;
      if (!counts[i] || operation == Operation::Variable) continue;
      const Intervals& a = values[instruction.a];
      Course course{{-none, none}, zero};
      if (operation == Operation::Divide) {
        follow_quotient(instructions, instruction, values, &course);
      } else if (operation == Operation::Atan2) {
        course.value = angle(a, values[instruction.b]);
        course.passes = course.value.high - course.value.low;
        course.passes = course.passes > 6.0 ? none : course.passes;
      } else if (!follow_arithmetic(instruction, a, values[instruction.b], &course)) {
        course.passes = count_function(operation, a);
        course.value = value_of_function(operation, a);
      }
      const Intervals& value = course.value;
      const auto is_known = value.low <= value.high;
      values[i] = {is_known ? value.low : -none, is_known ? value.high : none};
      const Pack<> bound = course.passes < infinity ? course.passes : none;  // NaN is no bound
      most = larger_of(most, bound);
    }
    *result = most;
  });
}

#undef TANOR_LANES

}  // namespace

Narrowness::Narrowness(const Expression& expression) {
  Expression bare = expression;
  for (Instruction& instruction : bare.instructions) {
    if (num_operands(instruction.operation) < 1) instruction.a = 0;
    if (num_operands(instruction.operation) < 2) instruction.b = 0;
    instruction.c = 0;
  }
  bare = join_equal_operations(bare);
  instructions_ = std::move(bare.instructions);
  variables_ = std::move(bare.variables);
  results_ = std::move(bare.results);
  for (Instruction& instruction : instructions_) {
    const Instruction& over = instructions_[static_cast<std::size_t>(instruction.a)];
    const Instruction& under = instructions_[static_cast<std::size_t>(instruction.b)];
    const bool is_tanh = instruction.operation == Operation::Divide && over.operation == Operation::Sinh &&
                         under.operation == Operation::Cosh && over.a == under.a;
    const bool chooses = instruction.operation == Operation::Min || instruction.operation == Operation::Max;
    const bool is_decided = chooses && ((over.operation == Operation::Abs && over.a == instruction.b) ||
                                        (under.operation == Operation::Abs && under.a == instruction.a));
    instruction.c = is_tanh ? 1 + over.a : is_decided ? 1 : 0;
  }

  // This loop runs backwards and marks the functions that results need, and all that these need.
  std::vector<char> is_needed(instructions_.size(), 0);
  for (const int result : results_) is_needed[static_cast<std::size_t>(result)] = 1;
  counts_.assign(instructions_.size(), 0);
  for (std::size_t i = instructions_.size(); i-- > 0;) {
    const Instruction& instruction = instructions_[i];
    const bool counts = is_needed[i] && !is_smooth(instruction.operation);
    if (counts) ++num_to_count_;
    if (counts) counts_[i] = 1;
    if (counts && turns(instruction.operation)) turns_.push_back(i);
    const std::array operands{instruction.a, instruction.b};
    for (const int operand : std::span(operands).first(static_cast<std::size_t>(num_operands(instruction.operation)))) {
      is_needed[static_cast<std::size_t>(operand)] |= is_needed[i];
      counts_[static_cast<std::size_t>(operand)] |= counts_[i];
    }
  }
}

std::array<double, num_lanes> Narrowness::count(const Intervals* variables) const {
  thread_local std::vector<Intervals> values;
  values.resize(instructions_.size());
  for (std::size_t i = 0; i < variables_.size(); ++i) values[static_cast<std::size_t>(variables_[i])] = variables[i];
  Pack<> most;
  count_all(instructions_, counts_.data(), values.data(), &most);
  std::array<double, num_lanes> result;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) result[lane] = most[lane];
  return result;
}

/// Returns the values of all instructions.
const std::vector<double>& Narrowness::evaluate_all(const double* variables) const {
  thread_local std::vector<double> values;
  values.resize(instructions_.size());
  for (std::size_t i = 0; i < variables_.size(); ++i) values[static_cast<std::size_t>(variables_[i])] = variables[i];
  for (std::size_t i = 0; i < instructions_.size(); ++i) {
    const Instruction& instruction = instructions_[i];
    if (instruction.operation == Operation::Variable) continue;
    // tanh is called instead of sinh/cosh, which is a quotient of infinities for large arguments.
    const bool is_tanh = instruction.operation == Operation::Divide && instruction.c > 0;
    values[i] = is_tanh ? std::tanh(values[static_cast<std::size_t>(instruction.c) - 1]) : perform(instruction, values);
  }
  return values;
}

void Narrowness::evaluate(const double* variables, double* results) const {
  const std::vector<double>& values = evaluate_all(variables);
  for (std::size_t m = 0; m < results_.size(); ++m) results[m] = values[static_cast<std::size_t>(results_[m])];
}

void Narrowness::measure_turns(const double* variables, double* turns) const {
  const std::vector<double>& values = evaluate_all(variables);
  for (std::size_t k = 0; k < turns_.size(); ++k) {
    const Instruction& instruction = instructions_[turns_[k]];
    const bool compares = instruction.operation == Operation::Min || instruction.operation == Operation::Max;
    turns[k] = values[static_cast<std::size_t>(instruction.a)] -
               (compares ? values[static_cast<std::size_t>(instruction.b)] : 0.0);
  }
}

}  // namespace tanor::detail
