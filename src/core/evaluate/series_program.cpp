#include "evaluate/series_program.hpp"

#include <cmath>

#include "base/instruction_sets.hpp"
#include "system/equal_operations.hpp"
#include "system/operations.hpp"

namespace tanor::detail {

namespace {

using Operation = Expression::Operation;

/// Adds up a_j b_{k-j} for j = first … last.
template <class Lane>
[[gnu::always_inline]] inline void add_products(const Lane* a, const Lane* b, int k, int first, int last, Lane* sum) {
  Lane s = *sum;
  for (int j = first; j <= last; ++j) s += a[j] * b[k - j];
  *sum = s;
}
/// Adds up a_j a_{k-j} for j = first … k - first, each pair once.
template <class Lane>
[[gnu::always_inline]] inline void add_squares(const Lane* a, int k, int first, Lane* sum) {
  Lane half{};
  int j = first;
  for (; 2 * j < k; ++j) half += a[j] * a[k - j];
  *sum += 2.0 * half;
  if (2 * j == k) *sum += a[j] * a[j];
}
/// Adds up j a_j b_{k-j} for j = first … last.
template <class Lane>
[[gnu::always_inline]] inline void add_weighted(const Lane* a, const Lane* b, int k, int first, int last, Lane* sum) {
  Lane s = *sum;
  for (int j = first; j <= last; ++j) s += static_cast<double>(j) * a[j] * b[k - j];
  *sum = s;
}

bool needs_quotient(Operation operation) {
  using enum Expression::Operation;
  return operation == Divide || operation == Sqrt || operation == Log || (Asin <= operation && operation <= Atan2);
}

}  // namespace

SeriesProgram::SeriesProgram(const Expression& expression, bool with_adjoints)
    : expression_(join_equal_operations(expression)) {
  if (!with_adjoints) return;
  num_adjoints_ = num_instructions();
  for (const Expression::Instruction& instruction : expression_.instructions) {
    quotient_.push_back(needs_quotient(instruction.operation) ? static_cast<int>(num_quotients_++) : -1);
  }
}

bool SeriesProgram::is_linear_in(const std::vector<char>& counts) const {
  std::vector<char> varies(num_instructions(), 0);
  for (std::size_t i = 0; i < num_variables(); ++i) varies[number(expression_.variables[i])] = counts[i];
  for (std::size_t i = 0; i < num_instructions(); ++i) {
    const auto& [operation, a, b, c, constant] = expression_.instructions[i];
    if (operation == Operation::Variable) continue;
    const int count = num_operands(operation);
    varies[i] = (count > 0 && varies[number(a)] != 0) || (count > 1 && varies[number(b)] != 0);
    // A product with a function of time changes the gradient of what it multiplies.
    if (varies[i] && operation >= Operation::Multiply) return false;
  }
  return true;
}

namespace {

/// The series that an instruction reads, and the one that it writes.
template <class Lane>
struct Operands {
  const Lane *a, *b, *c;
  Lane *r, *after;  // `after` is that of the next instruction, which is the cosine of a sine
};

/// Evaluates coefficient k of sums, products and choices. Returns false if it is another function.
template <class Lane>
[[gnu::always_inline]] inline bool evaluate_arithmetic(const Expression::Instruction& instruction,
                                                       const Operands<Lane>& operands, int k) {
  const auto& [a, b, c, r, after] = operands;
  Lane sum{};
  switch (instruction.operation) {
    case Operation::Variable:
      return true;
    case Operation::Constant:
      r[k] = k == 0 ? sum + instruction.constant : sum;
      return true;
    case Operation::Scale:
      r[k] = instruction.constant * a[k];
      return true;
    case Operation::Shift:
      r[k] = k == 0 ? a[k] + instruction.constant : a[k];
      return true;
    case Operation::Add:
      r[k] = a[k] + b[k];
      return true;
    case Operation::Subtract:
      r[k] = a[k] - b[k];
      return true;
    case Operation::Multiply:
      // r_k = sum over j = 0 … k of a_j b_{k-j}
      if (a == b)
        add_squares(a, k, 0, &sum);
      else
        add_products(a, b, k, 0, k, &sum);
      r[k] = sum;
      return true;
    case Operation::Divide:
      // r b = a
      add_products(b, r, k, 1, k, &sum);
      r[k] = (a[k] - sum) / b[0];
      return true;
    case Operation::Abs:
    case Operation::Min:
    case Operation::Max:
      for (std::size_t m = 0; m < width_of<Lane>; ++m) {
        const bool is_abs = instruction.operation == Operation::Abs;
        const double x = member_of(a[k], m), y = is_abs ? -x : member_of(b[k], m);
        const double p = member_of(a[0], m), q = is_abs ? 0.0 : member_of(b[0], m);
        const bool takes_y = instruction.operation == Operation::Min ? q < p : p < q;
        member_of(r[k], m) = takes_y ? y : x;
      }
      return true;
    default:
      return false;
  }
}

/// Evaluates coefficient 0 of a function, which is its value.
template <class Lane>
[[gnu::always_inline]] inline void evaluate_value(Operation operation, const Operands<Lane>& operands) {
  const auto& [a, b, c, r, after] = operands;
  for (std::size_t m = 0; m < width_of<Lane>; ++m) {
    const double x = member_of(a[0], m);
    double y = member_of(r[0], m);
    // clang-format off
    switch (operation) {
      case Operation::Sqrt: y = std::sqrt(x); break;
      case Operation::Exp: y = std::exp(x); break;
      case Operation::Log: y = std::log(x); break;
      case Operation::Sin: y = std::sin(x); member_of(after[0], m) = std::cos(x); break;
      case Operation::Sinh: y = std::sinh(x); member_of(after[0], m) = std::cosh(x); break;
      case Operation::Asin: y = std::asin(x); break;
      case Operation::Atan: y = std::atan(x); break;
      case Operation::Atan2: y = std::atan2(x, member_of(b[0], m)); break;
      default: break;
    }
    // clang-format on
    member_of(r[0], m) = y;
  }
}

/// Evaluates coefficient k > 0 of a function, from the differential equation that it solves.
template <class Lane>
[[gnu::always_inline]] inline void evaluate_function(Operation operation, const Operands<Lane>& operands, int k) {
  const auto& [a, b, c, r, after] = operands;
  const double inverse = 1.0 / k;
  Lane sum{}, other{}, last{};
  switch (operation) {
    case Operation::Sqrt:
      // r^2 = a
      add_squares(r, k, 1, &sum);
      r[k] = (a[k] - sum) / (2.0 * r[0]);
      break;
    case Operation::Exp:
      // r' = a' r
      add_weighted(a, r, k, 1, k, &sum);
      r[k] = inverse * sum;
      break;
    case Operation::Sin:
    case Operation::Sinh:
      // s' = a' c, c' = -a' s, and + for sinh and cosh
      add_weighted(a, after, k, 1, k, &sum);
      r[k] = inverse * sum;
      add_weighted(a, r, k, 1, k, &other);
      after[k] = (operation == Operation::Sin ? -inverse : inverse) * other;
      break;
    case Operation::Log:
    case Operation::Asin:
    case Operation::Atan: {
      // r' g = a'
      const Lane* const g = operation == Operation::Log ? a : b;
      add_weighted(r, g, k, 1, k - 1, &sum);
      r[k] = (a[k] - inverse * sum) / g[0];
      break;
    }
    case Operation::Atan2:
      // r' (x^2 + y^2) = x y' - y x', y = a, x = b
      add_weighted(a, b, k, 1, k, &sum);
      add_weighted(b, a, k, 1, k, &other);
      add_weighted(r, c, k, 1, k - 1, &last);
      r[k] = inverse * (sum - other - last) / c[0];
      break;
    default:
      break;  // a cosine is evaluated with the sine before it
  }
}

template <class Lane>
void evaluate_coefficient(const std::vector<Expression::Instruction>& instructions, Lane* lanes, std::size_t length,
                          int k) {
  dispatch([=, &instructions] {
    const auto series = [lanes, length](int number) { return lanes + static_cast<std::size_t>(number) * length; };
    for (std::size_t i = 0; i < instructions.size(); ++i) {
      const Expression::Instruction& instruction = instructions[i];
      Lane* const r = lanes + i * length;
      const Operands<Lane> operands{series(instruction.a), series(instruction.b), series(instruction.c), r, r + length};
      if (evaluate_arithmetic(instruction, operands, k)) continue;
      if (k == 0)
        evaluate_value(instruction.operation, operands);
      else
        evaluate_function(instruction.operation, operands, k);
    }
  });
}

/// The series of an instruction and of its operands, and where the adjoints of the operands gather.
template <class Lane>
struct Adjoints {
  const Lane *a, *b, *c, *r, *self;
  Lane *to_a, *to_b, *q;  // q: a quotient of series
};

/// Adds the adjoint of a sum, product or choice to those of its operands. Returns false if it is another function.
template <class Lane>
[[gnu::always_inline]] inline bool differentiate_arithmetic(const Expression::Instruction& instruction,
                                                            const Adjoints<Lane>& of, int k) {
  Lane sum{}, other{};
  switch (instruction.operation) {
    case Operation::Variable:
    case Operation::Constant:
      return true;
    case Operation::Scale:
      *of.to_a += instruction.constant * of.self[k];
      return true;
    case Operation::Shift:
      *of.to_a += of.self[k];
      return true;
    case Operation::Add:
      *of.to_a += of.self[k];
      *of.to_b += of.self[k];
      return true;
    case Operation::Subtract:
      *of.to_a += of.self[k];
      *of.to_b -= of.self[k];
      return true;
    case Operation::Multiply:
      add_products(of.b, of.self, k, 0, k, &sum);
      *of.to_a += of.a == of.b ? 2.0 * sum : sum;
      if (of.a == of.b) return true;
      add_products(of.a, of.self, k, 0, k, &other);
      *of.to_b += other;
      return true;
    case Operation::Abs:
      for (std::size_t m = 0; m < width_of<Lane>; ++m) {
        const double self = member_of(of.self[k], m);
        member_of(*of.to_a, m) += member_of(of.a[0], m) < 0.0 ? -self : self;
      }
      return true;
    case Operation::Min:
    case Operation::Max:
      for (std::size_t m = 0; m < width_of<Lane>; ++m) {
        const double p = member_of(of.a[0], m), q = member_of(of.b[0], m);
        const bool takes_b = instruction.operation == Operation::Min ? q < p : p < q;
        member_of(takes_b ? *of.to_b : *of.to_a, m) += member_of(of.self[k], m);
      }
      return true;
    default:
      return false;
  }
}

/// Adds the adjoint of a function to those of its operands.
template <class Lane>
[[gnu::always_inline]] inline void differentiate_function(Operation operation, const Adjoints<Lane>& of, int k) {
  // q = self/divisor
  const auto divide = [&](const Lane* divisor) __attribute__((always_inline)) {
    Lane s{};
    add_products(divisor, of.q, k, 1, k, &s);
    of.q[k] = (of.self[k] - s) / divisor[0];
  };
  Lane sum{}, other{};
  switch (operation) {
    case Operation::Divide:
      divide(of.b);
      *of.to_a += of.q[k];
      add_products(of.r, of.q, k, 0, k, &sum);
      *of.to_b -= sum;
      break;
    case Operation::Sqrt:
      divide(of.r);
      *of.to_a += 0.5 * of.q[k];
      break;
    case Operation::Exp:
      add_products(of.r, of.self, k, 0, k, &sum);
      *of.to_a += sum;
      break;
    case Operation::Log:
    case Operation::Asin:
    case Operation::Atan:
      divide(operation == Operation::Log ? of.a : of.b);
      *of.to_a += of.q[k];
      break;
    case Operation::Atan2:
      divide(of.c);
      add_products(of.b, of.q, k, 0, k, &sum);
      *of.to_a += sum;
      add_products(of.a, of.q, k, 0, k, &other);
      *of.to_b -= other;
      break;
    default:
      break;
  }
}

/// Adds the adjoint of a sine or cosine to that of its operand; `length` lies between the series of a pair.
template <class Lane>
[[gnu::always_inline]] inline void differentiate_pair(Operation operation, const Adjoints<Lane>& of, std::size_t length,
                                                      int k) {
  const bool is_first = operation == Operation::Sin || operation == Operation::Sinh;
  if (!is_first && operation != Operation::Cos && operation != Operation::Cosh) return;
  Lane sum{};
  add_products(is_first ? of.r + length : of.r - length, of.self, k, 0, k, &sum);
  if (operation == Operation::Cos)
    *of.to_a -= sum;
  else
    *of.to_a += sum;
}

template <class Lane>
void differentiate_coefficient(const Expression& expression, const std::vector<int>& quotient, Lane* lanes,
                               std::size_t length, int k, const Lane* seeds) {
  dispatch([=, &expression, &quotient] {
    const std::size_t count = expression.instructions.size();
    const auto series = [lanes, length](int number) { return lanes + static_cast<std::size_t>(number) * length; };
    Lane* const adjoints = lanes + count * length;
    Lane* const quotients = adjoints + count * length;
    const auto adjoint = [adjoints, length](int number) {
      return adjoints + static_cast<std::size_t>(number) * length;
    };
    for (std::size_t i = 0; i < count; ++i) adjoints[i * length + static_cast<std::size_t>(k)] = Lane{};
    for (std::size_t m = 0; m < expression.results.size(); ++m) adjoint(expression.results[m])[k] += seeds[m];

    for (std::size_t i = count; i-- > 0;) {
      const Expression::Instruction& instruction = expression.instructions[i];
      Lane* const q = quotient[i] >= 0 ? quotients + static_cast<std::size_t>(quotient[i]) * length : nullptr;
      const Adjoints<Lane> of{
          series(instruction.a), series(instruction.b),      series(instruction.c),      lanes + i * length,
          adjoints + i * length, adjoint(instruction.a) + k, adjoint(instruction.b) + k, q};
      if (differentiate_arithmetic(instruction, of, k)) continue;
      differentiate_function(instruction.operation, of, k);
      differentiate_pair(instruction.operation, of, length, k);
    }
  });
}

}  // namespace

template <class Lane>
void SeriesProgram::evaluate(Lane* lanes, int order, int k) const {
  evaluate_coefficient(expression_.instructions, lanes, stride(order), k);
}

template <class Lane>
void SeriesProgram::differentiate(Lane* lanes, int order, int k, const Lane* seeds) const {
  differentiate_coefficient(expression_, quotient_, lanes, stride(order), k, seeds);
}

template void SeriesProgram::evaluate(SeriesLane*, int, int) const;
template void SeriesProgram::evaluate(double*, int, int) const;
template void SeriesProgram::differentiate(SeriesLane*, int, int, const SeriesLane*) const;
template void SeriesProgram::differentiate(double*, int, int, const double*) const;

}  // namespace tanor::detail
