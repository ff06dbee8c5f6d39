#include "schur/tree_series.hpp"

#include <algorithm>
#include <array>

#include "base/instruction_sets.hpp"
#include "schur/tree_lanes.hpp"

namespace tanor::detail {

// ---- the plan ----

std::unique_ptr<TreeSeries> TreeSeries::make(const RodRows& rods, const Numbering& numbering,
                                             std::span<const double> inverse_mass, int threads,
                                             std::vector<Index>* islands) {
  const TreesInLanes chosen(rods, numbering, false, islands);
  if (chosen.trees.empty()) return nullptr;
  return std::unique_ptr<TreeSeries>(new TreeSeries(chosen, rods, numbering, inverse_mass, threads));
}

TreeSeries::TreeSeries(const TreesInLanes& chosen, const RodRows& rods, const Numbering& numbering,
                       std::span<const double> inverse_mass, int threads)
    : branches_(chosen.branches, rods, inverse_mass, threads),
      trunks_(chosen.trees, chosen.branches, rods, inverse_mass, numbering.num_moving),
      points_(inverse_mass.size()),
      groves_(chosen.trees, chosen.branches),
      inverse_mass_(inverse_mass),
      before_batch_(chosen.branches.batches.size()),
      before_trunk_(chosen.trees.size()),
      of_grove_(groves_.size()),
      root_mobility_(chosen.branches.batches.size() * num_lanes),
      rows_(numbering.num_rows()),
      force_(3 * inverse_mass.size()) {
  lay_out();
}

namespace {

std::size_t num_slots(std::size_t rods_of_trunk) {
  return (rods_of_trunk + num_lanes - 1) / num_lanes;
}
/// Returns how far apart the orders of so many slots stand. The number is odd: with a power of 2, orders would meet in
/// the same few lines of the caches.
std::size_t stride_of(std::size_t num_slots) {
  return num_slots | 1;
}

}  // namespace

/// Finds where the batches and trunks of each grove have their slots and places.
void TreeSeries::lay_out() {
  for (std::size_t grove = 0; grove < groves_.size(); ++grove) {
    Extent& end = of_grove_[grove];
    for (const std::size_t batch : groves_[grove].batches) {
      before_batch_[batch] = end;
      const trees::Shape shape = branches_.plan().shape(branches_.plan().batches[batch]);
      end.slots += stride_of(shape.num_rods);
      end.places += shape.num_points();
    }
    for (const std::size_t tree : groves_[grove].trees) {
      before_trunk_[tree] = end;
      end.slots += stride_of(num_slots(trunks_.rods(tree).size()));
    }
  }
}

void TreeSeries::Room::hold(const Extent& extent, std::size_t orders) {
  rods.resize(std::max(rods.size(), extent.slots));
  series.resize(std::max(series.size(), extent.slots * orders));
  points.resize(std::max(points.size(), extent.places));
}

// ---- an expansion ----

struct TreeSeries::Expansion {
  std::span<double* const> coefficients;
  const double* lambda;
  int passes;
};

/// A solve for mu_k and r_{k+2}. Each order has `passes` of them.
struct TreeSeries::Solve {
  int k, pass;

  std::size_t order() const { return static_cast<std::size_t>(k); }
  /// Returns (k+1)(k+2), which r_{k+2} is multiplied by.
  double scale() const { return (k + 1.0) * (k + 2.0); }
  bool is_first() const { return k == 1 && pass == 0; }
  Solve before(int passes) const { return pass > 0 ? Solve{k, pass - 1} : Solve{k - 1, passes - 1}; }
  Solve next(int passes) const { return pass + 1 < passes ? Solve{k, pass + 1} : Solve{k + 1, 0}; }
};

/// The branches of one batch with their series. Each function of the arrays is one loop nest for each instruction set.
class TreeSeries::Branches {
 public:
  Branches(TreeSeries* all, const Expansion& expansion, std::size_t batch, std::size_t workspace, Room* room)
      : expansion_(expansion),
        lanes_(&all->branches_, batch, &all->points_, workspace),
        arrays_{lanes_.shape(),
                stride_of(lanes_.shape().num_rods),
                lanes_.masses(),
                lanes_.rods(),
                lanes_.rows(),
                room->rods.data() + all->before_batch_[batch].slots,
                room->series.data() + all->before_batch_[batch].slots * expansion.coefficients.size(),
                room->points.data() + all->before_batch_[batch].places,
                lanes_.dw(),
                lanes_.points().s} {}

  /// Factorizes S, and finds the first coefficients.
  void begin() {
    lanes_.find_directions(expansion_.coefficients[0]);
    lanes_.eliminate();
    lanes_.hand_over_mobilities();
    for (std::size_t k = 0; k <= 2; ++k) {
      lanes_.read(expansion_.coefficients[k]);
      arrays_.take_coefficient(static_cast<int>(k), k == 0 ? lanes_.offsets() : nullptr);
    }
    lanes_.read_right_side(expansion_.lambda);
    arrays_.begin();
  }
  /// Goes up, before the trunks.
  void substitute_up(Solve solve) {
    const Solve before = solve.before(expansion_.passes);
    solve.pass == 0 ? arrays_.begin_order(solve, before) : arrays_.begin_pass(before);
    trees::substitute_up(arrays_.shape, lanes_.points(), arrays_.factor, arrays_.rows);
    lanes_.hand_over_answers();
  }
  /// Goes down, after the trunks.
  void substitute_down(Solve solve) {
    double* const r = expansion_.coefficients[solve.order() + 2];
    lanes_.call_for(r);
    lanes_.substitute_down();
    add(arrays_.dw, arrays_.shape.num_points(), arrays_.points);
    lanes_.write(arrays_.points, r);
  }

 private:
  struct Arrays {
    trees::Shape shape;
    std::size_t stride;          // from order to order in the series
    const Pack<>* inverse_mass;  // [place]
    const trees::BranchRod* factor;
    trees::BranchRow* rows;
    Series::Rod* rods;
    Series::Coefficient* series;  // [order][rod]
    Pack3<>* points;              // [place] r of the current order
    const Pack3<>* dw;            // [place] what the solve moves them by
    Pack3<>* s;                   // [place] scratch

    [[gnu::always_inline]] std::size_t parent(std::size_t a) const { return static_cast<std::size_t>(shape.parent[a]); }
    [[gnu::always_inline]] Series::Coefficient& coefficient(int k, std::size_t a) const {
      return series[static_cast<std::size_t>(k) * stride + a];
    }
    void take_coefficient(int k, const Pack3<>* offsets) const {
      dispatch([*this, k, offsets] {
        for (std::size_t a = 0; a < shape.num_rods; ++a) {
          const Pack3<> apart = dw[parent(a)] - dw[a];
          coefficient(k, a).a = offsets != nullptr ? apart + offsets[a] : apart;
        }
      });
    }
    /// Computes 1/|a_0|, and mu_0 from lambda_0 in the place of right sides.
    void begin() const {
      dispatch([*this] {
        for (std::size_t a = 0; a < shape.num_rods; ++a) {
          // |a_0| = u.a_0
          rods[a].inverse_length = 1.0 / dot(factor[a].u, coefficient(0, a).a);
          coefficient(0, a).mu = rows[a].b * rods[a].inverse_length;
        }
      });
    }
    /// Takes what a solve found for mu_k.
    [[gnu::always_inline]] void take_multiplier(Solve solve, std::size_t a) const {
      const Pack<> part = solve.scale() * rows[a].z * rods[a].inverse_length;
      Pack<>& mu = coefficient(solve.k, a).mu;
      mu = solve.pass == 0 ? part : mu + part;
    }
    /// Computes mu_{k-1} and a_{k+1}, then r_{k+2} without the part of mu_k and without the trunks, and the right
    /// sides.
    void begin_order(Solve solve, Solve before) const {
      dispatch([*this, solve, before] {
        const Pack3<> nothing{};
        for (std::size_t p = 0; p < shape.num_points(); ++p) nothing.write(&s[p]);
        for (std::size_t a = 0; a < shape.num_rods; ++a) {
          const std::size_t to = parent(a);
          if (!solve.is_first()) {
            take_multiplier(before, a);
            (points[to] - points[a]).write(&coefficient(solve.k + 1, a).a);
          }
          const Series::Known known = Series::multiply(series + a, solve.k, &rods[a].next, stride);
          rods[a].half_square = known.half_square;
          rows[a].b = known.half_square * rods[a].inverse_length;
          (s[a] - known.force).write(&s[a]);
          (s[to] + known.force).write(&s[to]);
        }
        const double factor_of_r = 1.0 / solve.scale();
        for (std::size_t p = 0; p < shape.num_points(); ++p) {
          const Pack3<> r = (factor_of_r * inverse_mass[p]) * s[p];
          r.write(&s[p]);
          r.write(&points[p]);
        }
      });
    }
    /// Computes the right sides that r leaves.
    void begin_pass(Solve before) const {
      dispatch([*this, before] {
        const Pack3<> nothing{};
        for (std::size_t p = 0; p < shape.num_points(); ++p) nothing.write(&s[p]);
        for (std::size_t a = 0; a < shape.num_rods; ++a) {
          take_multiplier(before, a);
          rows[a].b = rods[a].half_square * rods[a].inverse_length + dot(factor[a].u, points[parent(a)] - points[a]);
        }
      });
    }
  };

  const Expansion& expansion_;
  TreeBranches::Lanes lanes_;
  Arrays arrays_;
};

/// The trunk of one tree with its series, eight rods side by side where a rod needs no other one.
class TreeSeries::Trunk {
 public:
  Trunk(TreeSeries* all, const Expansion& expansion, std::size_t tree, Room* room)
      : all_(*all),
        expansion_(expansion),
        tree_(tree),
        rods_(all->trunks_.rods(tree)),
        u_(all->trunks_.directions(tree)),
        stride_(stride_of(num_slots(rods_.size()))),
        slots_(room->rods.data() + all->before_trunk_[tree].slots),
        series_(room->series.data() + all->before_trunk_[tree].slots * expansion.coefficients.size()) {}

  /// Factorizes S, and finds the first coefficients.
  void begin() const {
    for (const auto& [batch, lane, root] : all_.trunks_.branches(tree_))
      all_.root_mobility_[batch * num_lanes + lane] = all_.points_.mobility[static_cast<std::size_t>(root)];
    TreeFindings ignored;
    all_.trunks_.find_directions(tree_, expansion_.coefficients[0], nullptr);
    all_.trunks_.eliminate(tree_, &all_.points_, &ignored);
    take_coefficient(0, all_.trunks_.offsets(tree_));
    take_coefficient(1, {});
    take_coefficient(2, {});
    for_each_lane([&](std::size_t a, std::size_t slot, std::size_t lane) {
      Series::Coefficient& first = series_[slot];
      // |a_0| = u.a_0
      const double length = dot(u_[a], Vec3{first.a.x[lane], first.a.y[lane], first.a.z[lane]});
      slots_[slot].inverse_length[lane] = 1.0 / length;
      first.mu[lane] = expansion_.lambda[rods_[a].row] / length;
    });
  }

  void solve(Solve solve) const {
    double* const r = expansion_.coefficients[solve.order() + 2];
    if (solve.pass == 0) begin_order(solve, r);
    for_each_lane([&](std::size_t a, std::size_t slot, std::size_t lane) {
      const Series::Rod& rod = slots_[slot];
      const auto& [row, child, parent] = rods_[a];
      all_.rows_[static_cast<std::size_t>(row)] =
          rod.half_square[lane] * rod.inverse_length[lane] + dot(u_[a], load(r, parent) - load(r, child));
    });
    double* const x = all_.rows_.data();
    all_.trunks_.substitute_up(tree_, x, &all_.points_, x);
    all_.trunks_.substitute_down(tree_, &all_.points_, x);
    all_.trunks_.move(tree_, all_.points_, r);
    if (solve.pass == 0) pull_branches();
    for_each_lane([&](std::size_t a, std::size_t slot, std::size_t lane) {
      const double part = solve.scale() * x[rods_[a].row] * slots_[slot].inverse_length[lane];
      double& mu = series_[solve.order() * stride_ + slot].mu[lane];
      mu = solve.pass == 0 ? part : mu + part;
    });
  }

 private:
  /// Calls visit(rod, slot, lane). The last lanes of the last slot may repeat the last rod.
  template <class Visit>
  void for_each_lane(const Visit& visit) const {
    for (std::size_t k = 0; k < num_slots(rods_.size()) * num_lanes; ++k)
      visit(std::min(k, rods_.size() - 1), k / num_lanes, k % num_lanes);
  }

  void take_coefficient(std::size_t k, std::span<const Vec3> offsets) const {
    const double* const r = expansion_.coefficients[k];
    for_each_lane([&](std::size_t a, std::size_t slot, std::size_t lane) {
      const Vec3 apart = load(r, rods_[a].parent) - load(r, rods_[a].child);
      set_lane(&series_[k * stride_ + slot].a, lane, offsets.empty() ? apart : apart + offsets[a]);
    });
  }

  /// Computes a_{k+1}, then r_{k+2} without the part of mu_k. The known forces of the trunk's rods pull at the
  /// branches, which answer by the mobilities of their roots.
  void begin_order(Solve solve, double* r) const {
    if (solve.k > 1) take_coefficient(solve.order() + 1, {});
    double* const force = all_.force_.data();
    for (const Index point : all_.trunks_.points(tree_)) store(force, point, {});
    for (const auto& [batch, lane, root] : all_.trunks_.branches(tree_)) store(force, root, {});
    multiply(solve, force);
    for (const Index point : all_.trunks_.points(tree_))
      store(r, point, all_.inverse_mass_[static_cast<std::size_t>(point)] * load(force, point));
    for (const auto& [batch, lane, root] : all_.trunks_.branches(tree_)) {
      const Vec3 answer = all_.root_mobility_[batch * num_lanes + lane] * load(force, root);
      store(r, root, load(all_.points_.s.data(), root) + answer);
      store(all_.points_.s.data(), root, {});  // r has it
    }
  }
  void multiply(Solve solve, double* force) const {
    dispatch([series = series_, slots = slots_, k = solve.k, count = num_slots(rods_.size()), stride = stride_,
              factor_of_r = 1.0 / solve.scale(), rods = rods_, num_moving = all_.trunks_.num_moving(), force] {
      for (std::size_t slot = 0; slot < count; ++slot) {
        const Series::Known known = Series::multiply(series + slot, k, &slots[slot].next, stride);
        slots[slot].half_square = known.half_square;
        for (std::size_t lane = 0; lane < std::min(num_lanes, rods.size() - slot * num_lanes); ++lane) {
          const auto& [row, child, parent] = rods[slot * num_lanes + lane];
          const Vec3 own = factor_of_r * Vec3{known.force.x[lane], known.force.y[lane], known.force.z[lane]};
          add_to(force, parent, own);
          if (child < num_moving) add_to(force, child, -own);
        }
      }
    });
  }
  /// Adds the known forces to those on the roots of branches.
  void pull_branches() const {
    for (const auto& [batch, lane, root] : all_.trunks_.branches(tree_))
      add_to(all_.points_.dw.data(), root, load(all_.force_.data(), root));
  }

  TreeSeries& all_;
  const Expansion& expansion_;
  std::size_t tree_;
  std::span<const trees::Rod> rods_;
  std::span<const Vec3> u_;
  std::size_t stride_;  // from order to order in the series
  Series::Rod* slots_;
  Series::Coefficient* series_;  // [order][slot]
};

void TreeSeries::expand(const Expansion& expansion, const GroveVisit& visit) {
  Room& room = rooms_[visit.workspace()];
  room.hold(of_grove_[visit.number()], expansion.coefficients.size());
  const int last = static_cast<int>(expansion.coefficients.size()) - 3;
  Solve solve{1, 0};
  for (; solve.k <= last; solve = solve.next(expansion.passes)) {
    visit.for_each_batch([&](std::size_t batch, std::size_t workspace) {
      Branches branches(this, expansion, batch, workspace, &room);
      solve.is_first() ? branches.begin() : branches.substitute_down(solve.before(expansion.passes));
      branches.substitute_up(solve);
    });
    visit.for_each_tree([&](std::size_t tree) {
      const Trunk trunk(this, expansion, tree, &room);
      if (solve.is_first()) trunk.begin();
      trunk.solve(solve);
    });
  }
  visit.for_each_batch([&](std::size_t batch, std::size_t workspace) {
    Branches(this, expansion, batch, workspace, &room).substitute_down(solve.before(expansion.passes));
  });
}

void TreeSeries::expand(const Parallel& parallel, std::span<double* const> coefficients, const double* lambda,
                        int passes) {
  const Expansion expansion{coefficients, lambda, passes};
  const std::size_t num_rooms = branches_.num_workspaces(parallel);
  rooms_.resize(num_rooms);
  groves_.visit(parallel, num_rooms, [&](const GroveVisit& visit) { expand(expansion, visit); });
}

}  // namespace tanor::detail
