#include "schur/group_series.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/instruction_sets.hpp"

namespace tanor::detail {

std::size_t GroupSeries::num_groups() const {
  return static_cast<std::size_t>(std::ranges::count_if(groups_.plan().groups, &LaneGroup::stands_alone));
}

void GroupSeries::Room::hold(const LanePlan::Extent& extent, std::size_t stride) {
  next.resize(std::max(next.size(), extent.rods));
  half_squares.resize(next.size());
  series.resize(std::max(series.size(), extent.rods * stride));
  known.resize(std::max(known.size(), extent.places));
  weights.resize(known.size());
}

// ---- an expansion ----

struct GroupSeries::Expansion {
  std::span<double* const> coefficients;
  const double* lambda;
  int passes;
  const NeededTerms& needed;
  std::span<std::uint8_t> last_term;

  int order() const { return static_cast<int>(coefficients.size()) - 1; }
  /// Returns how far apart the series of rods stand. The number is odd: with a power of 2, they would meet in the same
  /// few lines of the caches.
  std::size_t stride() const { return coefficients.size() | 1; }
};

/// A solve for mu_k and r_{k+2}. Each order has `passes` of them.
struct GroupSeries::Solve {
  int k, pass;

  std::size_t order() const { return static_cast<std::size_t>(k); }
  /// Returns (k+1)(k+2), which r_{k+2} is multiplied by.
  double scale() const { return (k + 1.0) * (k + 2.0); }
  bool is_first() const { return k == 1 && pass == 0; }
  Solve before(int passes) const { return pass > 0 ? Solve{k, pass - 1} : Solve{k - 1, passes - 1}; }
  Solve next(int passes) const { return pass + 1 < passes ? Solve{k, pass + 1} : Solve{k + 1, 0}; }
};

/// The rods of one group with their series. Each function of the arrays is one loop nest for each instruction set.
class GroupSeries::Rods {
 public:
  Rods(const Expansion& expansion, const GroveVisit& visit, LaneGroups::Group* group, Room* room)
      : expansion_(expansion), group_(*group) {
    const LaneGroup &own = group->plan(), &first = visit.groups()[0];
    const std::size_t rod = own.first_rod - first.first_rod, place = own.first_place - first.first_place;
    arrays_ = {group->arrays(),
               expansion.stride(),
               room->next.data() + rod,
               expansion.passes > 1 ? room->half_squares.data() + rod : nullptr,
               room->series.data() + rod * expansion.stride(),
               group->own().points,
               own.has_joints() ? room->known.data() + place : nullptr,
               room->weights.data() + place};
    arrays_.in.rods.b = arrays_.in.rods.z;  // a right side is read once
    arrays_.in.points.s = group->scratch();
  }

  /// Factorizes S, and finds the first coefficients and the weights of terms that are counted.
  void begin(const Terms* terms) {
    if (terms != nullptr) read_tolerances();
    for (std::size_t k = 0; k <= 2; ++k) {
      group_.read_points(expansion_.coefficients[k], arrays_.points);
      k == 0 ? arrays_.take_directions(group_.offsets()) : arrays_.take_coefficient(k);
      if (terms != nullptr && k < 2)
        arrays_.weigh(*terms, k == 0 ? &Terms::Weights::position : &Terms::Weights::velocity);
    }
    group_.eliminate();
    group_.read_rows(expansion_.lambda, arrays_.in.rods.b);
    arrays_.take_multipliers();
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
    lanes::substitute_up(arrays_.in);
    group_.hand_over_answers();
  }
  /// Ends it.
  void substitute_down(Solve solve) {
    group_.substitute_down(arrays_.points, solve.pass == 0 ? arrays_.known : nullptr);
    group_.write_points(arrays_.points, expansion_.coefficients[solve.order() + 2]);
  }
  Terms::Largest largest() const { return arrays_.largest(); }

 private:
  void read_tolerances() {
    for (std::size_t slot = 0; slot < num_lanes * group_.plan().num_places; ++slot)
      Terms::read_atol(expansion_.needed, std::max<Index>(group_.point_list()[slot], -1), slot % num_lanes,
                       &arrays_.weights[slot / num_lanes]);
  }

  struct Arrays {
    LaneGroups::Group::Arrays in;
    std::size_t stride;  // from rod to rod in the series
    Series::Known* next;
    Pack<>* half_squares;         // null if there are no later passes
    Series::Coefficient* series;  // [rod][order]
    Pack3<>*points, *known;       // [place] r of the current order; no forces are known without joints
    Terms::Weights* weights;      // [place]

    [[gnu::always_inline]] Series::Coefficient& coefficient(std::size_t k, std::size_t a) const {
      return series[a * stride + k];
    }
    [[gnu::always_inline]] static Part<num_lanes> all() { return Part<num_lanes>(0); }
    /// Calls body(rod, ends) for each rod.
    template <class Body>
    void for_each_rod(const Body& body) const {
      dispatch([body, shape = in.shape] {
        lanes::with_ends(shape, [&](auto ends) {
          for (std::size_t a = 0; a < shape.num_rods; ++a) body(a, ends);
        });
      });
    }

    /// Takes a_0 as the directions.
    void take_directions(const Pack3<>* offsets) const {
      for_each_rod([ *this, offsets ](std::size_t a, const auto& ends) __attribute__((always_inline)) {
        const Pack3<> apart = lanes::difference(all(), ends, a, points);
        (offsets != nullptr ? apart + offsets[a] : apart).write(&in.rods.u[a]);
      });
    }
    void take_coefficient(std::size_t k) const {
      for_each_rod([ *this, k ](std::size_t a, const auto& ends) __attribute__((always_inline)) {
        lanes::difference(all(), ends, a, points).write(&coefficient(k, a).a);
      });
    }
    /// Computes mu_0 = lambda_0/|a_0|.
    void take_multipliers() const {
      for_each_rod([*this](std::size_t a, const auto&) __attribute__((always_inline)) {
        Pack<> length = dot(in.rods.u[a], in.rods.u[a]);
        take_roots(&length);
        coefficient(0, a).mu = in.rods.b[a] / length;
      });
    }
    void weigh(const Terms& terms, Pack<> Terms::Weights::*weight) const {
      dispatch([*this, &terms, weight] {
        for (std::size_t p = 0; p < in.shape.num_places; ++p)
          weights[p].*weight = terms.weigh(points[p], weights[p].*weight);
      });
    }
    Terms::Largest largest() const {
      return dispatch([*this] {
        Terms::Largest result;
        for (std::size_t p = 0; p < in.shape.num_places; ++p) result.include(points[p], weights[p]);
        return result;
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
        lanes::with_ends(in.shape, [&](auto ends) {
          Pack3<>* const s = in.points.s;
          const Pack3<> nothing{};
          for (std::size_t p = 0; p < in.shape.num_places; ++p) nothing.write(&s[p]);
          for (std::size_t a = 0; a < in.shape.num_rods; ++a) {
            if (!solve.is_first()) {
              take_multiplier(before, a);
              lanes::difference(all(), ends, a, points).write(&coefficient(solve.order() + 1, a).a);
            }
            const Series::Known found = Series::multiply(series + a * stride, solve.k, &next[a]);
            if (half_squares != nullptr) half_squares[a] = found.half_square;
            in.rods.b[a] = found.half_square;
            lanes::pull(all(), ends, a, found.force, s);
          }
          const Pack<> factor_of_r = Pack<>{} + 1.0 / solve.scale();
          for (std::size_t p = 0; p < in.shape.num_places; ++p) {
            const Pack3<> force = factor_of_r * s[p], r = in.points.inverse_mass[p] * force;
            if (known != nullptr) force.write(&known[p]);
            r.write(&s[p]);
            r.write(&points[p]);
          }
        });
      });
    }
    /// Begins with the r that is there.
    void begin_pass(Solve before) const {
      for_each_rod([ *this, before ](std::size_t a, const auto&) __attribute__((always_inline)) {
        take_multiplier(before, a);
        in.rods.b[a] = half_squares[a];
      });
      std::memcpy(in.points.s, points, in.shape.num_places * sizeof(Pack3<>));
    }
  };

  const Expansion& expansion_;
  LaneGroups::Group& group_;
  Arrays arrays_;
};

/// Computes the terms that are needed, and sets the others to 0.
void GroupSeries::expand(const Expansion& expansion, const GroveVisit& visit) {
  Room& room = rooms_[visit.workspace()];
  room.hold(visit.extent(), expansion.stride());
  Terms terms(expansion.needed);
  const bool counts = visit.stands_alone() && terms.is_counting();
  const int passes = expansion.passes, order = expansion.order();
  int reached = visit.stands_alone() ? 2 : order;
  const auto each = [&](const auto& work) {
    return [&](LaneGroups::Group& group) {
      Rods rods(expansion, visit, &group, &room);
      work(rods);
    };
  };
  visit.up(each([&](Rods& rods) {
    rods.begin(counts ? &terms : nullptr);
    bool are_enough = false;
    for (Solve solve{1, 0}; !are_enough && solve.k + 2 <= order && visit.stands_alone(); solve = solve.next(passes)) {
      rods.substitute_up(solve);
      rods.substitute_down(solve);
      reached = solve.k + 2;
      are_enough = counts && solve.pass + 1 == passes && terms.note(reached, rods.largest());
    }
  }));
  const auto down = [&](Solve solve) { return [solve](Rods& rods) { rods.substitute_down(solve); }; };
  Solve solve{1, 0};
  for (; solve.k + 2 <= order && !visit.stands_alone(); solve = solve.next(passes)) {
    // The lowest pieces end one solve and begin the next one while their series are in the cache.
    const Solve before = solve.before(passes);
    if (!solve.is_first()) visit.down(each(down(before)), 1);
    visit.take_level(0, each([&](Rods& rods) {
                       if (!solve.is_first()) rods.substitute_down(before);
                       rods.substitute_up(solve);
                     }));
    visit.up(each([&](Rods& rods) { rods.substitute_up(solve); }), 1);
  }
  if (!solve.is_first()) visit.down(each(down(solve.before(passes))));
  for (const LaneGroup& group : visit.groups()) {
    for (std::size_t lane = 0; lane < num_lanes; ++lane) {
      if (!group.ends_island[lane]) continue;
      const FoundTerms found = counts ? terms.found(lane, order) : FoundTerms{order};
      const auto [first, end] = groups_.plan().islands[static_cast<std::size_t>(group.island[lane])];
      room.longest = std::min(room.longest, found.longest);
      end_series(found, reached, static_cast<std::size_t>(first), static_cast<std::size_t>(end), expansion.coefficients,
                 expansion.last_term);
    }
  }
}

double GroupSeries::expand(const Parallel& parallel, std::span<double* const> coefficients, const double* lambda,
                           int passes, const NeededTerms& needed, std::span<std::uint8_t> last_term) {
  rooms_.resize(groups_.workspaces().size());
  for (Room& room : rooms_) room.longest = any_length;
  const Expansion expansion{coefficients, lambda, passes, needed, last_term};
  visit_groves(parallel, &groups_, [&](const GroveVisit& visit) { expand(expansion, visit); });
  double longest = any_length;
  for (const Room& room : rooms_) longest = std::min(longest, room.longest);
  return longest;
}

}  // namespace tanor::detail
