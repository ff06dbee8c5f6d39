#include "system/corner_terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <tanor/jet.hpp>

#include "system/equal_operations.hpp"
#include "system/operations.hpp"

namespace tanor::detail {

namespace {

using Instruction = Expression::Instruction;

/// Returns a if the instruction is a square a a, or a positive multiple of one; otherwise -1.
int find_root_of_square(const std::vector<Instruction>& instructions, int number) {
  const auto at = [&](int i) -> const Instruction& { return instructions[static_cast<std::size_t>(i)]; };
  while (at(number).operation == Expression::Operation::Scale && at(number).constant > 0.0) number = at(number).a;
  const bool is_product = at(number).operation == Expression::Operation::Multiply;
  return is_product && at(number).a == at(number).b ? at(number).a : -1;
}

/// Returns a if the instruction is p log(a), so that its exponential is a power; otherwise -1.
int find_base(const std::vector<Instruction>& instructions, int number) {
  const auto at = [&](int i) -> const Instruction& { return instructions[static_cast<std::size_t>(i)]; };
  if (at(number).operation == Expression::Operation::Scale) number = at(number).a;
  return at(number).operation == Expression::Operation::Log ? at(number).a : -1;
}

}  // namespace

CornerTerms::CornerTerms(const Expression& expression) : expression_(join_equal_operations(expression)) {
  for (const auto& [operation, a, b, c, constant] : expression_.instructions) {
    if (operation == Expression::Operation::Abs) terms_.push_back({operation, a, -1});
    if (operation == Expression::Operation::Min) terms_.push_back({operation, b, a});
    if (operation == Expression::Operation::Max) terms_.push_back({operation, a, b});
    if (operation == Expression::Operation::Atan2) append_angle({operation, a, b, c, constant});
    const int base = operation == Expression::Operation::Sqrt  ? a
                     : operation == Expression::Operation::Exp ? find_base(expression_.instructions, a)
                                                               : -1;
    if (base < 0) continue;
    const int root = find_root_of_square(expression_.instructions, base);
    terms_.push_back(root >= 0 ? Term{operation, root, -1} : Term{operation, base, Term::only_touches_0});
  }
  const auto is_same = [](const Term& one, const Term& other) {
    return one.a == other.a && one.b == other.b && one.has_cut() == other.has_cut();
  };
  for (std::size_t k = terms_.size(); k-- > 0;) {
    const auto end = terms_.begin() + static_cast<std::ptrdiff_t>(k);
    if (std::any_of(terms_.begin(), end, [&](const Term& other) { return is_same(terms_[k], other); }))
      terms_.erase(end);
  }
}

/// Adds the cut of atan2(y, x), and its origin if x varies.
void CornerTerms::append_angle(const Instruction& angle) {
  const Instruction& x = expression_.instructions[static_cast<std::size_t>(angle.b)];
  if (x.operation != Expression::Operation::Constant) {
    terms_.push_back({angle.operation, angle.a, angle.b});
    terms_.push_back({angle.operation, angle.c, Term::only_touches_0});
  } else if (x.constant <= 0.0) {
    terms_.push_back({angle.operation, angle.a, -1});
  }
}

/// Returns the values of all instructions; variable(i) is that of the i-th variable.
template <class T, class Variable>
std::vector<T> CornerTerms::run(const Variable& variable) const {
  std::vector<T> values;
  perform_all(expression_, variable, &values);
  return values;
}

void CornerTerms::evaluate(const double* variables, double* arguments) const {
  const std::vector<double> values = run<double>([&](std::size_t i) { return variables[i]; });
  for (const Term& term : terms_) {
    const double a = values[static_cast<std::size_t>(term.a)];
    const double b = term.b < 0 ? 0.0 : values[static_cast<std::size_t>(term.b)];
    *arguments++ = !term.has_cut() ? a - b : b > 0.0 ? std::numeric_limits<double>::quiet_NaN() : a;
  }
}

void CornerTerms::differentiate(std::size_t k, const double* variables, double* gradient) const {
  const Term& term = terms_[k];
  for (std::size_t j = 0; j < num_variables(); ++j) {
    const std::vector<Jet<1>> values =
        run<Jet<1>>([&](std::size_t i) { return i == j ? Jet<1>::variable(variables[i]) : Jet<1>(variables[i]); });
    gradient[j] = values[static_cast<std::size_t>(term.a)].c[1];
    if (term.b >= 0 && !term.has_cut()) gradient[j] -= values[static_cast<std::size_t>(term.b)].c[1];
  }
}

bool CornerTerms::is_bent(std::size_t k, const double* variables, double distance) const {
  constexpr double visible = 1e-3;
  std::vector<double> g(num_variables()), arguments(size()), moved(num_variables());
  evaluate(variables, arguments.data());
  differentiate(k, variables, g.data());
  g.back() = 0.0;  // the time
  double slope = 0.0;
  for (const double each : g) slope = std::hypot(slope, each);
  if (terms_[k].b == Term::only_touches_0) return arguments[k] == 0.0;
  if (!(std::abs(arguments[k]) <= distance * slope) || slope == 0.0) return false;
  std::vector<double> sides[2];
  for (const double sign : {-1.0, 1.0}) {
    std::vector<double>& gradient = sides[sign < 0.0 ? 0 : 1];
    for (std::size_t j = 0; j < g.size(); ++j) moved[j] = variables[j] + 2.0 * sign * distance / slope * g[j];
    for (std::size_t j = 0; j + 1 < g.size(); ++j) {
      const std::vector<Jet<1>> values =
          run<Jet<1>>([&](std::size_t i) { return i == j ? Jet<1>::variable(moved[i]) : Jet<1>(moved[i]); });
      for (const int result : expression_.results) gradient.push_back(values[static_cast<std::size_t>(result)].c[1]);
    }
  }
  double size = 0.0, apart = 0.0;
  for (std::size_t j = 0; j < sides[0].size(); ++j) {
    size = std::hypot(size, sides[0][j], sides[1][j]);
    apart = std::hypot(apart, sides[1][j] - sides[0][j]);
  }
  return !(apart <= visible * size);
}

std::string CornerTerms::name(std::size_t k, std::span<const std::string> variables) const {
  const Term& term = terms_[k];
  const std::string name = term.operation == Expression::Operation::Abs     ? "abs"
                           : term.operation == Expression::Operation::Sqrt  ? "sqrt"
                           : term.operation == Expression::Operation::Exp   ? "a power"
                           : term.operation == Expression::Operation::Atan2 ? "atan2"
                           : term.operation == Expression::Operation::Min   ? "min"
                                                                            : "max";
  const auto place = std::ranges::find(expression_.variables, term.a);
  if (term.b >= 0 || place == expression_.variables.end()) return name;
  const auto& variable = variables[static_cast<std::size_t>(place - expression_.variables.begin())];
  return name + "(" + variable + (term.operation == Expression::Operation::Sqrt && term.b == -1 ? "^2)" : ")");
}

}  // namespace tanor::detail
