#include "schur/batch_series.hpp"

#include <algorithm>
#include <cmath>

#include "base/instruction_sets.hpp"
#include "schur/batch_kernels.hpp"
#include "schur/batch_numbers.hpp"

namespace tanor::detail {

BatchSeries::BatchSeries(const Constraints& constraints, const Numbering& numbering,
                         std::span<const double> inverse_mass, std::vector<Index>* islands)
    : equal_islands_(take_equal_islands(constraints, numbering, inverse_mass, false, islands)) {
  for (std::size_t k = 0; k < equal_islands_.size(); ++k) {
    for (std::size_t number = 0; number < equal_islands_[k].num_batches; ++number) batches_.push_back({k, number});
  }
}

/// The rods of one batch with the arrays of a thread. Each function is one loop nest for each instruction set.
struct BatchSeries::Lanes {
  const std::array<int, 2>* ends;  // [rod] places of its points
  const Pack3<>* offsets;          // part of a_0; null if there are none
  const Pack<>* inverse_mass;      // [place]
  std::size_t num_points, num_rods, num_places, stride;
  Series::Rod* rods;
  Pack3<>* u;
  Series::Coefficient* series;
  Pack3<>* points;
  Pack<>* rows;
  Terms::Weights* weights;

  /// Computes a_k from the points' r.
  [[gnu::always_inline]] Pack3<> distance(std::size_t rod) const {
    const auto [i, j] = ends[rod];
    return points[j] - points[i];
  }
  void take_coefficient(std::size_t k) const {
    dispatch([*this, k] {
      for (std::size_t a = 0; a < num_rods; ++a) {
        const Pack3<> along = distance(a);
        series[a * stride + k].a = k == 0 && offsets != nullptr ? along + offsets[a] : along;
      }
    });
  }
  void weigh_positions(const Terms& terms) const {
    dispatch([*this, &terms] {
      for (std::size_t p = 0; p < num_points; ++p) weights[p].position = terms.weigh(points[p], weights[p].position);
    });
  }
  void weigh_velocities(const Terms& terms) const {
    dispatch([*this, &terms] {
      for (std::size_t p = 0; p < num_points; ++p) weights[p].velocity = terms.weigh(points[p], weights[p].velocity);
    });
  }
  Terms::Largest largest() const {
    return dispatch([*this] {
      Terms::Largest result;
      for (std::size_t p = 0; p < num_points; ++p) result.include(points[p], weights[p]);
      return result;
    });
  }
  /// Computes u, and mu_0 from lambda_0 in `rows`.
  void begin() const {
    dispatch([*this] {
      for (std::size_t a = 0; a < num_rods; ++a) {
        Series::Coefficient& first = series[a * stride];
        Pack3<> unit = first.a;
        normalise(&unit.x, &unit.y, &unit.z, &rods[a].inverse_length);
        unit.write(&u[a]);
        first.mu = rows[a] * rods[a].inverse_length;
      }
    });
  }

  /// Computes r_{k+2} without the part of mu_k into the points, and the right side of S x = -b into `rows`.
  void begin_order(int k) const {
    dispatch([*this, k] {
      for (std::size_t p = 0; p < num_places; ++p) Pack3<>{}.write(&points[p]);
      for (std::size_t a = 0; a < num_rods; ++a) {
        const Series::Known known = Series::multiply(series + a * stride, k, &rods[a].next);
        rods[a].half_square = known.half_square;
        const auto [i, j] = ends[a];
        (points[i] - known.force).write(&points[i]);
        (points[j] + known.force).write(&points[j]);
      }
      const double factor = 1.0 / ((k + 1.0) * (k + 2.0));
      for (std::size_t p = 0; p < num_places; ++p) ((factor * inverse_mass[p]) * points[p]).write(&points[p]);
      find_right_side();
    });
  }
  [[gnu::always_inline]] void find_right_side() const {
    for (std::size_t a = 0; a < num_rods; ++a)
      rows[a] = rods[a].half_square * rods[a].inverse_length + dot(u[a], distance(a));
  }
  /// Adds x of `rows` = factor lambda_k: r += M^-1 K x, mu_k. Then it computes a_{k+2}, or the right side of the next
  /// pass.
  void add(int k, bool is_first, bool is_last) const {
    dispatch([*this, k, is_first, is_last] {
      const double inverse_factor = (k + 1.0) * (k + 2.0);
      const auto row = static_cast<std::size_t>(k);
      for (std::size_t a = 0; a < num_rods; ++a) {
        const auto [i, j] = ends[a];
        const Pack3<> tension = rows[a] * u[a];
        (points[i] - inverse_mass[i] * tension).write(&points[i]);
        (points[j] + inverse_mass[j] * tension).write(&points[j]);
        const Pack<> part = inverse_factor * rows[a] * rods[a].inverse_length;
        Pack<>& mu = series[a * stride + row].mu;
        mu = is_first ? part : mu + part;
      }
      if (!is_last) return find_right_side();
      for (std::size_t a = 0; a < num_rods; ++a) distance(a).write(&series[a * stride + row + 2].a);
    });
  }
};

/// Computes the terms that are needed, and sets the others to 0. Returns the longest step for which islands with fewer
/// terms serve.
double BatchSeries::expand(const EqualIslands::Batch& batch, std::span<double* const> coefficients,
                           const double* lambda, int passes, const NeededTerms& needed,
                           std::span<std::uint8_t> last_term, Room* room) const {
  const auto& [topology, schedule] = batch.structure();
  const std::size_t stride = coefficients.size() | 1;
  const Lanes lanes{topology.rods.data(),
                    batch.offsets,
                    batch.inverse_mass,
                    batch.num_points,
                    batch.num_rods,
                    batch.num_points + batch.num_supports,
                    stride,
                    room->rods.data(),
                    room->u.data(),
                    room->series.data(),
                    room->points.data(),
                    room->rows.data(),
                    room->weights.data()};
  Terms terms(needed);
  for (std::size_t p = 0; p < batch.num_points && terms.is_counting(); ++p) {
    for (std::size_t lane = 0; lane < num_lanes; ++lane)
      terms.read_atol(needed, batch.first_point[lane] + static_cast<Index>(p), lane, &lanes.weights[p]);
  }
  for (std::size_t k = 0; k <= 2; ++k) {
    batches::read_points(batch, coefficients[k], lanes.points);
    batches::read_supports(batch, coefficients[k], lanes.points);
    lanes.take_coefficient(k);
    if (k == 0 && terms.is_counting()) lanes.weigh_positions(terms);
    if (k == 1 && terms.is_counting()) lanes.weigh_velocities(terms);
  }
  batches::read_rows(batch, lambda, lanes.rows);
  lanes.begin();
  Pack<> smallest = Pack<>{} + 1.0;
  eliminate(topology, schedule, batch.inverse_mass, lanes.u, batch.factor, &smallest);
  const int order = static_cast<int>(coefficients.size()) - 1;
  int reached = 2;
  for (bool are_enough = false; !are_enough && reached < order;) {
    const int k = reached++ - 1;
    lanes.begin_order(k);
    for (int pass = 0; pass < passes; ++pass) {
      solve_negative(schedule, batch.factor, lanes.rows, lanes.rows);
      lanes.add(k, pass == 0, pass + 1 == passes);
    }
    batches::write_points(batch, lanes.points, coefficients[reached]);
    are_enough = terms.is_counting() && terms.note(reached, lanes.largest());
  }
  double longest = any_length;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const FoundTerms found = terms.found(lane, order);
    longest = std::min(longest, found.longest);
    const auto first = static_cast<std::size_t>(batch.first_point[lane]);
    end_series(found, reached, first, first + batch.num_points, coefficients, last_term);
  }
  return longest;
}

double BatchSeries::expand(const Parallel& parallel, std::span<double* const> coefficients, const double* lambda,
                           int passes, const NeededTerms& needed, std::span<std::uint8_t> last_term) {
  rooms_.resize(static_cast<std::size_t>(parallel.threads()));
  std::size_t most_rods = 0, most_places = 0;
  for (const EqualIslands& islands : equal_islands_) {
    most_rods = std::max(most_rods, islands.topology.rods.size());
    most_places =
        std::max(most_places, static_cast<std::size_t>(islands.topology.num_points + islands.topology.num_supports));
  }
  for (Room& room : rooms_) {
    room.rods.resize(most_rods);
    room.u.resize(most_rods);
    room.series.resize(most_rods * (coefficients.size() | 1));
    room.points.resize(most_places);
    room.weights.resize(most_places);
    room.rows.resize(most_rods);
  }
  longest_.assign(batches_.size(), 0.0);
  // A task is some batches, since threads take one after the other.
  constexpr std::size_t of_task = 8;
  parallel.for_tasks((batches_.size() + of_task - 1) / of_task, [&](std::size_t task, std::size_t thread) {
    for (std::size_t b = of_task * task; b < std::min(of_task * (task + 1), batches_.size()); ++b) {
      const EqualIslands::Batch batch = equal_islands_[batches_[b].islands].batch(batches_[b].number);
      longest_[b] = expand(batch, coefficients, lambda, passes, needed, last_term, &rooms_[thread]);
    }
  });
  return std::ranges::min(longest_);
}

}  // namespace tanor::detail
