#include "observe/observables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "base/parallel.hpp"
#include "evaluate/forces.hpp"
#include "system/formula_names.hpp"
#include "system/strengths.hpp"

namespace tanor {
using namespace detail;

namespace {

/// Takes one part of all members into its extremes.
void widen(const Observed& seen, std::size_t part, double time, Extreme* least, Extreme* largest) {
  // Many members at every step ask for a loop that compilers vectorize: they do with a count in double precision.
  const double low = least->value, high = largest->value;
  double outside = 0.0;
  for (const double value : seen.values) outside += low <= value && value <= high ? 0.0 : 1.0;
  if (outside == 0.0) return;
  for (std::size_t i = part, parts = seen.least.size(); i < seen.values.size(); i += parts) {
    const double value = seen.values[i];
    if (!std::isfinite(value)) continue;
    const auto take = [&](Extreme* to) {
      *to = {value, time, seen.members.empty() ? seen.member : seen.members[i / parts]};
    };
    if (!(value >= least->value)) take(least);
    if (!(value <= largest->value)) take(largest);
  }
}

/// Other answers of equations that do not tell all forces: a large self-stress is added to them, with either sign.
/// Beside these two, one in which every force is another tells how much a number depends on forces at all.
class OtherAnswers {
 public:
  OtherAnswers(const System& system, const Definitions& definitions, const ObservedInstant& at) {
    constexpr double large = 1e9;  // beside the forces, so that it decides which member has the largest one
    double size = 0.0, stress = 0.0;
    for (const double each : at.multipliers) size = std::max(size, std::isnan(each) ? 0.0 : std::abs(each));
    for (const double each : at.self_stress) stress = std::max(stress, std::abs(each));
    const double change = large * (size > 0.0 ? size : 1.0);
    std::vector<double> eta(at.positions.size());
    definitions.reactions(at.time, at.positions, at.self_stress, eta);
    std::vector<char> is_held(eta.size() / 3, 0);
    for (const Support& support : system.supports)
      for (const Index point : support.points) is_held[static_cast<std::size_t>(point)] = 1;
    for (std::size_t i = 0; i < is_held.size(); ++i)  // where the rank was decided to fewer digits, some is left
      if (is_held[i] == 0) rounding_ = std::max(rounding_, 10.0 * norm(load(eta.data(), i)) / stress);
    for (std::size_t answer = 0; answer < answers_.size(); ++answer) {
      Answer& to = answers_[answer];
      to.instant = at;
      to.multipliers.assign(at.multipliers.begin(), at.multipliers.end());
      to.reactions.assign(at.reactions.begin(), at.reactions.end());
      to.loads.assign(at.support_forces.begin(), at.support_forces.end());
      if (answer == 2) {
        for (std::vector<double>* const forces : {&to.multipliers, &to.reactions, &to.loads})
          for (std::size_t i = 0; i < forces->size(); ++i)
            (*forces)[i] += change * (1.5 + std::cos(2.3 * static_cast<double>(i)));
      } else {
        const double by = (answer == 0 ? change : -change) / stress;
        for (std::size_t row = 0; row < to.multipliers.size(); ++row) to.multipliers[row] += by * at.self_stress[row];
        for (std::size_t i = 0; i < is_held.size(); ++i)
          for (std::vector<double>* const forces : {&to.reactions, &to.loads})
            if (is_held[i] != 0 && !forces->empty()) add_to(forces->data(), i, by * load(eta.data(), i));
      }
      to.instant.multipliers = to.multipliers;
      to.instant.reactions = to.reactions;
      to.instant.support_forces = to.loads;
    }
  }

  /// Makes the numbers NaN that are others in another answer.
  void forget(const ObservedText& text, Observed* seen) const {
    std::array<Observed, 3> other;
    for (std::size_t answer = 0; answer < 3; ++answer) {
      other[answer].values.resize(1);
      text.evaluate(answers_[answer].instant, &other[answer]);
    }
    for (std::size_t i = 0; i < seen->values.size(); ++i) {
      double& value = seen->values[i];
      const auto change = [&](std::size_t answer) { return std::abs(other[answer].values[i] - value); };
      if (!(std::max(change(0), change(1)) > rounding_ * change(2))) continue;
      value = std::numeric_limits<double>::quiet_NaN();
      seen->unknown = "not unique";
      seen->member.clear();
    }
  }

 private:
  struct Answer {
    ObservedInstant instant;
    std::vector<double> multipliers, reactions, loads;
  };
  std::array<Answer, 3> answers_;
  double rounding_ = 1e-8;
};

bool has_unknown(const Observed& seen) {
  return std::ranges::any_of(seen.values, [](double each) { return std::isnan(each); });
}

/// Returns the place of the comparison in a condition, outside of brackets and quotes.
std::size_t find_comparison(std::string_view text) {
  int depth = 0;
  Quotes quotes;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quotes.hold(c)) continue;
    if (c == '(' || c == '[') ++depth;
    if (c == ')' || c == ']') --depth;
    if (depth == 0 && (c == '<' || c == '>')) return i;
  }
  return std::string_view::npos;
}

}  // namespace

std::size_t Observables::add(const Observable& what) {
  ObservedText parsed(things_, what.text, what.parameters, what.text);
  if (parsed.is_any()) throw InputError("", "formula \"" + what.text + "\": any belongs to conditions; say max or min");
  Observed observed = parsed.describe(system_.units);
  observed.name = what.name.empty() ? what.text : what.name;
  observed.text = what.text;
  if (!what.unit.empty()) {
    if (!observed.unit.empty())
      throw InputError("/unit", "\"" + what.unit + "\": \"" + what.text + "\" is in " + observed.unit + " already");
    if (what.unit.find_first_of("\"\r\n") != std::string::npos)
      throw InputError("/unit", "wanted letters on one line, without quotes");
    observed.unit = what.unit;
  }
  if (const auto same = numbers_.find(observed.name); same != numbers_.end()) {  // a default, say, asked for again
    Observable& given = given_[same->second];
    if (given.text != what.text || given.parameters != what.parameters ||
        (!what.unit.empty() && !given.unit.empty() && given.unit != what.unit))
      throw InputError("", "two observables are named \"" + observed.name + "\"");
    given.every_step |= what.every_step;
    if (!what.unit.empty()) given.unit = found_[same->second].unit = what.unit;
    return same->second;
  }
  check_name(what.name, "/name");
  numbers_.emplace(observed.name, found_.size());
  texts_.push_back(std::move(parsed));
  given_.push_back(what);
  found_.push_back(std::move(observed));
  return found_.size() - 1;
}

void Observables::add(const Observables& others) {
  for (std::size_t k = 0; k < others.given_.size(); ++k) {
    Observed& own = found_[add(others.given_[k])];
    const Observed& before = others.found_[k];
    if (own.parts != before.parts) continue;  // another kind of thing has the name now
    own.least = before.least;
    own.largest = before.largest;
    if (own.members == before.members) own.values = before.values;
    own.member = before.member;
    own.unknown = before.unknown;
  }
}

void Observables::remove(std::size_t number) {
  const auto place = static_cast<std::ptrdiff_t>(number);
  numbers_.erase(found_[number].name);
  for (auto& [name, behind] : numbers_)
    if (behind > number) --behind;
  texts_.erase(texts_.begin() + place);
  given_.erase(given_.begin() + place);
  found_.erase(found_.begin() + place);
}

Needs Observables::needs(Which which) const {
  Needs needs;
  for (std::size_t k = 0; k < texts_.size(); ++k)
    if (which == Which::All || given_[k].every_step) needs |= texts_[k].needs();
  return needs;
}

bool Observables::has_of_every_step() const {
  return std::ranges::any_of(given_, &Observable::every_step);
}

void Observables::take(const ObservedInstant& at, Which which, bool counts) {
  if (which == Which::All) time_ = at.time;
  std::optional<OtherAnswers> others;
  if (!at.self_stress.empty() && needs(which).solves()) {
    if (definitions_ == nullptr) definitions_ = std::make_unique<Definitions>(system_, 0.0);
    others.emplace(system_, *definitions_, at);
  }
  for (std::size_t k = 0; k < texts_.size(); ++k) {
    if (which == Which::OfEveryStep && !given_[k].every_step) continue;
    Observed& seen = found_[k];
    texts_[k].evaluate(at, &seen);
    // A formula that divides by 0 has no number.
    if (texts_[k].quantity() == nullptr && std::isinf(seen.values[0]))
      seen.values[0] = std::numeric_limits<double>::quiet_NaN();
    if (which == Which::All) seen.unknown = has_unknown(seen) ? texts_[k].explain(at) : "";
    if (others && texts_[k].needs().solves()) others->forget(texts_[k], &seen);
    for (std::size_t p = 0; counts && p < seen.least.size(); ++p)
      widen(seen, p, at.time, &seen.least[p], &seen.largest[p]);
  }
}

void Observables::explain_gone(const std::function<std::string(const std::string& place)>& when) {
  for (std::size_t k = 0; k < texts_.size(); ++k) {
    Observed& seen = found_[k];
    const std::string gone = has_unknown(seen) ? texts_[k].explain_gone(when) : "";
    if (gone.empty() || (seen.members.empty() && !texts_[k].is_gone())) continue;
    const bool has_others = !seen.unknown.empty() && !texts_[k].is_gone();
    seen.unknown = has_others ? gone + ", others " + seen.unknown : gone;
  }
}

void detail::refuse_name_of_time(const Observable& what) {
  const std::string problem = "\"t\" is the name of the time in results; give another name";
  if (what.name == "t") throw InputError("/name", problem);
  if (what.name.empty() && what.text == "t") Formula::refuse(what.text, {0, problem});
}

void check_observable(const System& system, const Observable& observable) {
  Observables(system).add(observable);
  refuse_name_of_time(observable);
}

void detail::find_energies(const System& system, const Solution& at, ObservedInstant* energies) {
  std::vector<double> masses = system.masses, r(at.positions.size());
  for (const Support& support : system.supports)
    for (const Index point : support.points) masses[static_cast<std::size_t>(point)] = 0.0;
  energies->kinetic = 0.0;
  for (std::size_t k = 0; k < r.size(); ++k)
    energies->kinetic += 0.5 * masses[k / 3] * at.velocities[k] * at.velocities[k];
  const Numbering numbering = number(system);
  Forces forces(system, numbering);
  numbering.gather_points(at.positions, r);
  forces.set_time(at.time);
  energies->potential = forces.potential(Parallel(1), at.time, r.data());
}

std::vector<Observed> observe(const System& system, std::span<const Observable> wanted, const Solution& at,
                              std::span<const double> friction) {
  Observables observables(system);
  for (const Observable& each : wanted) observables.add(each);
  const std::vector<double> none(at.positions.size());
  ObservedInstant seen{at.time,
                       at.positions,
                       at.velocities,
                       at.accelerations,
                       at.multipliers,
                       at.reactions,
                       at.support_forces,
                       friction.empty() ? none : friction,
                       0.0,
                       0.0,
                       at.degrees_of_freedom,
                       at.self_stress,
                       at.has_prestress};
  if (observables.needs(Observables::Which::All).energy) find_energies(system, at, &seen);
  observables.take(seen, Observables::Which::All);
  return {observables.found().begin(), observables.found().end()};
}

std::vector<std::string> column_names(const Observed& observed) {
  std::vector<std::string> names;
  const auto with_parts = [&](const std::string& name) {
    if (observed.parts.empty()) names.push_back(name);
    for (const std::string& part : observed.parts) names.push_back(name + "." + part);
  };
  if (observed.members.empty()) with_parts(observed.name);
  for (const std::string& member : observed.members) with_parts(observed.name + ": " + member);
  return names;
}

std::vector<Observable> default_observables(const System& system) {
  using List = Thing::List;
  std::vector<Observable> result;
  const Things things(system);
  const auto add = [&](std::string_view quantity, const Thing& thing, std::initializer_list<List> lists,
                       std::initializer_list<const char*> words = {"max ", "min "}) {
    const std::string name = things.name(thing), text = std::string(quantity) + "(" + quoted_name(name) + ")";
    const std::size_t members = things.num_members(thing);
    if (things.find_all(name, lists).size() > 1) return;  // `find_warnings` tells so
    if (members == 1 || (members > 0 && thing.list == List::Supports)) return result.push_back({.text = text});
    for (const char* const word : words)
      if (members > 1) result.push_back({.text = word + text});
  };
  for (std::size_t k = 0; k < system.constraints.size(); ++k) {
    const Constraint& constraint = system.constraints[k];
    if (has_tension(constraint))
      add("tension", {List::Constraints, k}, {List::Constraints, List::Forces});
    else if (std::visit([]<class Group>(const Group&) { return has_single_points<Group>; }, constraint))
      add("force", {List::Constraints, k}, {List::Constraints});
    if (!strengths_of(constraint).empty()) add("utilisation", {List::Constraints, k}, {List::Constraints}, {"max "});
  }
  for (std::size_t k = 0; k < system.supports.size(); ++k) add("load", {List::Supports, k}, {List::Supports});
  if (!system.cell || !system.cell->is_periodic_everywhere()) return result;
  for (const char* const text : {"temperature()", "pressure()"}) result.push_back({.text = text});
  return result;
}

std::vector<Observable> tensions_of_groups(const System& system) {
  using List = Thing::List;
  std::vector<Observable> result;
  const Things things(system);
  const auto add = [&]<class Entries>(List list, const Entries& entries) {
    for (std::size_t k = 0; k < entries.size(); ++k) {
      const std::string name = things.name({list, k});
      if (has_tension(entries[k]) && things.find_all(name, {List::Constraints, List::Forces}).size() == 1 &&
          things.num_members({list, k}) > 0)
        result.push_back({.name = name, .text = "each tension(" + quoted_name(name) + ")"});
    }
  };
  add(List::Constraints, system.constraints);
  add(List::Forces, system.forces);
  return result;
}

Condition::Condition(const Things& things, const std::string& text, const Constants& parameters) {
  const std::size_t place = find_comparison(text);
  if (place == std::string::npos)
    throw InputError("", "formula \"" + text + "\": a condition compares, as in \"any tension(links) > 20\"");
  if (text.substr(place + 1).starts_with('='))
    throw InputError("", "formula \"" + text + "\": found " + text.substr(place, 2) + ", wanted " + text[place] +
                             ", which passes at the same instant");
  const std::string_view all = text;
  left_ = std::make_unique<ObservedText>(things, all.substr(0, place), parameters, all);
  right_ = std::make_unique<ObservedText>(things, all.substr(place + 1), parameters, all);
  sign_ = text[place] == '>' ? 1.0 : -1.0;
  if (left_->quantity() == nullptr && right_->quantity() != nullptr) {  // "20 < any tension(links)"
    std::swap(left_, right_);
    sign_ = -sign_;
  }
  is_any_ = left_->is_any();
  left_->take_any(static_cast<int>(sign_));
  if (!left_->is_number() || !right_->is_number())
    throw InputError("", "formula \"" + text + "\": a condition compares single numbers; say " +
                             (right_->is_any() ? "any on one side, and " : "any, ") + "max, min or sum");
  seen_ = left_->describe({});
}

Needs Condition::needs() const {
  Needs needs = left_->needs();
  return needs |= right_->needs();
}

std::optional<Thing> Condition::thing() const {
  const Quantity* const quantity = left_->quantity();
  if (quantity == nullptr || (!left_->takes_member() && quantity->num_members > 1)) return {};
  return quantity->thing(member_);
}

std::string Condition::explain(const ObservedInstant& at) const {
  for (const ObservedText* const side : {left_.get(), right_.get()})
    if (std::isnan(side->number(at)) && !(is_any_ && side == left_.get())) return side->explain(at);
  return "";
}

double Condition::value(const ObservedInstant& at) const {
  constexpr double never = -1.0;
  if (left_->is_gone() || right_->is_gone()) return never;
  member_ = left_->evaluate(at, &seen_);
  if (is_any_ && std::isnan(seen_.values[0])) return never;  // it knows no member
  return sign_ * (seen_.values[0] - right_->number(at));
}

}  // namespace tanor
