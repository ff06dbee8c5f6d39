#pragma once

#include <memory>
#include <span>
#include <vector>

#include "solve/bundle_kernels.hpp"
#include "solve/island_schedule.hpp"
#include "solve/sweep.hpp"

namespace tanor {

/// Islands of rods, many of equal topology: one elimination, written down once, runs over eight islands side by side
/// in the lanes of a vector. Which islands share a vector follows from the system alone.
class BundleSweep final : public Sweep {
 public:
  /// Null where some constraint is no rod, or where `eagerly` is false and islands are too unlike or too large.
  static std::unique_ptr<BundleSweep> make(const Constraints& constraints, const Numbering& numbering,
                                           std::span<const double> inverse_mass, int threads, bool eagerly);

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* scratch, double* lambda,
                    double* w) override;
  Elimination factorize(const Parallel& parallel, const double* blocks) override;
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  const Summary& summary() const override { return summary_; }

 private:
  /// Islands of one topology in batches of eight. Lanes that are left over repeat the last island.
  struct Bundle {
    explicit Bundle(const IslandTopology& of) : topology(of), schedule(of) {}

    IslandTopology topology;
    IslandSchedule schedule;
    std::size_t num_batches = 0;
    std::vector<Index> points;                 // [batch][point, then support][lane]
    std::vector<Index> rows, blocks;           // [batch][rod][lane]; ~block where the rod is given the other way
    Eights inverse_mass;                       // [batch][point, then support]
    std::vector<Eight3> offsets;               // [batch][rod]; empty: none
    std::vector<const MovingScalar*> lengths;  // [batch][rod][lane], null: constant; empty: all are
    Eights factor;                             // [batch][slot]

    std::size_t num_places() const { return static_cast<std::size_t>(topology.num_points + topology.num_supports); }
    std::size_t num_rods() const { return topology.rods.size(); }
    Eight* factor_of(std::size_t batch) { return factor.data() + batch * static_cast<std::size_t>(schedule.num_slots); }
  };
  struct Rod {
    std::array<Index, 2> points;  // inner
    Index block;
    Vec3 offset{};
    const MovingScalar* length = nullptr;
  };
  struct Island {
    Index first_point = 0;
    std::vector<Index> rows, supports;  // by the topology's rods and places
    std::vector<char> is_reversed;
  };
  /// What one thread works on, and what it found.
  struct Desk {
    std::vector<Eight3> r, v, w, dw, u;
    Eights b, x, second_derivatives;
    Eight smallest;
    Largest right_side, residual;
  };

  BundleSweep() = default;
  static std::vector<Rod> read_rods(const Constraints& constraints, std::size_t num_rows);
  static bool read_island(std::span<const Rod> rods, Index first_row, Index end_row, Index num_moving,
                          IslandTopology* topology, Island* island);
  void add_bundle(const IslandTopology& topology, std::span<const Island> islands, std::span<const Rod> rods,
                  std::span<const double> inverse_mass);
  template <class Work>
  void for_each_batch(const Parallel& parallel, const Work& work);
  Elimination found() const;
  const Eight* second_derivatives(const Bundle& bundle, std::size_t batch, Desk* desk) const;

  std::vector<Bundle> bundles_;
  std::vector<Desk> desks_;  // [thread]
  Summary summary_;
};

}  // namespace tanor
