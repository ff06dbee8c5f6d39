#include "evaluate/pair_potential.hpp"

#include <algorithm>

#include "system/pair_rules.hpp"

namespace tanor {

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

double PairPotential::signed_force_at(double r) const {
  if (r >= cutoff_) return 0.0;
  if (law_ == PairLaw::Log) return strength_ / r;
  if (!is_lennard_jones()) return smooth(r * r, largest_product_).force_over_r * r;
  const double s2 = sigma2_ / (r * r), s6 = s2 * s2 * s2;
  return 24.0 * epsilon_ * s6 * (2.0 * s6 - 1.0) / r;
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

}  // namespace tanor
