#include "evaluate/pair_field.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/groups.hpp"
#include "evaluate/pair_stiffness.hpp"
#include "system/pair_rules.hpp"

namespace tanor::detail {

namespace {

/// Returns, for each point, those that form no pair with it, by number.
Groups<Index> make_lists(std::size_t num_points, std::vector<std::array<Index, 2>> pairs) {
  Groups<Index> lists;
  compress_pairs(num_points, std::move(pairs), &lists.start, &lists.entries);
  return lists;
}

void add_both_ways(Index i, Index j, std::vector<std::array<Index, 2>>* pairs) {
  pairs->push_back({i, j});
  pairs->push_back({j, i});
}

/// A sum of many terms to the rounding of a few (Neumaier).
struct CompensatedSum {
  double sum = 0.0, rest = 0.0;

  void add(double term) {
    const double total = sum + term;
    rest += std::abs(sum) >= std::abs(term) ? (sum - total) + term : (term - total) + sum;
    sum = total;
  }
  double value() const { return sum + rest; }
};

}  // namespace

PairField::PairField(const System& system, const PairForces& pairs, const Numbering& numbering, Which which)
    : potential_(pairs),
      box_(pairs.box),
      gives_stiffness_(has_stiffness(system, pairs) && !has_own_derivatives(system, pairs)) {
  const std::vector<Index> number_of = number_points(pairs, numbering, which);
  if (potential_.law() == PairLaw::Coulomb) read_charges(pairs, numbering);
  places_.resize(points_.size());
  point_forces_.resize(points_.size());
  Pairs excluded;
  if (pairs.exclude_rods) exclude_rods(system, numbering, number_of, &excluded);
  if (which == Which::OfSupports) exclude_same_place(system, numbering, number_of, pairs.box, &excluded);
  prepare_search(pairs.sigma, std::move(excluded));
}

/// Finds the points that take part. Returns the number of each inner point, or -1 if it takes no part.
std::vector<Index> PairField::number_points(const PairForces& pairs, const Numbering& numbering, Which which) {
  std::vector<Index> number_of(numbering.num_points(), -1);
  for (const Index point : pairs.points) number_of[numbering.inner_point[point]] = 0;
  const bool of_supports = which == Which::OfSupports;
  for (std::size_t inner = 0; inner < numbering.num_points(); ++inner) {
    const bool takes_part = pairs.points.empty() || number_of[inner] >= 0;
    number_of[inner] = -1;
    if (!takes_part || (of_supports && inner < numbering.num_moving)) continue;
    number_of[inner] = static_cast<Index>(points_.size());
    points_.push_back(static_cast<Index>(inner));
    if (of_supports || inner < numbering.num_moving) ++num_moving_;
  }
  if (of_supports && points_.size() < 2) points_.clear();
  return number_of;
}

void PairField::read_charges(const PairForces& pairs, const Numbering& numbering) {
  std::vector<double> charge_of(numbering.num_points());  // [inner point]
  for (std::size_t k = 0; k < (pairs.points.empty() ? charge_of.size() : pairs.points.size()); ++k) {
    const std::size_t user = pairs.points.empty() ? k : static_cast<std::size_t>(pairs.points[k]);
    charge_of[static_cast<std::size_t>(numbering.inner_point[user])] = pairs.charges[pairs.charges.size() == 1 ? 0 : k];
  }
  for (const Index point : points_) charges_.push_back(charge_of[static_cast<std::size_t>(point)]);
}

void PairField::exclude_rods(const System& system, const Numbering& numbering, const std::vector<Index>& number_of,
                             Pairs* excluded) const {
  for (const Constraint& constraint : system.constraints) {
    const auto* rods = std::get_if<Rods>(&constraint);
    if (!rods) continue;
    for (const auto& [a, b] : rods->pairs) {
      const Index i = number_of[numbering.inner_point[a]], j = number_of[numbering.inner_point[b]];
      if (i >= 0 && j >= 0) add_both_ways(i, j, excluded);
    }
  }
}

/// Excludes points that start at the same place.
void PairField::exclude_same_place(const System& system, const Numbering& numbering,
                                   const std::vector<Index>& number_of, const Vector3& box, Pairs* excluded) const {
  std::vector<Index> points;
  for (const Index point : points_) points.push_back(numbering.user_point[static_cast<std::size_t>(point)]);
  const auto number = [&](Index user) {
    return number_of[static_cast<std::size_t>(numbering.inner_point[static_cast<std::size_t>(user)])];
  };
  for_each_meeting(system, box, points, [&](Index i, Index j) { add_both_ways(number(i), number(j), excluded); });
}

/// Prepares lists of neighbours if there is a cutoff. Otherwise every point interacts with all others but the excluded
/// ones.
void PairField::prepare_search(double sigma, Pairs excluded) {
  const std::size_t n = points_.size();
  if (std::isinf(potential_.cutoff())) {
    for (std::size_t i = 0; i < n; ++i) excluded.push_back({static_cast<Index>(i), static_cast<Index>(i)});
    skipped_ = make_lists(n, std::move(excluded));
    far_.emplace(0.0, 0.0, box_, num_moving_, skipped_);
    for (std::vector<double>* coordinate : {&x_, &y_, &z_}) coordinate->resize(n);
    return;
  }
  constexpr double skin_of_sigma = 0.3;  // lists of a melt last some ten steps and are twice as long as needed
  constexpr double skin_of_cutoff = 0.15;
  const double cutoff = potential_.cutoff();
  const double skin = potential_.is_lennard_jones() ? skin_of_sigma * sigma : skin_of_cutoff * cutoff;
  const Groups<Index> skipped = make_lists(n, std::move(excluded));
  neighbours_.emplace(cutoff, skin, box_, num_moving_, skipped);
  far_.emplace(cutoff, 0.0, box_, num_moving_, skipped);
}

/// Sums over the neighbours within the cutoff. The law is chosen outside the loop.
PairField::PointForce PairField::force_within_cutoff(std::size_t i, std::span<const Index> neighbours) const {
  const Vec3 here = places_[i];
  const double cutoff2 = potential_.cutoff2(), shift = potential_.shift();
  const auto sum_over_neighbours = [&](const auto& measure) {
    PointForce sum{};
    for (const Index j : neighbours) {
      const Vec3 d = box_.nearest_image(here - places_[j]);
      const double r2 = dot(d, d);
      if (r2 >= cutoff2) continue;
      const PairPotential::Radial pair = measure(r2);
      sum.force = sum.force + pair.force_over_r * d;
      sum.potential += 0.5 * (pair.energy - shift);
    }
    return sum;
  };
  if (potential_.is_lennard_jones())
    return sum_over_neighbours([this](double r2) { return potential_.lennard_jones(r2); });
  return sum_over_neighbours([this](double r2) { return potential_.smooth(r2, 1.0); });
}

/// Evaluates u = -strength ln r and the force strength (r_i - r_j)/r^2.
///
/// Blocks of 32 pairs are added up in vector lanes, and the blocks with compensation, so a sum over thousands is good
/// to a few roundings of its terms. One logarithm serves a block: with r^2 = m 2^e, the m are multiplied and the e
/// added.
PairField::PointForce PairField::logarithmic_force(std::size_t i) const {
  constexpr std::size_t block = 32;
  constexpr std::uint64_t mantissa_bits = (std::uint64_t{1} << 52) - 1, exponent_of_one = std::uint64_t{1023} << 52;
  const double hx = x_[i], hy = y_[i], hz = z_[i];
  CompensatedSum fx, fy, fz;
  double logs = 0.0;
  for_each_range_of_others(i, [&](std::size_t first, std::size_t last) {
    for (std::size_t begin = first; begin < last; begin += block) {
      const std::size_t end = std::min(begin + block, last);
      double sx = 0.0, sy = 0.0, sz = 0.0, product = 1.0;
      std::uint64_t exponents = 0;
#pragma omp simd reduction(+ : sx, sy, sz, exponents) reduction(* : product)
      for (std::size_t j = begin; j < end; ++j) {
        const double dx = hx - x_[j], dy = hy - y_[j], dz = hz - z_[j];
        const double r2 = dx * dx + dy * dy + dz * dz, inverse2 = 1.0 / r2;
        sx += dx * inverse2;
        sy += dy * inverse2;
        sz += dz * inverse2;
        const auto bits = std::bit_cast<std::uint64_t>(r2);
        exponents += bits >> 52;
        product *= std::bit_cast<double>((bits & mantissa_bits) | exponent_of_one);
      }
      fx.add(sx);
      fy.add(sy);
      fz.add(sz);
      logs += std::log(product) + M_LN2 * (static_cast<double>(exponents) - 1023.0 * static_cast<double>(end - begin));
    }
  });
  const double strength = potential_.strength();
  return {strength * Vec3{fx.value(), fy.value(), fz.value()}, -0.25 * strength * logs};
}

/// Visits all others, between those that are skipped. The others of a support are those that move.
template <class Visit>
void PairField::for_each_range_of_others(std::size_t i, const Visit& visit) const {
  const std::size_t count = i < num_moving_ ? points_.size() : num_moving_;
  std::size_t begin = 0;
  for (const Index skipped : skipped_[i]) {
    visit(begin, std::min(static_cast<std::size_t>(skipped), count));
    begin = static_cast<std::size_t>(skipped) + 1;
  }
  visit(begin, count);
}

/// Visits the pairs (i, j), i < j, that interact, or that may if there are lists of neighbours.
template <class Visit>
void PairField::for_each_pair(const Visit& visit) const {
  if (neighbours_) {
    neighbours_->for_each_point(Parallel(1), [&](std::size_t i, std::span<const Index> neighbours) {
      for (const Index j : neighbours) {
        if (static_cast<std::size_t>(j) > i) visit(i, static_cast<std::size_t>(j));
      }
    });
    return;
  }
  for (std::size_t i = 0; i < num_moving_; ++i) {
    for_each_range_of_others(i, [&](std::size_t first, std::size_t last) {
      for (std::size_t j = std::max(first, i + 1); j < last; ++j) visit(i, j);
    });
  }
}

PairField::PointForce PairField::force_without_cutoff(std::size_t i) const {
  if (potential_.law() == PairLaw::Log) return logarithmic_force(i);
  CompensatedSum fx, fy, fz, potential;
  const double charge = charges_.empty() ? 1.0 : charges_[i];
  for_each_range_of_others(i, [&](std::size_t first, std::size_t last) {
    for (std::size_t j = first; j < last; ++j) {
      const Vec3 d{x_[i] - x_[j], y_[i] - y_[j], z_[i] - z_[j]};
      const PairPotential::Radial pair = potential_.smooth(dot(d, d), charges_.empty() ? 1.0 : charge * charges_[j]);
      fx.add(pair.force_over_r * d.x);
      fy.add(pair.force_over_r * d.y);
      fz.add(pair.force_over_r * d.z);
      potential.add(0.5 * pair.energy);
    }
  });
  return {{fx.value(), fy.value(), fz.value()}, potential.value()};
}

/// Evaluates forces and energies at r, unless they are known.
void PairField::follow(const Parallel& parallel, const double* r) {
  const double changes = parallel.max_over_ranges(points_.size(), [&](std::size_t begin, std::size_t end) {
    bool found = false;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 place = load(r, points_[i]), before = places_[i];
      found = found || !(place.x == before.x && place.y == before.y && place.z == before.z);
      places_[i] = place;
    }
    return found ? 1.0 : 0.0;
  });
  if (is_known_ && changes == 0.0) return;
  is_known_ = true;
  if (!neighbours_) {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      x_[i] = places_[i].x;
      y_[i] = places_[i].y;
      z_[i] = places_[i].z;
    }
    parallel.for_ranges(
        places_.size(),
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) point_forces_[i] = force_without_cutoff(i);
        },
        std::max<std::size_t>(16, 16384 / (places_.size() + 1)));
  } else if (neighbours_->follow(parallel, places_)) {
    neighbours_->for_each_point(parallel, [&](std::size_t i, std::span<const Index> neighbours) {
      point_forces_[i] = force_within_cutoff(i, neighbours);
    });
  } else {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    std::fill(point_forces_.begin(), point_forces_.end(), PointForce{{unknown, unknown, unknown}, unknown});
  }
}

void PairField::add_forces(const Parallel& parallel, const double* r, double* f) {
  follow(parallel, r);
  parallel.for_ranges(points_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) add_to(f, points_[i], point_forces_[i].force);
  });
}

double PairField::potential(const Parallel& parallel, const double* r) {
  follow(parallel, r);
  return parallel.sum(points_.size(), [&](std::size_t i) { return point_forces_[i].potential; });
}

void PairField::for_each_stiffness(const Parallel& parallel, const double* r, const VisitStiffness& visit) {
  follow(parallel, r);
  const auto visit_pair = [&](std::size_t i, std::size_t j) {
    const Vec3 d = box_.nearest_image(places_[j] - places_[i]);
    const double r2 = dot(d, d);
    if (r2 >= potential_.cutoff2()) return;
    const PairPotential::Slope slope = potential_.slope(r2, charges_.empty() ? 1.0 : charges_[i] * charges_[j]);
    Block3 derivative;
    derivative.add_identity(slope.force_over_r);
    derivative.add_product(-(slope.force_over_r + slope.second) / r2, d, d);
    visit(points_[i], points_[j], derivative);
  };
  for_each_pair(visit_pair);
}

void PairField::for_each_image(const Parallel& parallel, const double* r, const VisitImage& visit) {
  if (box_.edges().x == 0.0 && box_.edges().y == 0.0 && box_.edges().z == 0.0) return;
  follow(parallel, r);
  for_each_pair([&](std::size_t i, std::size_t j) {
    const Vec3 apart = places_[j] - places_[i], d = box_.nearest_image(apart), shift = d - apart;
    const double r2 = dot(d, d);
    if (r2 >= potential_.cutoff2() || (shift.x == 0.0 && shift.y == 0.0 && shift.z == 0.0)) return;
    visit(shift, potential_.slope(r2, charges_.empty() ? 1.0 : charges_[i] * charges_[j]).force_over_r * d);
  });
}

/// Energies like 1/r and ln r have no bound where two points meet.
std::optional<PairField::Collision> PairField::find_collision(const double* r, const double* v, double within) const {
  std::optional<Collision> nearest;
  const PairLaw law = potential_.law();
  if (law != PairLaw::Coulomb && law != PairLaw::Yukawa && law != PairLaw::Log) return nearest;
  for_each_pair([&](std::size_t i, std::size_t j) {
    const double charges = charges_.empty() ? 1.0 : charges_[i] * charges_[j];
    if (potential_.strength() * charges >= 0.0) return;
    const Vec3 apart = box_.nearest_image(load(r, points_[j]) - load(r, points_[i]));
    const double distance = norm(apart), approach = -dot(apart, load(v, points_[j]) - load(v, points_[i]));
    // The time until they meet is r/|r'|, by r r' = apart.v.
    if (!(distance * distance < within * approach) || (nearest && nearest->distance <= distance)) return;
    nearest = {points_[i], points_[j], distance};
  });
  return nearest;
}

double PairField::power_of_supports(const Parallel& parallel, const double* r, const double* v) {
  follow(parallel, r);
  // The support does the work -(force on it).velocity on the potential energy.
  return parallel.sum(points_.size() - num_moving_, [&](std::size_t k) {
    const std::size_t i = num_moving_ + k;
    return -dot(point_forces_[i].force, load(v, points_[i]));
  });
}

}  // namespace tanor::detail
