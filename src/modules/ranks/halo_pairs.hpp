#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/decisions.hpp"
#include "dynamics/model.hpp"
#include "evaluate/pair_field.hpp"
#include "evaluate/pair_potential.hpp"
#include "evaluate/pairs_beyond.hpp"
#include "ranks/halo.hpp"

namespace tanor::detail {

/// Pair forces of one group, with a cutoff, between own points and those of other ranks.
class HaloPairs final : public PairsBeyond {
 public:
  HaloPairs(const Model& model, const Part::SharedPairs& pairs, Ranks& ranks);
  ~HaloPairs() override;

  void add_forces(const double* r, double* f) override;
  double potential(const double* r) override;
  double find_unseen(const PointPath& path, std::span<const double> masses) override;

 private:
  struct PointForce {
    Vec3 force;              // N
    double potential = 0.0;  // J
  };
  class Path;
  struct Surroundings;

  void follow(const double* r);
  void make(std::span<const Vec3> own, double skin);
  PointForce force_on(std::size_t i) const;
  bool is_excluded(std::size_t i, Index number) const;
  std::array<double, 2> measure_reach(const PointPath& path);
  bool are_too_many(std::span<const Vec3> own, double radius);

  const Model& model_;
  Decisions ranks_;
  PairForces law_;
  PairPotential potential_;
  PeriodicBox box_;
  double default_skin_;
  std::vector<Index> own_;                      // inner
  std::vector<std::array<Index, 2>> excluded_;  // own point, number of another rank's; ascending
  Halo halo_;
  bool is_made_ = false, is_known_ = false;
  std::vector<Vec3> places_, halo_places_;  // places of the last evaluation
  std::vector<PointForce> point_forces_;    // [own point]
  std::unique_ptr<Surroundings>
      surroundings_;  // for unseen pairs; null if none were looked for since the lists were made
};

}  // namespace tanor::detail
