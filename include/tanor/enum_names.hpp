#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tanor/motion.hpp>

/// \file
/// The words of all enumerations: one table for each, which scenes, reports, messages and the command line share. (The
/// table of methods is `tanor::methods()`.)
namespace tanor {

/// One value of an enumeration and its word.
template <class Enum>
struct EnumName {
  Enum value;
  std::string_view name;
};

/// The table of an enumeration, in the order of its values.
template <class Enum>
inline constexpr std::array<EnumName<Enum>, 0> enum_names{};

template <>
inline constexpr std::array<EnumName<Status>, 8> enum_names<Status>{{{Status::Ok, "ok"},
                                                                     {Status::Singular, "singular"},
                                                                     {Status::Contradictory, "contradictory"},
                                                                     {Status::NotConverged, "not_converged"},
                                                                     {Status::NotFinite, "not_finite"},
                                                                     {Status::StepTooSmall, "step_too_small"},
                                                                     {Status::NoSolution, "no_solution"},
                                                                     {Status::NotUnique, "not_unique"}}};

template <>
inline constexpr std::array<EnumName<EventAction>, 4> enum_names<EventAction>{{{EventAction::Report, "report"},
                                                                               {EventAction::Stop, "stop"},
                                                                               {EventAction::Break, "break"},
                                                                               {EventAction::Release, "release"}}};

template <>
inline constexpr std::array<EnumName<OneSide>, 2> enum_names<OneSide>{
    {{OneSide::AtLeast, "at_least"}, {OneSide::AtMost, "at_most"}}};

template <>
inline constexpr std::array<EnumName<ContactChange>, 8> enum_names<ContactChange>{{{ContactChange::Snap, "snap"},
                                                                                   {ContactChange::Slack, "slack"},
                                                                                   {ContactChange::Touch, "touch"},
                                                                                   {ContactChange::LiftOff, "lift_off"},
                                                                                   {ContactChange::Zeno, "zeno"},
                                                                                   {ContactChange::Stick, "stick"},
                                                                                   {ContactChange::Slip, "slip"},
                                                                                   {ContactChange::Jam, "jam"}}};

template <>
inline constexpr std::array<EnumName<Ordering>, 7> enum_names<Ordering>{{{Ordering::Auto, "auto"},
                                                                         {Ordering::Amd, "amd"},
                                                                         {Ordering::Metis, "metis"},
                                                                         {Ordering::Nesdis, "nesdis"},
                                                                         {Ordering::Natural, "natural"},
                                                                         {Ordering::Axes, "axes"},
                                                                         {Ordering::Points, "points"}}};

template <>
inline constexpr std::array<EnumName<Form>, 4> enum_names<Form>{
    {{Form::Auto, "auto"}, {Form::Normal, "normal"}, {Form::Tangent, "tangent"}, {Form::Both, "both"}}};

template <>
inline constexpr std::array<EnumName<FrictionMethod>, 5> enum_names<FrictionMethod>{
    {{FrictionMethod::Auto, "auto"},
     {FrictionMethod::FixedPoint, "fixed_point"},
     {FrictionMethod::Anderson, "anderson"},
     {FrictionMethod::Newton, "newton"},
     {FrictionMethod::Enumeration, "enumeration"}}};

template <>
inline constexpr std::array<EnumName<LinearSolver>, 7> enum_names<LinearSolver>{
    {{LinearSolver::Auto, "auto"},
     {LinearSolver::General, "general"},
     {LinearSolver::Paths, "paths"},
     {LinearSolver::Trees, "trees"},
     {LinearSolver::Batches, "batches"},
     {LinearSolver::ClosedForm, "closed_form"},
     {LinearSolver::Cholmod, "cholmod"}}};

template <>
inline constexpr std::array<EnumName<Factorization>, 3> enum_names<Factorization>{
    {{Factorization::Simplicial, "simplicial"},
     {Factorization::Multifrontal, "multifrontal"},
     {Factorization::ClosedForm, "closed_form"}}};

template <>
inline constexpr std::array<EnumName<Uniqueness>, 5> enum_names<Uniqueness>{{{Uniqueness::NotAsked, "not_asked"},
                                                                             {Uniqueness::Proven, "proven"},
                                                                             {Uniqueness::Unproven, "unproven"},
                                                                             {Uniqueness::Several, "several"},
                                                                             {Uniqueness::None, "none"}}};

template <>
inline constexpr std::array<EnumName<StartMode>, 2> enum_names<StartMode>{
    {{StartMode::Check, "check"}, {StartMode::Project, "project"}}};

template <>
inline constexpr std::array<EnumName<Stabilisation>, 2> enum_names<Stabilisation>{
    {{Stabilisation::Projection, "projection"}, {Stabilisation::None, "none"}}};

template <>
inline constexpr std::array<EnumName<Event::Direction>, 3> enum_names<Event::Direction>{
    {{Event::Direction::Both, "both"}, {Event::Direction::Rising, "rising"}, {Event::Direction::Falling, "falling"}}};

template <>
inline constexpr std::array<EnumName<PairLaw>, 6> enum_names<PairLaw>{{{PairLaw::Wca, "wca"},
                                                                       {PairLaw::Lj, "lj"},
                                                                       {PairLaw::Log, "log"},
                                                                       {PairLaw::Coulomb, "coulomb"},
                                                                       {PairLaw::Yukawa, "yukawa"},
                                                                       {PairLaw::Morse, "morse"}}};

template <>
inline constexpr std::array<EnumName<BondLaw>, 3> enum_names<BondLaw>{
    {{BondLaw::Harmonic, "harmonic"}, {BondLaw::Fene, "fene"}, {BondLaw::Morse, "morse"}}};

template <>
inline constexpr std::array<EnumName<BendingLaw>, 3> enum_names<BendingLaw>{
    {{BendingLaw::Harmonic, "harmonic"},
     {BendingLaw::CosineHarmonic, "cosine_harmonic"},
     {BendingLaw::Cosine, "cosine"}}};

template <>
inline constexpr std::array<EnumName<TorsionLaw>, 4> enum_names<TorsionLaw>{{{TorsionLaw::Opls, "opls"},
                                                                             {TorsionLaw::Multi, "multi"},
                                                                             {TorsionLaw::Periodic, "periodic"},
                                                                             {TorsionLaw::Harmonic, "harmonic"}}};

template <>
inline constexpr std::array<EnumName<Coulomb::Reaction>, 2> enum_names<Coulomb::Reaction>{
    {{Coulomb::Reaction::Guide, "guide"}, {Coulomb::Reaction::Full, "full"}}};

/// Returns the word of a value; "?" for a number that is none of the enumeration's.
template <class Enum>
constexpr std::string_view name_of(Enum value) {
  static_assert(!enum_names<Enum>.empty(), "each public enumeration has its table above");
  for (const auto& [each, name] : enum_names<Enum>) {
    if (each == value) return name;
  }
  return "?";
}

/// Returns the value that has this word, or none.
template <class Enum>
constexpr std::optional<Enum> value_of(std::string_view word) {
  static_assert(!enum_names<Enum>.empty(), "each public enumeration has its table above");
  for (const auto& [value, name] : enum_names<Enum>) {
    if (name == word) return value;
  }
  return {};
}

/// Returns the words of several values, joined by '+': "batches+general".
template <class Enum>
std::string names_of(const std::vector<Enum>& values) {
  std::string text;
  for (const Enum value : values) text += (text.empty() ? "" : "+") + std::string(name_of(value));
  return text;
}

[[deprecated("its name is name_of")]] inline std::string_view method_name(Method method) {
  return name_of(method);
}
[[deprecated("its name is name_of")]] inline std::string_view friction_method_name(FrictionMethod method) {
  return name_of(method);
}
[[deprecated("its name is name_of")]] inline std::string_view uniqueness_name(Uniqueness uniqueness) {
  return name_of(uniqueness);
}

}  // namespace tanor
