#include "ranks/halo_pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tanor::detail {

namespace {

/// Returns a skin with which lists last for some ten steps of a melt. Making them sends all places to all ranks.
double skin_of(const PairPotential& potential) {
  constexpr double part_of_sigma = 0.5, part_of_cutoff = 0.3;
  return potential.is_lennard_jones() ? part_of_sigma * potential.sigma() : part_of_cutoff * potential.cutoff();
}

}  // namespace

HaloPairs::HaloPairs(const Model& model, const Part::SharedPairs& pairs, Ranks& ranks)
    : model_(model),
      ranks_(&ranks),
      law_(pairs.law),
      potential_(pairs.law),
      box_(pairs.law.box),
      default_skin_(skin_of(potential_)),
      excluded_(pairs.excluded),
      halo_(ranks, box_, potential_.cutoff(), pairs.numbers),
      places_(pairs.law.points.size()),
      point_forces_(places_.size()) {
  for (const Index point : pairs.law.points)
    own_.push_back(model.numbering.inner_point[static_cast<std::size_t>(point)]);
  std::ranges::sort(excluded_);
}

HaloPairs::~HaloPairs() = default;

bool HaloPairs::is_excluded(std::size_t i, Index number) const {
  return std::ranges::binary_search(excluded_, std::array{static_cast<Index>(i), number});
}

void HaloPairs::make(std::span<const Vec3> own, double skin) {
  halo_.make(own, skin);
  surroundings_.reset();
  is_made_ = true;
  is_known_ = false;
}

HaloPairs::PointForce HaloPairs::force_on(std::size_t i) const {
  PointForce sum{};
  for (const Index k : halo_.near(i)) {
    const Vec3 d = box_.nearest_image(places_[i] - halo_places_[static_cast<std::size_t>(k)]);
    const double r2 = dot(d, d);
    if (r2 >= potential_.cutoff2() || is_excluded(i, halo_.numbers()[static_cast<std::size_t>(k)])) continue;
    const PairPotential::Radial pair =
        potential_.is_lennard_jones() ? potential_.lennard_jones(r2) : potential_.smooth(r2, 1.0);
    sum.force = sum.force + pair.force_over_r * d;
    sum.potential += 0.5 * (pair.energy - potential_.shift());
  }
  return sum;
}

/// Computes forces and energies at r, unless they are known.
void HaloPairs::follow(const double* r) {
  std::array<double, 2> all{0.0, 0.0};  // the largest move, and 1 if some place has changed
  for (std::size_t i = 0; i < own_.size(); ++i) {
    const Vec3 place = load(r, own_[i]), before = places_[i];
    if (!(place.x == before.x && place.y == before.y && place.z == before.z)) all[1] = 1.0;
    places_[i] = place;
  }
  if (is_made_)
    all[0] = halo_.largest_move(places_);
  else
    for (const Vec3& place : places_) all[0] = larger(all[0], dot(place, place));
  ranks_.take_largest(all);
  if (is_known_ && all[1] == 0.0) return;
  is_known_ = std::isfinite(all[0]);
  if (!is_known_) {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    std::ranges::fill(point_forces_, PointForce{{unknown, unknown, unknown}, unknown});
    return;
  }
  if (!is_made_ || all[0] > 0.4999 * halo_.skin()) make(places_, default_skin_);
  halo_.fetch(places_, &halo_places_);
  model_.parallel.for_ranges(own_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) point_forces_[i] = force_on(i);
  });
  is_known_ = true;
}

void HaloPairs::add_forces(const double* r, double* f) {
  follow(r);
  for (std::size_t i = 0; i < own_.size(); ++i) add_to(f, own_[i], point_forces_[i].force);
}

double HaloPairs::potential(const double* r) {
  follow(r);
  double sum = 0.0;
  for (const PointForce& each : point_forces_) sum += each.potential;
  return sum;
}

// ---- unseen pairs ----

/// A system of the own points that the halo is near to and, as supports, of the halo's points.
struct HaloPairs::Surroundings {
  std::vector<std::size_t> own;  // the system's first points, by their number among all own ones
  System system;
  Numbering numbering;
  std::vector<double> masses;  // masses of all points, since the halo's points are pushed as well
  std::unique_ptr<PairField> field;

  explicit Surroundings(const HaloPairs& of) {
    Rods rods{"rods", {}, {}, {}};  // pairs without a force
    for (std::size_t i = 0; i < of.own_.size(); ++i)
      if (!of.halo_.near(i).empty()) own.push_back(i);
    const auto first = static_cast<Index>(own.size());
    exclude_own(of, &rods);
    for (std::size_t a = 0; a < own.size(); ++a) {
      add(of.places_[own[a]]);
      for (const Index k : of.halo_.near(own[a]))
        if (of.is_excluded(own[a], of.halo_.numbers()[static_cast<std::size_t>(k)]))
          rods.pairs.push_back({static_cast<Index>(a), first + k});
    }
    Support others{"points of other ranks", {}, {}};
    for (std::size_t k = 0; k < of.halo_.size(); ++k) {
      others.points.push_back(first + static_cast<Index>(k));
      add(of.halo_places_[k]);
    }
    system.supports = {others};
    system.constraints = {rods};
    numbering = number(system);
    PairForces law = of.law_;
    law.points.clear();  // empty for all points
    law.exclude_rods = true;
    field = std::make_unique<PairField>(system, law, numbering);
  }

 private:
  void add(const Vec3& place) {
    system.positions.insert(system.positions.end(), {place.x, place.y, place.z});
    system.masses.push_back(1.0);
  }
  /// Adds a rod between own points that exclude each other.
  void exclude_own(const HaloPairs& of, Rods* rods) const {
    if (!of.law_.exclude_rods) return;
    std::vector<Index> place(of.model_.num_points(), -1);  // [user's point]
    for (std::size_t a = 0; a < own.size(); ++a)
      place[static_cast<std::size_t>(of.law_.points[own[a]])] = static_cast<Index>(a);
    for (const Constraint& constraint : of.model_.system.constraints) {
      const Rods* const group = std::get_if<Rods>(&constraint);
      if (group == nullptr) continue;
      for (const auto& [a, b] : group->pairs) {
        const Index i = place[static_cast<std::size_t>(a)], j = place[static_cast<std::size_t>(b)];
        if (i >= 0 && j >= 0) rods->pairs.push_back({i, j});
      }
    }
  }
};

/// The step of these points, at knots that all ranks have.
class HaloPairs::Path final : public PointPath {
 public:
  /// Fetches the halo's points. Collective.
  Path(const PointPath& of, std::size_t pieces, std::span<const double> masses, HaloPairs* pairs)
      : PointPath(of), pairs_(*pairs) {
    positions.clear();
    velocities.clear();
    variables.clear();
    rates.clear();
    own_atol_r = own_atol_v = accelerations = {};
    for (std::size_t k = 0; k <= pieces; ++k) {
      Knot& knot = knots_.emplace_back();
      for (const Index i : pairs->own_) {
        const Place place = of.at(i, static_cast<double>(k) / static_cast<double>(pieces));
        knot.own_r.push_back(place.r);
        knot.own_v.push_back(place.v);
      }
      pairs->halo_.fetch(knot.own_r, &knot.halo_r);
      pairs->halo_.fetch(knot.own_v, &knot.halo_v);
    }
    for (const Index i : pairs->own_)
      own_numbers_.push_back({masses[static_cast<std::size_t>(i)], of.atol_r(i), of.atol_v(i)});
    pairs->halo_.fetch(own_numbers_, &halo_numbers_);
  }
  void refine(double) override {}

  /// Puts places and masses into the order of the surroundings.
  void arrange(std::vector<double>* masses) {
    for (Knot& knot : knots_) {
      write(knot.own_r, knot.halo_r, &knot.r);
      write(knot.own_v, knot.halo_v, &knot.v);
      positions.push_back(knot.r.data());
      velocities.push_back(knot.v.data());
    }
    std::vector<double> numbers;
    write(own_numbers_, halo_numbers_, &numbers);
    for (std::vector<double>* array : {masses, &atols_r_, &atols_v_}) array->clear();
    for (std::size_t i = 0; i < numbers.size(); i += 3) {
      masses->push_back(numbers[i]);
      atols_r_.push_back(numbers[i + 1]);
      atols_v_.push_back(numbers[i + 2]);
    }
    own_atol_r = atols_r_;
    own_atol_v = atols_v_;
  }

 private:
  struct Knot {
    std::vector<Vec3> own_r, own_v, halo_r, halo_v;
    std::vector<double> r, v;  // own and halo points
  };
  std::size_t inner(std::size_t user) const {
    return static_cast<std::size_t>(pairs_.surroundings_->numbering.inner_point[user]);
  }
  void write(std::span<const Vec3> own, std::span<const Vec3> halo, std::vector<double>* to) const {
    const std::vector<std::size_t>& chosen = pairs_.surroundings_->own;
    to->resize(3 * (chosen.size() + halo.size()));
    for (std::size_t a = 0; a < chosen.size(); ++a) store(to->data(), inner(a), own[chosen[a]]);
    for (std::size_t k = 0; k < halo.size(); ++k) store(to->data(), inner(chosen.size() + k), halo[k]);
  }
  const HaloPairs& pairs_;
  std::vector<Knot> knots_;
  std::vector<Vec3> own_numbers_, halo_numbers_;  // mass, and tolerances of positions and velocities
  std::vector<double> atols_r_, atols_v_;
};

/// Returns the largest distance of own points on their way from where the lists were made, and from where the step
/// begins, m.
std::array<double, 2> HaloPairs::measure_reach(const PointPath& path) {
  const std::size_t pieces = path.num_pieces();
  const double length = path.h / static_cast<double>(pieces);
  std::vector<Vec3> begin, there;
  for (const Index i : own_) begin.push_back(load(path.positions[0], i));
  std::array<double, 2> reach{halo_.largest_move(begin), 0.0};
  for (std::size_t k = 0; k < pieces; ++k) {
    there.clear();
    double bend = 0.0;
    for (std::size_t a = 0; a < own_.size(); ++a) {
      const Index i = own_[a];
      const PointPath::Place from{load(path.positions[k], i), load(path.velocities[k], i)},
          to{load(path.positions[k + 1], i), load(path.velocities[k + 1], i)};
      bend = larger(bend, sagitta(from, to, length));
      reach[1] = larger(reach[1], norm(to.r - begin[a]));
      there.push_back(to.r);
    }
    reach[1] += bend;
    reach[0] = larger(reach[0], halo_.largest_move(there) + bend);
  }
  return reach;
}

/// Does the same as PairField's, for all ranks.
bool HaloPairs::are_too_many(std::span<const Vec3> own, double radius) {
  PointRoom room;
  for (const Vec3& r : own) room.add(r);
  ranks_.take_largest(room.ends());
  return room.is_crowded(halo_.num_all(), radius);
}

double HaloPairs::find_unseen(const PointPath& path, std::span<const double> masses) {
  std::array<double, 3> all{};
  const std::array<double, 2> own = measure_reach(path);
  all = {own[0], own[1], static_cast<double>(path.num_pieces())};
  ranks_.take_largest(all);
  if (!std::isfinite(all[0])) return 1.0;  // the forces report this
  const double needed = 2.2 * all[1];
  if (2.0 * all[0] > halo_.skin()) {
    std::vector<Vec3> begin;
    for (const Index i : own_) begin.push_back(load(path.positions[0], i));
    if (needed > default_skin_ && are_too_many(begin, needed)) return 0.5;
    make(begin, std::max(default_skin_, needed));
    halo_.fetch(begin, &halo_places_);
  }
  Path near(path, static_cast<std::size_t>(all[2]), masses, this);
  if (halo_.size() == 0) return 1.0;
  if (surroundings_ == nullptr) surroundings_ = std::make_unique<Surroundings>(*this);
  near.arrange(&surroundings_->masses);
  return surroundings_->field->find_unseen(model_.parallel, near, surroundings_->masses);
}

}  // namespace tanor::detail
