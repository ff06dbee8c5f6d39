#include "evaluate/pair_potential.hpp"

#include <algorithm>

#include "system/pair_rules.hpp"

namespace tanor::detail {

PairPotential::PairPotential(const PairForces& pairs)
    : law_(pairs.law),
      epsilon_(pairs.epsilon),
      sigma2_(pairs.sigma * pairs.sigma),
      cutoff_(cutoff_of(pairs)),
      cutoff2_(cutoff_ * cutoff_),
      strength_(pairs.strength),
      length_(pairs.length),
      depth_(pairs.depth),
      width_(pairs.width),
      rest_length_(pairs.rest_length) {
  if (law_ == PairLaw::Coulomb) {
    double largest = 0.0;
    for (const double charge : pairs.charges) largest = std::max(largest, std::abs(charge));
    largest_product_ = largest * largest;
  }
  if (std::isinf(cutoff_)) return;
  const double s6 = std::pow(sigma2_ / cutoff2_, 3);
  shift_ = is_lennard_jones() ? 4.0 * epsilon_ * (s6 * s6 - s6) : smooth(cutoff2_, 1.0).energy;
}

PairPotential::Slope PairPotential::slope(double r2, double charges) const {
  if (law_ == PairLaw::Log) return {strength_ / r2, strength_ / r2};
  if (is_lennard_jones()) {
    // u'' = 24 epsilon (26 s^12 - 7 s^6)/r^2
    const double s2 = sigma2_ / r2, s6 = s2 * s2 * s2;
    return {lennard_jones(r2).force_over_r, 24.0 * epsilon_ * s6 * (26.0 * s6 - 7.0) / r2};
  }
  const Radial pair = smooth(r2, charges);
  if (law_ == PairLaw::Coulomb) return {pair.force_over_r, 2.0 * pair.energy / r2};
  const double r = std::sqrt(r2);
  if (law_ == PairLaw::Yukawa) {
    // u'' = u ((1/r + 1/l)^2 + 1/r^2)
    const double decay = 1.0 / r + 1.0 / length_;
    return {pair.force_over_r, pair.energy * (decay * decay + 1.0 / r2)};
  }
  // u'' = 2 D a^2 e (2 e - 1)
  const double e = std::exp(-width_ * (r - rest_length_));
  return {pair.force_over_r, 2.0 * depth_ * width_ * width_ * e * (2.0 * e - 1.0)};
}

double PairPotential::signed_force_at(double r) const {
  if (r >= cutoff_) return 0.0;
  if (law_ == PairLaw::Log) return strength_ / r;
  if (!is_lennard_jones()) return smooth(r * r, largest_product_).force_over_r * r;
  const double s2 = sigma2_ / (r * r), s6 = s2 * s2 * s2;
  return 24.0 * epsilon_ * s6 * (2.0 * s6 - 1.0) / r;
}

bool PairPotential::jumps() const {
  if (std::isinf(cutoff_)) return false;
  constexpr double vanishing = 1e-9;  // beside the force a little nearer
  return force_at(std::nextafter(cutoff_, 0.0)) > vanishing * force_at(0.9 * cutoff_);
}

double PairPotential::largest_force(double nearest, double farthest) const {
  if (nearest >= cutoff_) return 0.0;
  double force = std::max(force_at(nearest), force_at(std::min(farthest, std::nextafter(cutoff_, 0.0))));
  const double most_attraction =
      is_lennard_jones() ? std::pow(26.0 / 7.0, 1.0 / 6.0) * sigma() : rest_length_ + M_LN2 / width_;
  if ((is_lennard_jones() || law_ == PairLaw::Morse) && nearest < most_attraction && most_attraction < farthest)
    force = std::max(force, force_at(most_attraction));
  return force;
}

}  // namespace tanor::detail
