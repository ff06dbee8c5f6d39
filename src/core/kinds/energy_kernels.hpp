#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <tanor/kinds.hpp>

#include "base/pack.hpp"

/// \file The built-in energies by hand: U and its gradient, eight members side by side.
///
/// Each is the law that the kind's Definition states once over a scalar type; tests compare the two. Where a law ends
/// (a FENE bond at its limit, three points in line), the gradient is NaN, and a step that comes there is rejected.
namespace tanor::detail {

/// The sine at which laws end. It is a little below that at which a start is refused, since rounding differs there.
inline constexpr double end_of_law = 0.99 * least_sine;

/// Returns f of each lane.
template <class Function>
[[gnu::always_inline]] inline Pack<> map_lanes(const Function& f, const Pack<>& x) {
  Pack<> result;
#pragma GCC unroll 1
  for (std::size_t lane = 0; lane < num_lanes; ++lane) result[lane] = f(x[lane]);
  return result;
}
[[gnu::always_inline]] inline Pack<> roots_of(const Pack<>& squares) {
  Pack<> roots = squares;
  take_roots(&roots);
  return roots;
}
[[gnu::always_inline]] inline Pack3<> cross(const Pack3<>& a, const Pack3<>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// Returns x in lanes where `holds` is true, else NaN.
template <class Mask>
[[gnu::always_inline]] inline Pack<> defined_where(const Mask& holds, const Pack<>& x) {
  return holds ? x : Pack<>{} + std::numeric_limits<double>::quiet_NaN();
}

/// U, J, and its gradient, N.
template <std::size_t p>
struct EnergyAndGradient {
  Pack<> energy;
  std::array<Pack3<>, p> gradient;
};

/// The kernel of a kind. `prepare` makes a member's numbers as the kernel reads them, and `run<with_energy>(r,
/// numbers)` evaluates eight members.
template <class Group>
struct EnergyKernel;

template <>
struct EnergyKernel<Bonds> {
  static constexpr std::size_t num_points = 2, num_numbers = 3;
  BondLaw law;

  explicit EnergyKernel(const Bonds& bonds) : law(bonds.law) {}
  static std::array<double, num_numbers> prepare(const Bonds&, const std::array<double, 3>& given) { return given; }

  template <bool with_energy>
  [[gnu::always_inline]] EnergyAndGradient<2> run(const Pack3<>* r, const Pack<>* numbers) const {
    const Pack3<> a = r[1] - r[0];
    const Pack<> square = dot(a, a);
    Pack<> energy{}, slope;  // (dU/dr)/r
    if (law == BondLaw::Fene) {
      // U = -k R^2/2 ln(1 - r^2/R^2), dU/dr = k r/(1 - r^2/R^2)
      const Pack<> limit2 = numbers[1] * numbers[1], left = 1.0 - square / limit2;
      slope = defined_where(left > 0.0, numbers[0] / left);
      if constexpr (with_energy)
        energy = -0.5 * numbers[0] * limit2 * map_lanes([](double x) { return std::log(x); }, left);
    } else if (law == BondLaw::Morse) {
      // U = D (1 - e)^2, dU/dr = 2 D a e (1 - e), e = exp(-a (r - r0))
      const Pack<> length = roots_of(square);
      const Pack<> e = map_lanes([](double x) { return std::exp(x); }, -numbers[1] * (length - numbers[2]));
      const Pack<> part = 1.0 - e;
      slope = 2.0 * numbers[0] * numbers[1] * e * part / length;
      energy = numbers[0] * part * part;
    } else {
      const Pack<> length = roots_of(square), stretch = length - numbers[1];
      slope = numbers[0] * stretch / length;
      energy = 0.5 * numbers[0] * stretch * stretch;
    }
    return {energy, {(-slope) * a, slope * a}};
  }
};

template <>
struct EnergyKernel<Bendings> {
  static constexpr std::size_t num_points = 3, num_numbers = 2;
  BendingLaw law;
  bool is_straight;

  explicit EnergyKernel(const Bendings& bendings)
      : law(bendings.law), is_straight(KindOf<Bendings>::is_straight(bendings)) {}
  static std::array<double, num_numbers> prepare(const Bendings& bendings, const std::array<double, 2>& given) {
    return {given[0], bendings.law == BendingLaw::CosineHarmonic ? std::cos(given[1]) : given[1]};
  }

  /// Uses c = cos theta = a.b/(|a||b|), with dc/da = b/(|a||b|) - c a/|a|^2 and dc/db alike.
  template <bool with_energy>
  [[gnu::always_inline]] EnergyAndGradient<3> run(const Pack3<>* r, const Pack<>* numbers) const {
    const Pack3<> a = r[0] - r[1], b = r[2] - r[1];
    const Pack<> aa = dot(a, a), bb = dot(b, b), inverse = 1.0 / roots_of(aa * bb);
    const Pack<> c = dot(a, b) * inverse;
    Pack<> energy{}, slope;  // dU/dc
    if (law == BendingLaw::Cosine) {
      slope = numbers[0];
      if constexpr (with_energy) energy = 0.5 * numbers[0] * squared_sum(a, b, aa, bb);
    } else if (law == BendingLaw::CosineHarmonic) {
      slope = numbers[0] * (c - numbers[1]);
      energy = 0.5 * slope * (c - numbers[1]);
    } else {
      const Pack3<> normal = cross(a, b);
      const Pack<> sine = roots_of(dot(normal, normal)) * inverse;
      const Pack<> bend = is_straight ? bend_of(sine, c, squared_sum(a, b, aa, bb)) : angle_of(sine, c) - numbers[1];
      energy = 0.5 * numbers[0] * bend * bend;
      // U depends on x = pi - theta with dc = sin x dx, or on theta with dc = -sin theta dtheta.
      slope = is_straight ? defined_where((c < 0.0) | (sine >= end_of_law), numbers[0] * over_sine(bend, sine))
                          : defined_where(sine >= end_of_law, -numbers[0] * bend / sine);
    }
    const Pack<> along = slope * inverse;
    const Pack3<> of_a = along * b - (slope * c / aa) * a, of_b = along * a - (slope * c / bb) * b;
    return {energy, {of_a, Pack3<>{} - of_a - of_b, of_b}};
  }

 private:
  /// Returns |a/|a| + b/|b||^2 = 2 (1 + c), without cancellation where it is small.
  [[gnu::always_inline]] static Pack<> squared_sum(const Pack3<>& a, const Pack3<>& b, const Pack<>& aa,
                                                   const Pack<>& bb) {
    const Pack3<> sum = (1.0 / roots_of(aa)) * a + (1.0 / roots_of(bb)) * b;
    return dot(sum, sum);
  }
  [[gnu::always_inline]] static Pack<> angle_of(const Pack<>& sine, const Pack<>& cosine) {
    Pack<> angle;
#pragma GCC unroll 1
    for (std::size_t lane = 0; lane < num_lanes; ++lane) angle[lane] = std::atan2(sine[lane], cosine[lane]);
    return angle;
  }
  /// Returns x = pi - theta, by 4 sin^2(x/2) where it is small.
  [[gnu::always_inline]] static Pack<> bend_of(const Pack<>& sine, const Pack<>& cosine, const Pack<>& squared_sum) {
    Pack<> x;
#pragma GCC unroll 1
    for (std::size_t lane = 0; lane < num_lanes; ++lane)
      x[lane] = cosine[lane] < -0.5 ? 2.0 * std::asin(0.5 * std::sqrt(squared_sum[lane]))
                                    : std::atan2(sine[lane], -cosine[lane]);
    return x;
  }
  /// Returns x/sin x, near 0 by its series.
  [[gnu::always_inline]] static Pack<> over_sine(const Pack<>& x, const Pack<>& sine) {
    const Pack<> x2 = x * x;
    const Pack<> series = 1.0 + x2 * (1.0 / 6.0 + x2 * (7.0 / 360.0 + x2 * (31.0 / 15120.0)));
    return x2 < 1e-4 ? series : x / sine;
  }
};

/// The formulas are those of Blondel & Karplus, J. Comput. Chem. 17 (1996) 1132, without sin phi in a denominator.
template <>
struct EnergyKernel<Torsions> {
  static constexpr std::size_t num_points = 4, num_numbers = 3;
  TorsionLaw law;
  std::vector<double> coefficients;
  int multiplicity;

  explicit EnergyKernel(const Torsions& torsions)
      : law(torsions.law), coefficients(torsions.coefficients), multiplicity(torsions.multiplicity) {}
  /// Returns k, and the cosine and sine of the angle that phi is turned by.
  static std::array<double, num_numbers> prepare(const Torsions&, const std::array<double, 2>& given) {
    return {given[0], std::cos(given[1]), std::sin(given[1])};
  }

  template <bool with_energy>
  [[gnu::always_inline]] EnergyAndGradient<4> run(const Pack3<>* r, const Pack<>* numbers) const {
    const Pack3<> b1 = r[1] - r[0], b2 = r[2] - r[1], b3 = r[3] - r[2];
    const Pack3<> a = cross(b1, b2), b = cross(b2, b3);
    const Pack<> aa = dot(a, a), bb = dot(b, b), middle2 = dot(b2, b2), middle = roots_of(middle2);
    const Pack<> inverse = 1.0 / roots_of(aa * bb);
    // The sine uses |b2| b1.(b2 x b3) = (A x B).b2/|b2|, which keeps more digits if three points are nearly in line.
    const Pack<> c = dot(a, b) * inverse, s = dot(cross(a, b), b2) / middle * inverse;
    Pack<> energy, slope;  // dU/dphi
    measure(c, s, numbers, &energy, &slope);
    constexpr double least2 = end_of_law * end_of_law;
    slope = defined_where((aa >= least2 * dot(b1, b1) * middle2) & (bb >= least2 * dot(b3, b3) * middle2), slope);
    // dphi/dr_1 = -|b2|/A^2 A, dphi/dr_4 = |b2|/B^2 B,
    // dphi/dr_2 = -dphi/dr_1 + u, dphi/dr_3 = -dphi/dr_4 - u, u = b1.b2/(|b2| A^2) A + b3.b2/(|b2| B^2) B
    const Pack<> by_a = slope / aa, by_b = slope / bb;
    const Pack3<> first = (-(by_a * middle)) * a, last = (by_b * middle) * b;
    const Pack3<> u = (dot(b1, b2) / middle * by_a) * a + (dot(b3, b2) / middle * by_b) * b;
    return {energy, {first, u - first, Pack3<>{} - u - last, last}};
  }

 private:
  /// Evaluates U and dU/dphi of the angle with this cosine and sine.
  [[gnu::always_inline]] void measure(const Pack<>& c, const Pack<>& s, const Pack<>* numbers, Pack<>* energy,
                                      Pack<>* slope) const {
    if (law == TorsionLaw::Opls) {
      const double k1 = coefficients[0], k2 = coefficients[1], k3 = coefficients[2], k4 = coefficients[3];
      const Pack<> c2 = c * c;
      *energy =
          0.5 * k1 * (1.0 + c) + k2 * (1.0 - c2) + 0.5 * k3 * (1.0 + c * (4.0 * c2 - 3.0)) + 4.0 * k4 * c2 * (1.0 - c2);
      *slope = -s * (0.5 * k1 - 2.0 * k2 * c + 0.5 * k3 * (12.0 * c2 - 3.0) + k4 * c * (8.0 - 16.0 * c2));
    } else if (law == TorsionLaw::Multi) {
      Pack<> sum{}, derivative{};  // in x = cos psi = -c
      for (std::size_t n = coefficients.size(); n-- > 0;) {
        derivative = sum - c * derivative;
        sum = coefficients[n] - c * sum;
      }
      *energy = sum;
      *slope = s * derivative;
    } else if (law == TorsionLaw::Harmonic) {
      const Pack<> sine = s * numbers[1] - c * numbers[2], cosine = c * numbers[1] + s * numbers[2];
      Pack<> angle;
#pragma GCC unroll 1
      for (std::size_t lane = 0; lane < num_lanes; ++lane) angle[lane] = std::atan2(sine[lane], cosine[lane]);
      *slope = numbers[0] * angle;
      *energy = 0.5 * *slope * angle;
    } else {
      Pack<> real = Pack<>{} + 1.0, imaginary{};  // (c + i s)^n
      for (int n = 0; n < multiplicity; ++n) {
        const Pack<> next = real * c - imaginary * s;
        imaginary = real * s + imaginary * c;
        real = next;
      }
      *energy = numbers[0] * (1.0 + real * numbers[1] + imaginary * numbers[2]);
      *slope = -static_cast<double>(multiplicity) * numbers[0] * (imaginary * numbers[1] - real * numbers[2]);
    }
  }
};

}  // namespace tanor::detail
