#include <tanor/units.hpp>

#include <algorithm>
#include <array>

#include <tanor/error.hpp>

#include "base/suggestion.hpp"

namespace tanor {
using namespace detail;

namespace {

/// LAMMPS' real and metal units with the unit of time in which F = m a holds; constants of CODATA 2018.
const std::array<Units, 5> known{{
    {},
    {"si", "m", "kg", "s", "N", "J", "K", "Pa", 1.380649e-23},
    {"lj", "sigma", "m", "tau", "epsilon/sigma", "epsilon", "epsilon/k", "epsilon/sigma^3", 1.0},
    {"real", "angstrom", "g/mol", "48.88821 fs", "kcal/mol/angstrom", "kcal/mol", "K", "kcal/mol/angstrom^3",
     0.0019872042586408316},
    {"metal", "angstrom", "g/mol", "10.18051 fs", "eV/angstrom", "eV", "K", "eV/angstrom^3", 8.617333262e-5},
}};

std::string product(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() ? "" : a + " " + b;
}

std::string quotient(const std::string& a, const std::string& b, const char* power) {
  if (a.empty() || b.empty()) return "";
  return a + "/" + (b.find(' ') == std::string::npos ? b : "(" + b + ")") + power;
}

std::string square(const std::string& a) {
  return a.empty() ? "" : (a.find(' ') == std::string::npos ? a : "(" + a + ")") + "^2";
}

}  // namespace

std::string Units::letters(Dimension dimension) const {
  switch (dimension) {
    case Dimension::None:
      return "";
    case Dimension::Length:
      return length;
    case Dimension::Angle:
      return name == "none" ? "" : "rad";
    case Dimension::Time:
      return time;
    case Dimension::Mass:
      if (!mass.empty()) return mass;
      return force.empty() ? quotient(product(energy, square(time)), length, "^2")
                           : quotient(product(force, square(time)), length, "");
    case Dimension::Velocity:
      return quotient(length, time, "");
    case Dimension::Acceleration:
      return quotient(length, time, "^2");
    case Dimension::Forces:
      if (!force.empty()) return force;
      return energy.empty() ? quotient(product(mass, length), time, "^2") : quotient(energy, length, "");
    case Dimension::Moment:
      // A force that is a product or a quotient, as kg m/s^2, times a length is not readable.
      return force.empty() || force.find_first_of(" /") != std::string::npos ? letters(Dimension::Energy)
                                                                             : product(force, length);
    case Dimension::Energy:
      if (!energy.empty()) return energy;
      return force.empty() ? quotient(product(mass, square(length)), time, "^2") : product(force, length);
    case Dimension::Temperature:
      return temperature;
    case Dimension::Pressure:
      if (!pressure.empty()) return pressure;
      if (force.empty() && energy.empty()) return quotient(mass, product(length, square(time)), "");
      return force.empty() ? quotient(energy, length, "^3") : quotient(force, length, "^2");
  }
  return "";
}

Units units_from_name(std::string_view name) {
  const auto found = std::ranges::find(known, name, &Units::name);
  if (found != known.end()) return *found;
  throw InputError("/units", "the units \"" + std::string(name) + "\" are not known" +
                                 suggest(name, {"none", "si", "lj", "real", "metal"}) +
                                 "; known are none, si, lj, real, metal");
}

}  // namespace tanor
