#include "evaluate/formula_forces.hpp"

#include <algorithm>
#include <array>

namespace tanor::detail {

namespace {

constexpr std::size_t most_in_chunk = 64;  // points, and blocks of derivatives, in a call of a kernel

/// Calls body(first, count, r, v) for chunks of members with the places and velocities of their points.
template <class Body>
void for_chunks(const Parallel& parallel, const FormulaGroup& group, std::size_t chunk, const double* r,
                const double* v, const Body& body) {
  const std::size_t p = group.points_per_member();
  parallel.for_ranges(group.size(), [&](std::size_t begin, std::size_t end) {
    std::array<double, 3 * most_in_chunk> r_chunk, v_chunk;  // NOLINT: filled before use
    for (std::size_t first = begin; first < end; first += chunk) {
      const std::size_t count = std::min(chunk, end - first);
      for (std::size_t n = 0; n < count * p; ++n) {
        store(r_chunk.data(), n, load(r, group.points[first * p + n]));
        store(v_chunk.data(), n, load(v, group.points[first * p + n]));
      }
      body(first, count, r_chunk.data(), v_chunk.data());
    }
  });
}

}  // namespace

FormulaGroup::FormulaGroup(const FormulaForce& formula, const Numbering& numbering) : kernel(formula.kernel) {
  const auto add_point = [&](Index point) { points.push_back(numbering.inner_point[static_cast<std::size_t>(point)]); };
  for (const Index point : formula.points) add_point(point);
  for (const auto& tuple : formula.tuples)
    for (const Index point : tuple) add_point(point);
}

FormulaForces::FormulaForces(const Numbering& numbering, std::vector<FormulaGroup> groups)
    : num_moving_(numbering.num_moving), groups_(std::move(groups)) {
  std::vector<Index> points;
  for (const FormulaGroup& group : groups_) {
    depends_on_velocity_ = depends_on_velocity_ || group.kernel.depends_on_velocity;
    points.insert(points.end(), group.points.begin(), group.points.end());
  }
  on_points_ = {numbering.num_points(), points};
}

/// Works in chunks: the points are gathered, and the kernel writes into the slots.
void FormulaForces::evaluate(const Parallel& parallel, double t, const double* r, const double* v) {
  const Parallel serial(1);
  std::size_t first_slot = 0;
  for (const FormulaGroup& group : groups_) {
    const std::size_t p = group.points_per_member();
    const auto evaluate_chunk = [&](std::size_t first, std::size_t count, const double* r_chunk,
                                    const double* v_chunk) {
      double* const f = on_points_.slot(first_slot + first * p);
      group.kernel.evaluate(group.kernel.context.get(), {count, t, r_chunk, v_chunk, f});
    };
    for_chunks(group.kernel.thread_safe ? parallel : serial, group, most_in_chunk / p, r, v, evaluate_chunk);
    first_slot += group.points.size();
  }
}

/// One member of a group: its points, its derivatives [3p][6p], and the number of its first influence.
struct FormulaForces::Member {
  const Index* points;
  const double* derivative;
  std::size_t first_influence;
};

/// Adds up the blocks of each point's own derivatives, and writes those of other points as influences.
void FormulaForces::add_member_derivatives(const FormulaGroup& group, const Member& member,
                                           const ForceDerivatives& to) const {
  const std::size_t p = group.points_per_member();
  std::size_t influence = member.first_influence;
  for (std::size_t ij = 0; ij < p * p; ++ij) {
    const std::size_t i = ij / p, j = ij % p;
    Block3 by_position, by_velocity;
    for (std::size_t entry = 0; entry < 9; ++entry) {
      const double* const row = member.derivative + 6 * p * (3 * i + entry / 3);
      by_position.entries[entry] = row[3 * j + entry % 3];
      by_velocity.entries[entry] = row[3 * (p + j) + entry % 3];
    }
    if (i == j) {
      const auto point = static_cast<std::size_t>(member.points[i]);
      if (point >= num_moving_) continue;
      to.point_positions[point] += by_position;
      to.point_velocities[point] += by_velocity;
    } else {
      to.influence_positions[influence] = by_position;
      if (to.influence_velocities != nullptr) to.influence_velocities[influence] = by_velocity;
      ++influence;
    }
  }
}

void FormulaForces::append_influences(std::vector<Influence>* list) const {
  for (const FormulaGroup& group : groups_) {
    const std::size_t p = group.points_per_member();
    detail::append_influences(
        group.size(), p, [&](std::size_t k, std::size_t i) { return group.points[k * p + i]; }, list);
  }
}

/// Works in chunks, as `evaluate` does. One group follows the other, so that points in several groups add up. Tuples
/// may share points, so they also follow one another.
void FormulaForces::add_derivatives(const Parallel& parallel, double t, const double* r, const double* v,
                                    std::size_t first_influence, const ForceDerivatives& to) const {
  const Parallel serial(1);
  for (const FormulaGroup& group : groups_) {
    const std::size_t p = group.points_per_member(), num_influences = p * (p - 1);
    const bool is_parallel = group.kernel.thread_safe && p == 1;
    if (group.kernel.knows_derivatives) {
      const auto add_chunk = [&](std::size_t first, std::size_t count, const double* r_chunk, const double* v_chunk) {
        std::array<double, 3 * most_in_chunk> f;            // NOLINT: filled before use
        std::array<double, 18 * most_in_chunk> derivative;  // NOLINT: filled before use
        group.kernel.evaluate(group.kernel.context.get(), {count, t, r_chunk, v_chunk, f.data(), derivative.data()});
        for (std::size_t k = 0; k < count; ++k)
          add_member_derivatives(group,
                                 {group.points.data() + (first + k) * p, derivative.data() + 18 * p * p * k,
                                  first_influence + (first + k) * num_influences},
                                 to);
      };
      for_chunks(is_parallel ? parallel : serial, group, most_in_chunk / (p * p), r, v, add_chunk);
    } else {
      for (std::size_t n = 0; n < group.size() * num_influences; ++n) to.influence_positions[first_influence + n] = {};
    }
    first_influence += group.size() * num_influences;
  }
}

}  // namespace tanor::detail
