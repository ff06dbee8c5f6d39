#include "schur/tree_series.hpp"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "base/instruction_sets.hpp"

namespace tanor::detail {

// ---- the plan ----

std::unique_ptr<TreeSeries> TreeSeries::make(const RodRows& rods, const Numbering& numbering,
                                             std::span<const double> inverse_mass, int threads,
                                             std::vector<Index>* islands) {
  TreePieces pieces = TreePieces::take(rods, numbering, false, islands);
  if (pieces.trees.empty()) return nullptr;
  return std::unique_ptr<TreeSeries>(
      new TreeSeries(std::move(pieces), rods, inverse_mass, numbering.num_moving, threads));
}

TreeSeries::TreeSeries(TreePieces pieces, const RodRows& rods, std::span<const double> inverse_mass,
                       std::size_t num_moving, int threads)
    : lanes_(std::move(pieces), rods, inverse_mass, num_moving, threads) {}

void TreeSeries::Room::hold(std::size_t num_rods, std::size_t num_places, std::size_t stride) {
  next.resize(std::max(next.size(), num_rods));
  half_squares.resize(next.size());
  series.resize(std::max(series.size(), num_rods * stride));
  for (auto* array : {&points, &known}) array->resize(std::max(array->size(), num_places));
}

// ---- an expansion ----

struct TreeSeries::Expansion {
  std::span<double* const> coefficients;
  const double* lambda;
  int passes;

  /// Returns how far apart the series of rods stand. The number is odd: with a power of 2, they would meet in the same
  /// few lines of the caches.
  std::size_t stride() const { return coefficients.size() | 1; }
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

/// The pieces of one group with their series. Each function of the arrays is one loop nest for each instruction set.
class TreeSeries::Pieces {
 public:
  Pieces(const Expansion& expansion, const GroveVisit& visit, TreeLanes::Group* group, Room* room)
      : expansion_(expansion), group_(*group) {
    const PieceGroup &own = group->plan(), &first = visit.first_group();
    const std::size_t rod = own.first_rod - first.first_rod, place = own.first_place - first.first_place;
    arrays_ = {group->arrays(),
               expansion.stride(),
               room->next.data() + rod,
               expansion.passes > 1 ? room->half_squares.data() + rod : nullptr,
               room->series.data() + rod * expansion.stride(),
               room->points.data() + place,
               own.has_joints() ? room->known.data() + place : nullptr};
    arrays_.in.rods.b = arrays_.in.rods.z;  // a right side is read once
  }

  /// Factorizes S, and finds the first coefficients.
  void begin() {
    group_.read(expansion_.coefficients[0]);
    arrays_.take_directions(group_.offsets());
    group_.eliminate();
    for (std::size_t k = 1; k <= 2; ++k) {
      group_.read(expansion_.coefficients[k]);
      arrays_.take_coefficient(k);
    }
    group_.read_right_side(expansion_.lambda);
    arrays_.take_multipliers(group_.arrays().rods.b);
  }
  /// Begins a solve. The forces of the rods of these pieces pull at joints, too, which answer for what hangs there.
  void substitute_up(Solve solve) {
    const Solve before = solve.before(expansion_.passes);
    if (!solve.is_first()) group_.take_joints(arrays_.points);
    if (solve.pass == 0) {
      arrays_.begin_order(solve, before);
      group_.answer_at_joints(arrays_.known);
    } else {
      arrays_.begin_pass(before);
      group_.answer_at_joints(nullptr);
    }
    trees::substitute_up(arrays_.in.shape, arrays_.in.points, arrays_.in.rods);
    group_.hand_over_answers();
  }
  /// Ends it.
  void substitute_down(Solve solve) {
    double* const r = expansion_.coefficients[solve.order() + 2];
    group_.call_for(r);
    group_.substitute_down(solve.pass == 0 ? arrays_.known : nullptr, arrays_.points);
    group_.write(arrays_.points, r);
  }

 private:
  struct Arrays {
    TreeLanes::Group::Arrays in;
    std::size_t stride;  // from rod to rod in the series
    Series::Known* next;
    Pack<>* half_squares;         // null if there are no later passes
    Series::Coefficient* series;  // [rod][order]
    Pack3<>*points, *known;       // [place]; no forces are known without joints

    [[gnu::always_inline]] Series::Coefficient& coefficient(std::size_t k, std::size_t a) const {
      return series[a * stride + k];
    }
    /// Calls body(a, parent) for each rod.
    template <class Body>
    [[gnu::always_inline]] void for_each_rod(const Body& body) const {
      const auto loop = [&]<class Parent>(std::type_identity<Parent>) __attribute__((always_inline)) {
        for (std::size_t a = 0; a < in.shape.num_rods; ++a) body(a, Parent(in.shape.parent + num_lanes * a));
      };
      in.shape.have_same_parents ? loop(std::type_identity<trees::SameParent>{})
                                 : loop(std::type_identity<trees::OwnParents>{});
    }
    [[gnu::always_inline]] void clear_s() const {
      const Pack3<> nothing{};
      for (std::size_t p = 0; p < in.shape.num_places; ++p) nothing.write(&in.points.s[p]);
    }

    /// Takes a_0 as the directions.
    void take_directions(const Pack3<>* offsets) const {
      dispatch([*this, offsets] {
        for_each_rod([&](std::size_t a, const auto& parent) __attribute__((always_inline)) {
          const Pack3<> apart = get(parent, in.dw) - in.dw[a];
          (offsets != nullptr ? apart + offsets[a] : apart).write(&in.rods.u[a]);
        });
      });
    }
    void take_coefficient(std::size_t k) const {
      dispatch([*this, k] {
        for_each_rod([&](std::size_t a, const auto& parent) __attribute__((always_inline)) {
          (get(parent, in.dw) - in.dw[a]).write(&coefficient(k, a).a);
        });
      });
    }
    /// Computes mu_0 = lambda_0/|a_0|.
    void take_multipliers(const Pack<>* lambda) const {
      dispatch([*this, lambda] {
        for (std::size_t a = 0; a < in.shape.num_rods; ++a) {
          Pack<> length = dot(in.rods.u[a], in.rods.u[a]);
          take_roots(&length);
          coefficient(0, a).mu = lambda[a] / length;
        }
      });
    }
    /// Takes what a solve found for mu_k.
    [[gnu::always_inline]] void take_multiplier(Solve solve, std::size_t a) const {
      const Pack<> part = solve.scale() * in.rods.z[a];
      Pack<>& mu = coefficient(solve.order(), a).mu;
      mu = solve.pass == 0 ? part : mu + part;
    }
    /// Computes mu_{k-1} and a_{k+1}, then r_{k+2} without the part of mu_k, and the right sides.
    void begin_order(Solve solve, Solve before) const {
      dispatch([*this, solve, before] {
        clear_s();
        for_each_rod([&](std::size_t a, const auto& parent) __attribute__((always_inline)) {
          if (!solve.is_first()) {
            take_multiplier(before, a);
            (get(parent, points) - points[a]).write(&coefficient(solve.order() + 1, a).a);
          }
          const Series::Known found = Series::multiply(series + a * stride, solve.k, &next[a]);
          if (half_squares != nullptr) half_squares[a] = found.half_square;
          in.rods.b[a] = found.half_square;
          (in.points.s[a] - found.force).write(&in.points.s[a]);
          set(parent, in.points.s, get(parent, in.points.s) + found.force);
        });
        const Pack<> factor_of_r = Pack<>{} + 1.0 / solve.scale();
        for (std::size_t p = 0; p < in.shape.num_places; ++p) {
          const Pack3<> force = factor_of_r * in.points.s[p], r = in.points.inverse_mass[p] * force;
          if (known != nullptr) force.write(&known[p]);
          r.write(&in.points.s[p]);
          r.write(&points[p]);
        }
      });
    }
    /// Computes the right sides that r leaves.
    void begin_pass(Solve before) const {
      dispatch([*this, before] {
        clear_s();
        for_each_rod([&](std::size_t a, const auto& parent) __attribute__((always_inline)) {
          take_multiplier(before, a);
          in.rods.b[a] = half_squares[a] + dot(in.rods.u[a], get(parent, points) - points[a]);
        });
      });
    }
  };

  const Expansion& expansion_;
  TreeLanes::Group& group_;
  Arrays arrays_;
};

void TreeSeries::expand(const Expansion& expansion, const GroveVisit& visit) {
  Room& room = rooms_[visit.workspace()];
  const TreePieces& plan = lanes_.pieces();
  const PieceGroup &first = visit.first_group(), &last = plan.groups[visit.grove().end_group() - 1];
  room.hold(last.first_rod + last.num_rods - first.first_rod, last.first_place + last.num_places() - first.first_place,
            expansion.stride());
  const int end = static_cast<int>(expansion.coefficients.size()) - 2;
  const auto down = [&](Solve solve) {
    return [&, solve](TreeLanes::Group& group) { Pieces(expansion, visit, &group, &room).substitute_down(solve); };
  };
  visit.up([&](TreeLanes::Group& group) { Pieces(expansion, visit, &group, &room).begin(); });
  Solve solve{1, 0};
  for (; solve.k < end; solve = solve.next(expansion.passes)) {
    // The lowest pieces end one solve and begin the next one while their series are in the cache.
    const Solve before = solve.before(expansion.passes);
    if (!solve.is_first()) visit.down(down(before), 1);
    visit.take_level(0, [&](TreeLanes::Group& group) {
      Pieces pieces(expansion, visit, &group, &room);
      if (!solve.is_first()) pieces.substitute_down(before);
      pieces.substitute_up(solve);
    });
    visit.up([&](TreeLanes::Group& group) { Pieces(expansion, visit, &group, &room).substitute_up(solve); }, 1);
  }
  visit.down(down(solve.before(expansion.passes)));
}

void TreeSeries::expand(const Parallel& parallel, std::span<double* const> coefficients, const double* lambda,
                        int passes) {
  if (coefficients.size() < 4) return;
  const Expansion expansion{coefficients, lambda, passes};
  rooms_.resize(std::max(rooms_.size(), lanes_.num_workspaces(parallel)));
  visit_groves(parallel, &lanes_, [&](const GroveVisit& visit) { expand(expansion, visit); });
}

}  // namespace tanor::detail
