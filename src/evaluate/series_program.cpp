#include "evaluate/series_program.hpp"

#include <cmath>
#include <utility>

#include "base/instruction_sets.hpp"

namespace tanor {

namespace {

using Operation = Expression::Operation;
using Lane = SeriesLane;

/// sum over j = first … last of a_j b_{k-j}
[[gnu::always_inline]] inline void add_products(const Lane* a, const Lane* b, int k, int first, int last, Lane* sum) {
  Lane s = *sum;
  for (int j = first; j <= last; ++j) s += a[j] * b[k - j];
  *sum = s;
}
/// sum over j = first … last of j a_j b_{k-j}
[[gnu::always_inline]] inline void add_weighted(const Lane* a, const Lane* b, int k, int first, int last, Lane* sum) {
  Lane s = *sum;
  for (int j = first; j <= last; ++j) s += static_cast<double>(j) * a[j] * b[k - j];
  *sum = s;
}

template <class Function>
[[gnu::always_inline]] inline void map(const Lane& a, const Function& function, Lane* r) {
  for (std::size_t lane = 0; lane < series_width; ++lane) (*r)[lane] = function(a[lane]);
}

bool needs_quotient(Operation operation) {
  switch (operation) {
    case Operation::Divide:
    case Operation::Sqrt:
    case Operation::Log:
    case Operation::Asin:
    case Operation::Atan:
    case Operation::Atan2:
      return true;
    default:
      return false;
  }
}

}  // namespace

SeriesProgram::SeriesProgram(Expression expression, bool with_adjoints) : expression_(std::move(expression)) {
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
    switch (operation) {
      case Operation::Variable:
      case Operation::Constant:
        break;
      case Operation::Scale:
      case Operation::Shift:
        varies[i] = varies[static_cast<std::size_t>(a)];
        break;
      case Operation::Add:
      case Operation::Subtract:
        varies[i] = varies[static_cast<std::size_t>(a)] || varies[static_cast<std::size_t>(b)];
        break;
      default:
        // A product with a function of time turns what it multiplies.
        if (varies[static_cast<std::size_t>(a)] || varies[static_cast<std::size_t>(b)]) return false;
    }
  }
  return true;
}

namespace {

TANOR_EACH_INSTRUCTION_SET
void evaluate_coefficient(const std::vector<Expression::Instruction>& instructions, Lane* lanes, std::size_t length,
                          int k) {
  const auto series = [lanes, length](int number) { return lanes + static_cast<std::size_t>(number) * length; };
  const double inverse = k > 0 ? 1.0 / k : 0.0;
  for (std::size_t i = 0; i < instructions.size(); ++i) {
    const Expression::Instruction& instruction = instructions[i];
    const Lane* const a = series(instruction.a);
    const Lane* const b = series(instruction.b);
    Lane* const r = lanes + i * length;
    Lane sum{};
    switch (instruction.operation) {
      case Operation::Variable:
        break;
      case Operation::Constant:
        r[k] = k == 0 ? sum + instruction.constant : sum;
        break;
      case Operation::Scale:
        r[k] = instruction.constant * a[k];
        break;
      case Operation::Shift:
        r[k] = k == 0 ? a[k] + instruction.constant : a[k];
        break;
      case Operation::Add:
        r[k] = a[k] + b[k];
        break;
      case Operation::Subtract:
        r[k] = a[k] - b[k];
        break;
      case Operation::Multiply:
        // r_k = sum over j = 0 … k of a_j b_{k-j}
        add_products(a, b, k, 0, k, &sum);
        r[k] = sum;
        break;
      case Operation::Divide:
        // r b = a
        add_products(b, r, k, 1, k, &sum);
        r[k] = (a[k] - sum) / b[0];
        break;
      case Operation::Sqrt:
        // r^2 = a
        if (k == 0) {
          map(
              a[0], [](double x) { return std::sqrt(x); }, &r[0]);
        } else {
          add_products(r, r, k, 1, k - 1, &sum);
          r[k] = (a[k] - sum) / (2.0 * r[0]);
        }
        break;
      case Operation::Exp:
        // r' = a' r
        if (k == 0) {
          map(
              a[0], [](double x) { return std::exp(x); }, &r[0]);
        } else {
          add_weighted(a, r, k, 1, k, &sum);
          r[k] = inverse * sum;
        }
        break;
      case Operation::Log:
        // r' a = a'
        if (k == 0) {
          map(
              a[0], [](double x) { return std::log(x); }, &r[0]);
        } else {
          add_weighted(r, a, k, 1, k - 1, &sum);
          r[k] = (a[k] - inverse * sum) / a[0];
        }
        break;
      case Operation::Sin:
      case Operation::Sinh: {
        // s' = a' c, c' = -a' s; sinh and cosh: +
        Lane* const cosine = r + length;
        const bool is_circular = instruction.operation == Operation::Sin;
        if (k == 0) {
          map(
              a[0], [is_circular](double x) { return is_circular ? std::sin(x) : std::sinh(x); }, &r[0]);
          map(
              a[0], [is_circular](double x) { return is_circular ? std::cos(x) : std::cosh(x); }, &cosine[0]);
        } else {
          add_weighted(a, cosine, k, 1, k, &sum);
          r[k] = inverse * sum;
          sum = Lane{};
          add_weighted(a, r, k, 1, k, &sum);
          cosine[k] = (is_circular ? -inverse : inverse) * sum;
        }
        break;
      }
      case Operation::Cos:
      case Operation::Cosh:
        break;  // with the sine before it
      case Operation::Asin:
      case Operation::Atan:
        // r' b = a'
        if (k == 0) {
          const bool is_asin = instruction.operation == Operation::Asin;
          map(
              a[0], [is_asin](double x) { return is_asin ? std::asin(x) : std::atan(x); }, &r[0]);
        } else {
          add_weighted(r, b, k, 1, k - 1, &sum);
          r[k] = (a[k] - inverse * sum) / b[0];
        }
        break;
      case Operation::Atan2: {
        // r' (x^2 + y^2) = x y' - y x', y = a, x = b
        const Lane* const c = series(instruction.c);
        if (k == 0) {
          for (std::size_t lane = 0; lane < series_width; ++lane) r[0][lane] = std::atan2(a[0][lane], b[0][lane]);
        } else {
          Lane other{}, last{};
          add_weighted(a, b, k, 1, k, &sum);
          add_weighted(b, a, k, 1, k, &other);
          add_weighted(r, c, k, 1, k - 1, &last);
          r[k] = inverse * (sum - other - last) / c[0];
        }
        break;
      }
      case Operation::Abs:
        for (std::size_t lane = 0; lane < series_width; ++lane) {
          const double x = a[k][lane];
          r[k][lane] = a[0][lane] < 0.0 ? -x : x;
        }
        break;
      case Operation::Min:
        for (std::size_t lane = 0; lane < series_width; ++lane) {
          const double x = a[k][lane], y = b[k][lane];
          r[k][lane] = b[0][lane] < a[0][lane] ? y : x;
        }
        break;
      case Operation::Max:
        for (std::size_t lane = 0; lane < series_width; ++lane) {
          const double x = a[k][lane], y = b[k][lane];
          r[k][lane] = a[0][lane] < b[0][lane] ? y : x;
        }
        break;
    }
  }
}

TANOR_EACH_INSTRUCTION_SET
void differentiate_coefficient(const Expression& expression, const std::vector<int>& quotient, Lane* lanes,
                               std::size_t length, int k, const Lane* seeds) {
  const std::size_t count = expression.instructions.size();
  const auto series = [lanes, length](int number) { return lanes + static_cast<std::size_t>(number) * length; };
  Lane* const adjoints = lanes + count * length;
  Lane* const quotients = adjoints + count * length;
  const auto adjoint = [adjoints, length](int number) { return adjoints + static_cast<std::size_t>(number) * length; };
  for (std::size_t i = 0; i < count; ++i) adjoints[i * length + static_cast<std::size_t>(k)] = Lane{};
  for (std::size_t m = 0; m < expression.results.size(); ++m) adjoint(expression.results[m])[k] += seeds[m];

  for (std::size_t i = count; i-- > 0;) {
    const Expression::Instruction& instruction = expression.instructions[i];
    const Lane* const self = adjoints + i * length;
    const Lane* const r = lanes + i * length;
    Lane* const to_a = adjoint(instruction.a) + k;
    Lane* const to_b = adjoint(instruction.b) + k;
    const Lane* const a = series(instruction.a);
    const Lane* const b = series(instruction.b);
    Lane* const q = quotient[i] >= 0 ? quotients + static_cast<std::size_t>(quotient[i]) * length : nullptr;
    // q = self/divisor
    const auto divide = [ q, k ](const Lane* dividend, const Lane* divisor) __attribute__((always_inline)) {
      Lane s{};
      add_products(divisor, q, k, 1, k, &s);
      q[k] = (dividend[k] - s) / divisor[0];
    };
    Lane sum{};
    switch (instruction.operation) {
      case Operation::Variable:
      case Operation::Constant:
        break;
      case Operation::Scale:
        *to_a += instruction.constant * self[k];
        break;
      case Operation::Shift:
        *to_a += self[k];
        break;
      case Operation::Add:
        *to_a += self[k];
        *to_b += self[k];
        break;
      case Operation::Subtract:
        *to_a += self[k];
        *to_b -= self[k];
        break;
      case Operation::Multiply:
        add_products(b, self, k, 0, k, &sum);
        *to_a += sum;
        sum = Lane{};
        add_products(a, self, k, 0, k, &sum);
        *to_b += sum;
        break;
      case Operation::Divide:
        divide(self, b);
        *to_a += q[k];
        add_products(r, q, k, 0, k, &sum);
        *to_b -= sum;
        break;
      case Operation::Sqrt:
        divide(self, r);
        *to_a += 0.5 * q[k];
        break;
      case Operation::Exp:
        add_products(r, self, k, 0, k, &sum);
        *to_a += sum;
        break;
      case Operation::Log:
        divide(self, a);
        *to_a += q[k];
        break;
      case Operation::Sin:
      case Operation::Sinh:
        add_products(r + length, self, k, 0, k, &sum);
        *to_a += sum;
        break;
      case Operation::Cos:
        add_products(r - length, self, k, 0, k, &sum);
        *to_a -= sum;
        break;
      case Operation::Cosh:
        add_products(r - length, self, k, 0, k, &sum);
        *to_a += sum;
        break;
      case Operation::Asin:
      case Operation::Atan:
        divide(self, b);
        *to_a += q[k];
        break;
      case Operation::Atan2:
        divide(self, series(instruction.c));
        add_products(b, q, k, 0, k, &sum);
        *to_a += sum;
        sum = Lane{};
        add_products(a, q, k, 0, k, &sum);
        *to_b -= sum;
        break;
      case Operation::Abs:
        for (std::size_t lane = 0; lane < series_width; ++lane)
          (*to_a)[lane] += a[0][lane] < 0.0 ? -self[k][lane] : self[k][lane];
        break;
      case Operation::Min:
        for (std::size_t lane = 0; lane < series_width; ++lane)
          (b[0][lane] < a[0][lane] ? *to_b : *to_a)[lane] += self[k][lane];
        break;
      case Operation::Max:
        for (std::size_t lane = 0; lane < series_width; ++lane)
          (a[0][lane] < b[0][lane] ? *to_b : *to_a)[lane] += self[k][lane];
        break;
    }
  }
}

}  // namespace

void SeriesProgram::evaluate(SeriesLane* lanes, int order, int k) const {
  evaluate_coefficient(expression_.instructions, lanes, stride(order), k);
}

void SeriesProgram::differentiate(SeriesLane* lanes, int order, int k, const SeriesLane* seeds) const {
  differentiate_coefficient(expression_, quotient_, lanes, stride(order), k, seeds);
}

}  // namespace tanor
