#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include <tanor/observables.hpp>

#include "observe/quantity.hpp"
#include "system/formula.hpp"

namespace tanor::detail {

/// The text of an observable, parsed for a system: a quantity of things, or a formula of several.
///
///   text  = term | formula of t, parameters and terms that are single numbers
///   term  = [max | min | sum | each | any] quantity(argument {, argument}) [.part]
///
/// `part` is x, y, z or norm of a vector. Without a word before it, a term has the numbers of all members, but loads,
/// forces and moments are added up.
class ObservedText {
 public:
  /// Throws InputError with the text, or all of which it is a part, the column and what would be right.
  ObservedText(const Things& things, std::string_view text, const Constants& parameters, std::string_view all);
  ObservedText(ObservedText&&) = default;  // copies would share the scratch of quantities
  ObservedText& operator=(ObservedText&&) = default;

  Needs needs() const { return needs_; }
  /// Returns the names and the unit, without numbers.
  Observed describe(const Units& units) const;
  /// Writes the numbers, and the member of a term with max or min alone, whose number is returned.
  std::size_t evaluate(const ObservedInstant& at, Observed* to) const;
  /// Returns the number of a text that has one only.
  double number(const ObservedInstant& at) const;

  /// Returns true if some term has `any`.
  bool is_any() const {
    return std::ranges::any_of(terms_, [](const Term& term) { return term.word == Word::Any; });
  }
  /// Returns true if something of which the text speaks was taken out as a whole.
  bool is_gone() const {
    return std::ranges::any_of(terms_, [](const Term& term) { return term.quantity.is_gone(); });
  }
  /// Says why a number is not known that was just evaluated, where what was taken out is not the reason; or nothing.
  std::string explain(const ObservedInstant& at) const;
  /// Lists the members that were taken out with `when(place in the system)`.
  std::string explain_gone(const std::function<std::string(const std::string& place)>& when) const;
  /// Returns true for a term alone with max or min.
  bool takes_member() const { return lone() && terms_[0].is_reduced(); }
  bool is_number() const { return !lone() || (terms_[0].columns() == 1); }
  /// Returns the quantity and its thing for a term alone; null for a formula.
  const Quantity* quantity() const { return lone() ? &terms_[0].quantity : nullptr; }
  /// Takes the largest (1) or the smallest (-1) member for `any`.
  void take_any(int sign);

 private:
  enum class Word { None, Max, Min, Sum, Each, Any };
  struct Term {
    Word word = Word::None;
    Quantity quantity;
    std::optional<std::size_t> part;  ///< num_parts() for the norm
    bool skips_unknown = false;       ///< of `any`: members that are not known meet no condition
    mutable std::vector<double> values, numbers;

    bool is_reduced() const { return word == Word::Max || word == Word::Min; }
    std::size_t num_members() const;
    std::size_t num_parts() const;
    std::size_t columns() const { return num_members() * num_parts(); }
    /// Computes `numbers`; returns the member that max or min took.
    std::size_t evaluate(const ObservedInstant& at) const;
  };
  class Reader;

  bool lone() const { return !formula_; }

  std::vector<Term> terms_;
  std::optional<Formula> formula_;  ///< of t and the terms; none for a term alone
  Needs needs_;
  mutable std::vector<double> variables_;
};

}  // namespace tanor::detail
