#include "observe/observed_text.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "base/suggestion.hpp"
#include "base/text.hpp"

namespace tanor {
using namespace detail;

namespace {

bool is_letter(char c) {
  return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || c == '_';
}

std::size_t skip_spaces(std::string_view text, std::size_t place) {
  while (place < text.size() && (text[place] == ' ' || text[place] == '\t')) ++place;
  return place;
}

std::string_view word_at(std::string_view text, std::size_t place) {
  std::size_t end = place;
  while (end < text.size() && (is_letter(text[end]) || (end > place && '0' <= text[end] && text[end] <= '9'))) ++end;
  return text.substr(place, end - place);
}

const QuantityKind* find_kind(std::string_view name) {
  const auto kinds = quantity_kinds();
  const auto found = std::ranges::find(kinds, name, &QuantityKind::name);
  return found == kinds.end() ? nullptr : &*found;
}

}  // namespace

std::size_t ObservedText::Term::num_members() const {
  const bool is_one = is_reduced() || word == Word::Sum || (word == Word::None && quantity.is_sum);
  return is_one ? 1 : quantity.num_members;
}

std::size_t ObservedText::Term::num_parts() const {
  return part || is_reduced() ? 1 : quantity.num_parts();
}

std::size_t ObservedText::Term::evaluate(const ObservedInstant& at) const {
  const std::size_t members = quantity.num_members, parts = quantity.num_parts();
  values.resize(members * parts);
  quantity.evaluate(at, values.data());
  const std::size_t own_members = num_members(), own_parts = num_parts();
  const bool sums = own_members == 1 && members != 1 && !is_reduced(), is_known = sums && !quantity.is_gone();
  for (const std::size_t k : quantity.absent)
    std::fill_n(values.data() + k * parts, parts, is_known ? 0.0 : std::numeric_limits<double>::quiet_NaN());
  const auto number_of = [&](std::size_t k) {
    const double* const first = values.data() + k * parts;
    if (part && *part < parts) return first[*part];
    return parts == 1 ? first[0] : std::sqrt(std::inner_product(first, first + parts, first, 0.0));
  };
  if (!is_reduced() && own_members == members && own_parts == parts && !part) return numbers.swap(values), 0;
  numbers.resize(own_members * own_parts);
  if (is_reduced()) {
    std::size_t best = 0, num_known = 0;
    for (std::size_t k = 0; k < members; ++k) {
      num_known += std::isnan(number_of(k)) ? 0 : 1;
      if (std::isnan(number_of(best)) ||
          (word == Word::Max ? number_of(k) > number_of(best) : number_of(k) < number_of(best)))
        best = k;
    }
    // A member that is not known may be the largest; one that went is not.
    const bool is_decided = skips_unknown || num_known + quantity.absent.size() == members;
    numbers[0] = is_decided ? number_of(best) : std::numeric_limits<double>::quiet_NaN();
    return best;
  }
  for (std::size_t k = 1; sums && k < members; ++k)
    for (std::size_t p = 0; p < parts; ++p) values[p] += values[k * parts + p];
  for (std::size_t k = 0; k < own_members; ++k) {
    if (own_parts == 1)
      numbers[k] = number_of(k);
    else
      std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(k * parts), parts,
                  numbers.begin() + static_cast<std::ptrdiff_t>(k * parts));
  }
  return 0;
}

/// Reads terms where a formula has names.
class ObservedText::Reader {
 public:
  Reader(const Things& things, const Constants& parameters, ObservedText* to)
      : things_(things), parameters_(parameters), to_(*to) {}

  /// Reads a term at a place of the text and moves it behind; returns its variable, or nothing if there is none.
  std::optional<int> read(std::string_view text, std::size_t* place) {
    const std::size_t begin = *place;
    std::string_view name = word_at(text, begin);
    Term term;
    term.word = find_word(name);
    std::size_t at = begin;
    if (term.word != Word::None) {
      const std::size_t next = skip_spaces(text, begin + name.size());
      const std::string_view then = word_at(text, next);
      const bool is_function = term.word == Word::Max || term.word == Word::Min;
      if (then.empty() && !is_function && next < text.size() && text[next] == '(')
        throw TextFault{begin, std::string(name) + " stands before a quantity without brackets, any tension(links)"};
      if (then.empty()) return {};  // max(a, b) of formulas
      at = next;
      name = then;
    }
    std::size_t bracket = skip_spaces(text, at + name.size());
    const bool has_bracket = bracket < text.size() && text[bracket] == '(';
    const QuantityKind* const kind = find_kind(name);
    if (kind == nullptr) {
      if (term.word == Word::None) return {};  // a name of formulas, or unknown there
      std::vector<std::string> known;
      for (const QuantityKind& each : quantity_kinds()) known.emplace_back(each.name);
      std::string problem = "'" + std::string(name) + "' is no quantity" + suggest(name, known);
      if (problem.back() != ')')
        for (const std::string& each : known) problem += (each == known[0] ? "; they are " : ", ") + each;
      throw TextFault{at, problem};
    }
    if (!has_bracket && term.word == Word::None && parameters_.contains(std::string(name))) return {};
    if (!has_bracket)
      throw TextFault{at, std::string(name) + " has no brackets behind it; " + std::string(name) + "(" +
                              std::string(kind->arguments) + ") is right"};
    const Arguments arguments = read_arguments(text, name, at, &bracket);
    term.quantity = kind->make(things_, arguments);
    if (term.quantity.num_members == 0)
      throw TextFault{at, std::string(text.substr(at, bracket - at)) + " has no members"};
    read_part(text, &bracket, &term);
    *place = bracket;
    to_.terms_.push_back(std::move(term));
    places_.push_back(begin);
    return static_cast<int>(to_.terms_.size());
  }

  /// Checks that the terms of a formula are single numbers.
  void require_numbers() const {
    for (std::size_t k = 0; k < places_.size(); ++k) {
      const Term& term = to_.terms_[k];
      if (term.num_parts() > 1)
        throw TextFault{places_[k], "a vector stands in a formula; take one of its parts, " + list_parts(term)};
      if (term.num_members() > 1)
        throw TextFault{places_[k],
                        "a formula needs one number of these " + text(term.num_members()) + "; say max, " +
                            (term.word == Word::Any ? "min or sum in place of any" : "min or sum before it") +
                            ", or name one member"};
    }
  }

 private:
  static Word find_word(std::string_view name) {
    constexpr std::pair<std::string_view, Word> words[] = {
        {"max", Word::Max}, {"min", Word::Min}, {"sum", Word::Sum}, {"each", Word::Each}, {"any", Word::Any}};
    for (const auto& [word, meaning] : words)
      if (word == name) return meaning;
    return Word::None;
  }

  static std::string list_parts(const Term& term) {
    std::string list;
    for (const std::string& part : term.quantity.parts) list += "." + part + ", ";
    return list + "or .norm";
  }

  /// Reads ".x" behind a term.
  static void read_part(std::string_view text, std::size_t* place, Term* term) {
    if (*place + 1 >= text.size() || text[*place] != '.' || !is_letter(text[*place + 1])) return;
    const std::string_view word = word_at(text, *place + 1);
    const std::vector<std::string>& parts = term->quantity.parts;
    const auto found = std::ranges::find(parts, word);
    if (found == parts.end() && (word != "norm" || parts.empty())) {
      throw TextFault{*place, parts.empty() ? "." + std::string(word) + " is asked of a number, which has no parts"
                                            : "there is no part ." + std::string(word) + "; take " + list_parts(*term)};
    }
    term->part = static_cast<std::size_t>(found - parts.begin());
    *place += 1 + word.size();
  }

  const Things& things_;
  const Constants& parameters_;
  ObservedText& to_;
  std::vector<std::size_t> places_;
};

ObservedText::ObservedText(const Things& things, std::string_view text, const Constants& parameters,
                           std::string_view all) {
  Reader reader(things, parameters, this);
  const std::vector<std::string> variables{"t"};
  OwnVariables own{
      [&](std::string_view part, std::size_t* place) { return reader.read(part, place); }, {"sum", "each", "any"}, all};
  for (const QuantityKind& each : quantity_kinds()) own.names.emplace_back(each.name);
  Formula formula(text, variables, parameters, own);
  const bool is_lone = terms_.size() == 1 && formula.is_variable(1);
  if (!is_lone) {
    try {
      reader.require_numbers();
    } catch (const TextFault& fault) {
      Formula::refuse(text, fault, all);
    }
    formula_ = std::move(formula);
  }
  for (const Term& term : terms_) needs_ |= term.quantity.needs;
  variables_.resize(1 + terms_.size());
}

Observed ObservedText::describe(const Units& units) const {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  Observed observed;
  if (!lone()) {
    observed.values = {unknown};
  } else {
    const Term& term = terms_[0];
    observed.dimension = term.quantity.dimension;
    observed.unit = units.letters(observed.dimension);
    if (term.num_parts() > 1) observed.parts = term.quantity.parts;
    if (term.num_members() > 1)
      for (std::size_t k = 0; k < term.num_members(); ++k) observed.members.push_back(term.quantity.name_member(k));
    observed.values.assign(term.columns(), unknown);
  }
  observed.least.resize(std::max<std::size_t>(1, observed.parts.size()));
  observed.largest = observed.least;
  return observed;
}

std::size_t ObservedText::evaluate(const ObservedInstant& at, Observed* to) const {
  if (!lone()) {
    to->values[0] = number(at);
    return 0;
  }
  const std::size_t member = terms_[0].evaluate(at);
  to->values.swap(terms_[0].numbers);
  if (terms_[0].is_reduced()) to->member = std::isnan(to->values[0]) ? "" : terms_[0].quantity.name_member(member);
  return member;
}

double ObservedText::number(const ObservedInstant& at) const {
  variables_[0] = at.time;
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    terms_[k].evaluate(at);
    variables_[k + 1] = terms_[k].numbers[0];
  }
  return lone() ? variables_[1] : formula_->evaluate<double>(variables_);
}

std::string ObservedText::explain(const ObservedInstant& at) const {
  const auto is_known = [](double number) { return std::isfinite(number); };
  const auto term_is_known = [&](const Term& term) { return std::ranges::all_of(term.numbers, is_known); };
  if (!lone() && std::ranges::all_of(terms_, term_is_known)) return "not defined";
  return needs_.solves() && at.has_prestress ? "left to a prestress" : "";
}

std::string ObservedText::explain_gone(const std::function<std::string(const std::string& place)>& when) const {
  constexpr std::size_t most_names = 3;
  std::string list;
  std::size_t count = 0;
  std::set<std::string> told;
  for (const Term& term : terms_) {
    const bool is_one = terms_.size() == 1 && term.quantity.num_members == 1;
    for (const std::size_t k : term.quantity.absent) {
      const std::string place = place_in_system(*term.quantity.thing(k)), reason = when(place);
      if (reason.empty() || !told.insert(place).second || ++count > most_names) continue;
      list += (list.empty() ? "" : ", ") + (is_one ? "" : term.quantity.name_member(k) + " ") + reason;
    }
  }
  return count <= most_names ? list : list + " and " + text(count - most_names) + " more";
}

void ObservedText::take_any(int sign) {
  for (Term& term : terms_)
    if (term.word == Word::Any) {
      term.word = sign > 0 ? Word::Max : Word::Min;
      term.skips_unknown = true;
    }
}

}  // namespace tanor
