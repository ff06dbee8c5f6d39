#include <algorithm>
#include <array>
#include <string>

#include "base/check.hpp"
#include "motion/composition.hpp"
#include "motion/generalized_alpha.hpp"
#include "motion/radau.hpp"
#include "motion/rattle.hpp"
#include "motion/runge_kutta.hpp"
#include "motion/taylor.hpp"

namespace tanor {
using namespace detail;

namespace {

using MakeScheme = std::unique_ptr<Scheme> (*)(const IntegrationOptions&, Mechanics&);

template <Tableau (*tableau)()>
std::unique_ptr<Scheme> make_runge_kutta(const IntegrationOptions& options, Mechanics& mechanics) {
  return std::make_unique<RungeKutta>(tableau(), options, mechanics);
}
template <int order, std::span<const double> (*fractions)()>
std::unique_ptr<Scheme> make_composition(const IntegrationOptions&, Mechanics& mechanics) {
  return std::make_unique<Composition>(order, fractions(), mechanics);
}
std::unique_ptr<Scheme> make_rattle(const IntegrationOptions&, Mechanics& mechanics) {
  return std::make_unique<Rattle>(mechanics);
}
template <class Own>
std::unique_ptr<Scheme> make_own(const IntegrationOptions& options, Mechanics& mechanics) {
  return std::make_unique<Own>(options, mechanics);
}

/// A method consists of its Scheme, its value of enum Method and one row here (docs/contributing.md, "How to add a
/// method").
struct Row {
  MethodTraits traits;
  MakeScheme make;
};
constexpr Row row(MethodTraits traits, const MethodCost& cost, MakeScheme make) {
  traits.cost = cost;
  return {traits, make};
}
constexpr bool fixed = true, adaptive = false, implicitly = true, explicitly = false, with_friction = true,
               no_friction = false, in_coordinates = true, in_positions = false, compared = true;
constexpr std::array table{
    row({Method::Auto, "auto", "the method that suits the scene; the report says which one and why", 0, adaptive,
         explicitly, with_friction, in_coordinates, compared},
        {}, nullptr),
    row({Method::Rk4, "rk4", "classical Runge-Kutta method", 4, fixed, explicitly, with_friction, in_coordinates,
         compared},
        {4.0, 4.0, 2.0, 70.0}, make_runge_kutta<rk4_tableau>),
    // The seventh stage is the first one of the next step.
    row({Method::Dopri5, "dopri5", "Dormand & Prince 5(4)", 5, adaptive, explicitly, with_friction, in_coordinates,
         compared},
        {6.0, 6.0, 6.0, 140.0}, make_runge_kutta<dopri5_tableau>),
    row({Method::Dop853, "dop853", "Dormand & Prince 8(5,3)", 8, adaptive, explicitly, with_friction, in_coordinates,
         compared},
        {12.0, 12.0, 6.0, 280.0}, make_runge_kutta<dop853_tableau>),
    row({Method::Taylor, "taylor", "power series in time, as long as the tolerance asks", 0, adaptive, explicitly,
         no_friction, in_positions, compared},
        {1.0, 1.0, 6.0, 57.0, 35.0}, make_own<Taylor>),
    row({Method::Rattle, "rattle", "velocity Verlet with constraints; energy does not drift", 2, fixed, explicitly,
         with_friction, in_positions, compared},
        {4.0, 1.0, 0.0}, make_rattle),
    row({Method::Rattle4, "rattle4", "five steps of rattle (Suzuki)", 4, fixed, explicitly, with_friction,
         in_positions},
        {18.0, 5.0, 0.0}, make_composition<4, suzuki_fractions>),
    row({Method::Rattle6, "rattle6", "nine steps of rattle (Kahan & Li)", 6, fixed, explicitly, with_friction,
         in_positions},
        {32.0, 9.0, 0.0, 140.0}, make_composition<6, kahan_li_fractions>),
    row({Method::Radau5, "radau5", "Radau IIA, for stiff systems", 5, adaptive, implicitly, no_friction, in_positions},
        {10.0, 2.0, 0.0, 2400.0, 0.0, 970.0}, make_own<Radau5>),
    row({Method::GeneralizedAlpha, "generalized_alpha", "generalized alpha method, for stiff systems", 2, fixed,
         implicitly, no_friction, in_positions},
        {7.0, 1.0, 0.0, 1150.0, 0.0, 460.0}, make_own<GeneralizedAlpha>),
};

const Row& row_of(Method method) {
  const auto row =
      std::find_if(table.begin(), table.end(), [&](const Row& each) { return each.traits.method == method; });
  ensure(row != table.end(), "every method has its row");
  return *row;
}

}  // namespace

std::span<const MethodTraits> methods() {
  static const auto traits = [] {
    std::array<MethodTraits, table.size()> result;
    std::transform(table.begin(), table.end(), result.begin(), [](const Row& row) { return row.traits; });
    return result;
  }();
  return traits;
}

const MethodTraits& traits_of(Method method) {
  return row_of(method).traits;
}

Method method_from_name(std::string_view name) {
  std::string known;
  for (const MethodTraits& each : methods()) {
    if (each.name == name) return each.method;
    known += (known.empty() ? "" : ", ") + std::string(each.name);
  }
  throw InputError("", "method \"" + std::string(name) + "\" is not known; this version has " + known);
}

std::string_view name_of(Method method) {
  return traits_of(method).name;
}

bool has_fixed_steps(Method method) {
  return traits_of(method).has_fixed_steps;
}

std::unique_ptr<Scheme> detail::make_scheme(Method method, const IntegrationOptions& options, Mechanics& mechanics) {
  const MakeScheme make = row_of(method).make;
  ensure(make != nullptr, "auto is resolved before a scheme is made");
  return make(options, mechanics);
}

}  // namespace tanor
