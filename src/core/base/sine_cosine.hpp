#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace tanor::detail {

/// Beyond this angle the reduction in `sine_cosine` loses digits.
inline constexpr double largest_angle = 1e6;

/// Computes sin x and cos x to about 1 ulp for |x| <= largest_angle. There are no branches, so loops over it run in
/// vector lanes. The remainder of x modulo pi/2 is found as in W. J. Cody and W. Waite (1980), and the polynomials are
/// those of fdlibm (Sun Microsystems 1993).
[[gnu::always_inline]] inline void sine_cosine(double x, double* sine, double* cosine) {
  // n = round(2x/pi); its last bits are the last ones of 2x/pi + 1.5 * 2^52.
  constexpr double shift = 6755399441055744.0, two_over_pi = 6.36619772367581382433e-01;
  const double shifted = x * two_over_pi + shift;
  const auto quadrant = std::bit_cast<std::uint64_t>(shifted);
  const double n = shifted - shift;
  // pi/2 is split into parts of 33 bits, so that n times a part is exact.
  constexpr double part1 = 1.57079632673412561417e+00, part2 = 6.07710050630396597660e-11,
                   part3 = 2.02226624879595063154e-21;
  // x - n pi/2 = r + tail
  const double y = x - n * part1, product = n * part2, near = y - product;
  const double rest = n * part3 - ((y - near) - product);
  const double r = near - rest, tail = (near - r) - rest;
  const double z = r * r, half = 0.5 * z, head = 1.0 - half;
  const double s_terms =
      -1.66666666666666324348e-01 +
      z * (8.33333333332248946124e-03 +
           z * (-1.98412698298579493134e-04 +
                z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10))));
  const double c_terms =
      4.16666666666666019037e-02 +
      z * (-1.38888888888741095749e-03 +
           z * (2.48015872894767294178e-05 + z * (-2.75573143513906633035e-07 +
                                                  z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))));
  const double s = r + (r * z * s_terms + tail * head);
  const double c = head + (((1.0 - head) - half) + (z * z * c_terms - r * tail));
  // A quarter turn exchanges sine and cosine, half a turn changes their signs.
  const std::uint64_t sign_of_sine = (quadrant & 2) << 62, sign_of_cosine = ((quadrant + 1) & 2) << 62;
  const bool swaps = (quadrant & 1) != 0;
  *sine = std::bit_cast<double>(std::bit_cast<std::uint64_t>(swaps ? c : s) ^ sign_of_sine);
  *cosine = std::bit_cast<double>(std::bit_cast<std::uint64_t>(swaps ? s : c) ^ sign_of_cosine);
}

}  // namespace tanor::detail
