#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <tanor/expression.hpp>

namespace tanor::detail {

/// The terms of an expression that have corners: abs(a) and sqrt(a a) where a = 0, min and max of a and b where a = b,
/// atan2(y, x) where y = 0 and x <= 0. Each term has two branches, on which it is smooth. Other roots and powers
/// exp(p log(a)) end where a = 0, and angles where x and y are.
class CornerTerms {
 public:
  explicit CornerTerms(const Expression& expression);

  bool empty() const { return terms_.empty(); }
  std::size_t size() const { return terms_.size(); }
  std::size_t num_variables() const { return expression_.variables.size(); }

  /// Evaluates the argument u of each term: a of abs(a) and sqrt(a^2), b - a of min, a - b of max, y of atan2(y, x).
  /// The expression takes one branch where u < 0, the other one elsewhere. The argument is NaN where a term has one
  /// branch, as an angle with x > 0. Another root or power has its own argument, and the origin of an angle x^2 + y^2,
  /// which can only touch 0; no tangent exists there.
  void evaluate(const double* variables, double* arguments) const;
  /// Writes the partial derivatives of the argument of term k in all variables.
  void differentiate(std::size_t k, const double* variables, double* gradient) const;
  /// Returns true if the gradient of the expression jumps where term k has its corner, and the variables, of which the
  /// last one is the time, are no further than a distance from there.
  bool is_bent(std::size_t k, const double* variables, double distance) const;
  /// Returns "abs(x1)", or "min" if the argument is no variable. The variables have these names.
  std::string name(std::size_t k, std::span<const std::string> variables) const;

 private:
  struct Term {
    Expression::Operation operation;
    int a, b;  // u is a, or a - b if b is not negative
    static constexpr int only_touches_0 = -2;
    bool has_cut() const { return operation == Expression::Operation::Atan2 && b >= 0; }
  };
  void append_angle(const Expression::Instruction& angle);

  template <class T, class Variable>
  std::vector<T> run(const Variable& variable) const;

  Expression expression_;
  std::vector<Term> terms_;
};

}  // namespace tanor::detail
