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

namespace {

struct Entry {
  Method method;
  std::string_view name;
  bool has_fixed_steps = false;
};
constexpr std::array methods{
    Entry{Method::Auto, "auto"},
    Entry{Method::Rk4, "rk4", true},
    Entry{Method::Dopri5, "dopri5"},
    Entry{Method::Dop853, "dop853"},
    Entry{Method::Taylor, "taylor"},
    Entry{Method::Rattle, "rattle", true},
    Entry{Method::Rattle4, "rattle4", true},
    Entry{Method::Rattle6, "rattle6", true},
    Entry{Method::Radau5, "radau5"},
    Entry{Method::GeneralizedAlpha, "generalized_alpha", true},
};

}  // namespace

Method method_from_name(std::string_view name) {
  std::string known;
  for (const Entry& entry : methods) {
    if (entry.name == name) return entry.method;
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw InputError("", "method \"" + std::string(name) + "\" is not known; this version has " + known);
}

std::string_view method_name(Method method) {
  for (const Entry& entry : methods) {
    if (entry.method == method) return entry.name;
  }
  return "";
}

bool has_fixed_steps(Method method) {
  return std::any_of(methods.begin(), methods.end(),
                     [&](const Entry& entry) { return entry.method == method && entry.has_fixed_steps; });
}

std::unique_ptr<Scheme> make_scheme(Method method, const MotionOptions& options, Mechanics& mechanics) {
  switch (method) {
    case Method::Rk4:
      return std::make_unique<RungeKutta>(rk4_tableau(), options, mechanics);
    case Method::Dopri5:
      return std::make_unique<RungeKutta>(dopri5_tableau(), options, mechanics);
    case Method::Dop853:
      return std::make_unique<RungeKutta>(dop853_tableau(), options, mechanics);
    case Method::Rattle:
      return std::make_unique<Rattle>(mechanics);
    case Method::Taylor:
      return std::make_unique<Taylor>(options, mechanics);
    case Method::Rattle4:
      return std::make_unique<Composition>(4, suzuki_fractions(), mechanics);
    case Method::Rattle6:
      return std::make_unique<Composition>(6, kahan_li_fractions(), mechanics);
    case Method::Radau5:
      return std::make_unique<Radau5>(options, mechanics);
    case Method::GeneralizedAlpha:
      return std::make_unique<GeneralizedAlpha>(options, mechanics);
    case Method::Auto:
      break;
  }
  ensure(false, "auto is resolved before a scheme is made");
  return nullptr;
}

}  // namespace tanor
