#include "schur/group_series.hpp"

#include <algorithm>
#include <utility>

#include "base/lane_parts.hpp"

namespace tanor::detail {

// ---- an expansion ----

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

void GroupSeries::Room::hold(const LaneExpansion& expansion, const GroveVisit& visit) {
  const LanePlan::Extent extent = visit.extent();
  half_squares.resize(std::max(half_squares.size(), extent.rods));
  next.resize(packs_of_rod * half_squares.size());
  series.resize(std::max(series.size(), packs_of_rod * extent.rods * expansion.stride()));
  known.resize(std::max(known.size(), extent.places));
  weights.resize(known.size());
  largest.resize(std::max(largest.size(), extent.groups));
  counters.clear();
  first_island = visit.first_island();
  for (std::size_t first = first_island; first < visit.end_island(); first += num_lanes)
    counters.emplace_back(expansion.needed.step, std::min(num_lanes, visit.end_island() - first));
  of_islands.resize(counters.size());
}

bool GroupSeries::Room::note(const GroveVisit& visit, int order) {
  if (visit.stands_alone()) return counters[0].note(order, largest[0]);
  std::ranges::fill(of_islands, Largest());
  for (std::size_t k = 0; k < visit.groups().size(); ++k) {
    const LaneGroup& group = visit.groups()[k];
    for (std::size_t lane = 0; lane < group.num_members; ++lane) {
      const std::size_t own = static_cast<std::size_t>(group.island[lane]) - first_island;
      of_islands[own / num_lanes].include(own % num_lanes, largest[k], lane);
    }
  }
  bool are_enough = true;
  for (std::size_t k = 0; k < counters.size(); ++k) are_enough = counters[k].note(order, of_islands[k]) && are_enough;
  return are_enough;
}

/// The rods of one group with their series. Each function of the arrays is one loop nest for each instruction set.
class GroupSeries::Rods {
 public:
  Rods(const LaneExpansion& expansion, const GroveVisit& visit, LaneGroups::Group* group, Room* room)
      : expansion_(expansion), group_(*group) {
    const LaneGroup &own = group->plan(), &first = visit.groups()[0];
    const std::size_t rod = own.first_rod - first.first_rod, place = own.first_place - first.first_place;
    arrays_ = {group->arrays(),
               expansion.stride(),
               room->series.data() + packs_of_rod * rod * expansion.stride(),
               room->next.data() + packs_of_rod * rod,
               expansion.passes > 1 ? room->half_squares.data() + rod : nullptr,
               own.has_joints() ? room->known.data() + place : nullptr,
               room->weights.data() + place,
               room->largest.data() + (&own - &first)};
    arrays_.b = arrays_.z;  // a right side is read once
    arrays_.s = group->scratch();
  }

  /// Factorizes S, and finds the first coefficients and the weights of terms that are counted.
  void begin() {
    if (expansion_.is_counting()) read_tolerances();
    for (std::size_t k = 0; k <= 2; ++k) {
      group_.lists().points.read(expansion_.coefficients[k], arrays_.points);
      k == 0 ? arrays_.take_directions() : arrays_.take_coefficient(k);
      if (expansion_.is_counting() && k < 2)
        arrays_.weigh(k == 0 ? &TermCounter::Weights::position : &TermCounter::Weights::velocity,
                      expansion_.needed.step.rtol);
    }
    group_.eliminate();
    group_.lists().rows.read(expansion_.lambda, arrays_.b);
    arrays_.take_multipliers();
  }
  /// Begins a solve. The forces of the rods of these pieces pull at joints, too, which answer for what hangs there.
  void substitute_up(Solve solve) {
    if (!solve.is_first()) group_.take_joints(arrays_.points);
    arrays_.run([ solve, before = solve.before(expansion_.passes) ](const auto& part, auto ends, const Arrays& own)
                    __attribute__((always_inline)) {
                      solve.pass == 0 ? own.begin_order(part, ends, solve, before) : own.begin_pass(part, before);
                    });
    group_.answer_at_joints(solve.pass == 0 ? arrays_.known : nullptr);
    group_.hand_over_ends(solve.pass == 0 ? arrays_.points : nullptr);
    lanes::substitute_up(arrays_);
    group_.hand_over_answers();
  }
  /// Ends it.
  void substitute_down(Solve solve) {
    group_.substitute_down(arrays_.points, solve.pass == 0 ? arrays_.known : nullptr);
    group_.lists().points.write(arrays_.points, expansion_.coefficients[solve.order() + 2]);
    if (counts(solve)) {
      arrays_.run([](const auto& part, auto, const Arrays& own) __attribute__((always_inline)) {
        own.largest->find(part, own.points, own.weights, own.num_places);
      });
    }
  }

 private:
  bool counts(Solve solve) const { return expansion_.is_counting() && solve.pass + 1 == expansion_.passes; }
  /// Writes the absolute errors of points in the place of their weights.
  void read_tolerances() {
    for (std::size_t slot = 0; slot < num_lanes * group_.plan().num_places; ++slot) {
      const auto [position, velocity] = expansion_.needed.atol_of(group_.lists().points.numbers()[slot]);
      arrays_.weights[slot / num_lanes].position[slot % num_lanes] = position;
      arrays_.weights[slot / num_lanes].velocity[slot % num_lanes] = velocity;
    }
  }

  struct Arrays : lanes::Arrays {
    std::size_t stride;             // from rod to rod in the series
    Pack<>*series, *next;           // see Room
    Pack<>* half_squares;           // null if there are no later passes
    Pack3<>* known;                 // [place] null without joints, where no forces are known
    TermCounter::Weights* weights;  // [place]
    Largest* largest;

    template <class Body>
    void run(const Body& body) const {
      lanes::for_group(*this, body);
    }
    /// Returns the coefficients of a rod, and what is known of its next order.
    template <class Lanes>
    [[gnu::always_inline]] auto* series_of(const Lanes& part, std::size_t a) const {
      return reinterpret_cast<typename RodSeries<Lanes::width>::Coefficient*>(series) +
             (part.first() / Lanes::width * num_rods + a) * stride;
    }
    template <class Lanes>
    [[gnu::always_inline]] auto* next_of(const Lanes& part, std::size_t a) const {
      return reinterpret_cast<typename RodSeries<Lanes::width>::Known*>(next) + part.first() / Lanes::width * num_rods +
             a;
    }
    /// Takes a_0 as the directions.
    void take_directions() const {
      run([](const auto& part, auto ends, const Arrays& own) __attribute__((always_inline)) {
        for (std::size_t a = 0; a < own.num_rods; ++a) {
          const auto apart = lanes::difference(part, ends, a, own.points);
          part.write(own.offset != nullptr ? apart + part.of(own.offset[a]) : apart, &own.u[a]);
        }
      });
    }
    void take_coefficient(std::size_t k) const {
      run([k](const auto& part, auto ends, const Arrays& own) __attribute__((always_inline)) {
        for (std::size_t a = 0; a < own.num_rods; ++a)
          lanes::difference(part, ends, a, own.points).write(&own.series_of(part, a)[k].a);
      });
    }
    /// Computes mu_0 = lambda_0/|a_0|.
    void take_multipliers() const {
      run([](const auto& part, auto, const Arrays& own) __attribute__((always_inline)) {
        for (std::size_t a = 0; a < own.num_rods; ++a) {
          const auto along = part.of(own.u[a]);
          auto rho = dot(along, along);
          take_roots(&rho);
          own.series_of(part, a)->mu = part.of(own.b[a]) / rho;
        }
      });
    }
    /// Takes an error up to 2^(1/2) smaller, which needs no root: (atol + rtol |r|)^2 >= atol^2 + rtol^2 r.r.
    void weigh(Pack<> TermCounter::Weights::*weight, double rtol) const {
      run([ weight, rtol ](const auto& part, auto, const Arrays& own) __attribute__((always_inline)) {
        for (std::size_t p = 0; p < own.num_places; ++p) {
          auto& cell = part.of(own.weights[p].*weight);
          const auto r = part.of(own.points[p]);
          cell = 1.0 / (cell * cell + (rtol * rtol) * dot(r, r));
        }
      });
    }
    /// Takes what a solve found for mu_k.
    template <class Lanes>
    [[gnu::always_inline]] void take_multiplier(const Lanes& part, Solve solve, std::size_t a) const {
      const auto more = solve.scale() * part.of(z[a]);
      auto& mu = series_of(part, a)[solve.order()].mu;
      mu = solve.pass == 0 ? more : mu + more;
    }
    /// Computes mu_{k-1} and a_{k+1}, then r_{k+2} without the part of mu_k, and the right sides.
    template <class Lanes, class Ends>
    [[gnu::always_inline]] void begin_order(const Lanes& part, const Ends& ends, Solve solve, Solve before) const {
      const typename Lanes::Vector nothing{};
      for (std::size_t p = 0; p < num_places; ++p) part.write(nothing, &s[p]);
      for (std::size_t a = 0; a < num_rods; ++a) {
        auto* const of_rod = series_of(part, a);
        if (!solve.is_first()) {
          take_multiplier(part, before, a);
          lanes::difference(part, ends, a, points).write(&of_rod[solve.order() + 1].a);
        }
        const auto sums = RodSeries<Lanes::width>::multiply(of_rod, solve.k, next_of(part, a));
        if (half_squares != nullptr) part.of(half_squares[a]) = sums.half_square;
        part.of(b[a]) = sums.half_square;
        lanes::pull(part, ends, a, sums.force, s);
      }
      const auto factor_of_r = typename Lanes::Lane{} + 1.0 / solve.scale();
      for (std::size_t p = 0; p < num_places; ++p) {
        const auto force = factor_of_r * part.of(s[p]), r = part.of(inverse_mass[p]) * force;
        if (known != nullptr) part.write(force, &known[p]);
        part.write(r, &s[p]);
        part.write(r, &points[p]);
      }
    }
    /// Begins with the r that is there.
    template <class Lanes>
    [[gnu::always_inline]] void begin_pass(const Lanes& part, Solve before) const {
      for (std::size_t a = 0; a < num_rods; ++a) {
        take_multiplier(part, before, a);
        part.of(b[a]) = part.of(half_squares[a]);
      }
      for (std::size_t p = 0; p < num_places; ++p) part.write(part.of(points[p]), &s[p]);
    }
  };

  const LaneExpansion& expansion_;
  LaneGroups::Group& group_;
  Arrays arrays_;
};

/// Computes the terms that are needed, and sets the others to 0.
void GroupSeries::expand(const LaneExpansion& expansion, const GroveVisit& visit) {
  Room& room = rooms_[visit.workspace()];
  room.hold(expansion, visit);
  const int passes = expansion.passes, order = expansion.order();
  int reached = 2;
  // Goes through the orders by advance(solve).
  const auto go = [&](const auto& advance) {
    bool are_enough = false;
    for (Solve solve{1, 0}; !are_enough && solve.k + 2 <= order; solve = solve.next(passes)) {
      advance(solve);
      reached = solve.k + 2;
      are_enough = expansion.is_counting() && solve.pass + 1 == passes && room.note(visit, reached);
    }
  };
  const auto each = [&](const auto& work) {
    return [&](LaneGroups::Group& group) {
      Rods rods(expansion, visit, &group, &room);
      work(rods);
    };
  };
  if (visit.stands_alone()) {
    visit.up(each([&](Rods& rods) {
      rods.begin();
      go([&](Solve solve) {
        rods.substitute_up(solve);
        rods.substitute_down(solve);
      });
    }));
  } else {
    visit.up(each([&](Rods& rods) { rods.begin(); }));
    visit.factorize_separators();
    go([&](Solve solve) {
      visit.up(each([&](Rods& rods) { rods.substitute_up(solve); }));
      visit.solve_separators(true);
      visit.down(each([&](Rods& rods) { rods.substitute_down(solve); }));
    });
  }
  for (std::size_t island = visit.first_island(); island < visit.end_island(); ++island) {
    const std::size_t own = island - room.first_island;
    const FoundTerms found = room.counters[own / num_lanes].found(own % num_lanes, order);
    const auto [first, end] = groups_.plan().islands[island];
    room.longest = std::min(room.longest, found.longest);
    end_series(found, reached, static_cast<std::size_t>(first), static_cast<std::size_t>(end), expansion.coefficients,
               expansion.last_term);
  }
}

double GroupSeries::expand(const Parallel& parallel, const LaneExpansion& expansion) {
  rooms_.resize(groups_.workspaces().size());
  for (Room& room : rooms_) room.longest = any_length;
  visit_groves(parallel, &groups_, Pass::Repeated, [&](const GroveVisit& visit) { expand(expansion, visit); });
  double longest = any_length;
  for (const Room& room : rooms_) longest = std::min(longest, room.longest);
  return longest;
}

}  // namespace tanor::detail
