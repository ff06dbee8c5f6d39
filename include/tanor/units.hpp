#pragma once

#include <array>
#include <string>
#include <string_view>

#include <tanor/export.hpp>

namespace tanor {

/// The physical dimension of a number.
enum class Dimension {
  None,
  Length,
  Angle,
  Time,
  Mass,
  Velocity,
  Acceleration,
  Forces,
  Moment,
  Energy,
  Temperature,
  Pressure
};

/// The letters of the units in which a system is given. They stand beside results and change no number, apart from
/// temperatures, which need the constant of Boltzmann. Units are consistent: F = m a holds in them.
struct Units {
  std::string name = "none";
  std::string length{}, mass{}, time{}, force{}, energy{}, temperature{}, pressure{};
  double boltzmann = 1.0;  ///< energy over temperature

  /// Returns the letters of what a number measures; empty if they are not known.
  TANOR_API std::string letters(Dimension dimension) const;
  friend bool operator==(const Units&, const Units&) = default;
};

/// Returns the units "none" (without letters), "si", "lj", "real" or "metal". Throws InputError for another name.
TANOR_API Units units_from_name(std::string_view name);

}  // namespace tanor
