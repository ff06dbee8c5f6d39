#pragma once

#include <cmath>

#include <tanor/system.hpp>

namespace tanor::detail {

/// The law of one group of pair forces for two points at a distance r: the energy u(r) and the force -du/dr.
class PairPotential {
 public:
  explicit PairPotential(const PairForces& pairs);

  PairLaw law() const { return law_; }
  bool is_lennard_jones() const { return law_ == PairLaw::Wca || law_ == PairLaw::Lj; }
  double cutoff() const { return cutoff_; }
  double cutoff2() const { return cutoff2_; }
  double sigma() const { return std::sqrt(sigma2_); }
  double strength() const { return strength_; }
  /// Returns u at the cutoff, J, which energies of pairs leave out.
  double shift() const { return shift_; }
  /// Returns true if the force does not vanish at the cutoff.
  bool jumps() const;

  struct Radial {
    double energy;        // J, without the shift
    double force_over_r;  // N/m, positive where points push each other away
  };
  /// Evaluates u = 4 epsilon (s^12 - s^6) and f = 24 epsilon (2 s^12 - s^6)/r with s = sigma/r.
  Radial lennard_jones(double r2) const {
    const double inverse2 = 1.0 / r2, s2 = sigma2_ * inverse2, s6 = s2 * s2 * s2;
    return {4.0 * epsilon_ * s6 * (s6 - 1.0), 24.0 * epsilon_ * s6 * (2.0 * s6 - 1.0) * inverse2};
  }
  /// Evaluates the smooth laws. Coulomb: u = C q q'/r, f = u/r. Yukawa: u = A exp(-r/l)/r, f = u (1/r + 1/l). Morse:
  /// u = D (1 - e)^2, f = -2 D a e (1 - e), e = exp(-a (r - r0)).
  Radial smooth(double r2, double charges) const {
    const double r = std::sqrt(r2);
    if (law_ == PairLaw::Coulomb) {
      const double energy = strength_ * charges / r;
      return {energy, energy / r2};
    }
    if (law_ == PairLaw::Yukawa) {
      const double energy = strength_ * std::exp(-r / length_) / r;
      return {energy, energy * (1.0 / r + 1.0 / length_) / r};
    }
    const double e = std::exp(-width_ * (r - rest_length_)), part = 1.0 - e;
    return {depth_ * part * part, -2.0 * depth_ * width_ * e * part / r};
  }

  /// The derivatives of u that make up a pair's stiffness, see PairField::for_each_stiffness.
  struct Slope {
    double force_over_r, second;  // N/m: -u'/r and u''
  };
  Slope slope(double r2, double charges) const;

  /// Returns the force, N, which is positive if the points push each other away. For charges it is that between the
  /// largest ones.
  double signed_force_at(double r) const;
  double force_at(double r) const { return std::abs(signed_force_at(r)); }
  /// Returns the largest force at distances from the nearest to the farthest, N.
  double largest_force(double nearest, double farthest) const;

 private:
  PairLaw law_;
  double epsilon_, sigma2_, cutoff_, cutoff2_;   // J, m^2, m (infinite without one), m^2
  double strength_;                              // N m
  double length_, depth_, width_, rest_length_;  // m, J, 1/m, m
  double largest_product_ = 1.0;                 // largest product of two charges
  double shift_ = 0.0;                           // J
};

}  // namespace tanor::detail
