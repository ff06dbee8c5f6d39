#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace tanor::report {

/// The colours of pictures of a motion, of those that `tanor picture` draws and of those in report.html.

/// sRGB, 0 … 1.
struct Rgb {
  float r = 0.0f, g = 0.0f, b = 0.0f;

  friend Rgb operator*(float s, Rgb a) { return {s * a.r, s * a.g, s * a.b}; }
  friend Rgb operator+(Rgb x, Rgb y) { return {x.r + y.r, x.g + y.g, x.b + y.b}; }
};

inline Rgb mix(Rgb a, Rgb b, float part) {
  return (1.0f - part) * a + part * b;
}

inline constexpr Rgb ground{1.0f, 1.0f, 1.0f}, ink{0.13f, 0.15f, 0.18f}, bead_colour{0.47f, 0.52f, 0.59f},
    support_colour{0.10f, 0.12f, 0.15f}, normal_colour{0.04f, 0.48f, 0.36f}, tangent_colour{0.69f, 0.22f, 0.55f},
    guide_colour{0.24f, 0.42f, 0.62f}, unknown_colour{0.55f, 0.55f, 0.55f}, earth_colour{0.68f, 0.62f, 0.53f};

/// Colours of tensions from 0 to the largest one, darker towards it: pulled rods through orange to brown, pushed ones
/// through blue to navy. They are distinguishable with every kind of colour-blindness, and in grey their size still is.
inline constexpr std::array<Rgb, 4> pulled{
    {{0.78f, 0.78f, 0.77f}, {0.96f, 0.66f, 0.30f}, {0.83f, 0.33f, 0.05f}, {0.44f, 0.11f, 0.03f}}};
inline constexpr std::array<Rgb, 4> pushed{
    {{0.78f, 0.78f, 0.77f}, {0.48f, 0.70f, 0.90f}, {0.12f, 0.40f, 0.75f}, {0.04f, 0.13f, 0.38f}}};

/// Returns the colour of a tension, N; the colours end at `scale`. What is not known has a grey of its own.
inline Rgb colour_of(double tension, double scale) {
  if (!std::isfinite(tension)) return unknown_colour;
  const std::span<const Rgb> stops = tension < 0.0 ? pushed : pulled;
  const auto last = static_cast<double>(stops.size() - 1);
  const double place = scale > 0.0 ? last * std::min(1.0, std::abs(tension) / scale) : 0.0;
  const auto k = static_cast<std::size_t>(std::min(place, last - 1.0));
  return mix(stops[k], stops[k + 1], static_cast<float>(place - static_cast<double>(k)));
}

}  // namespace tanor::report
