#include "schur/short_path_series.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/instruction_sets.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail {

namespace {

[[gnu::always_inline]] inline Four load_four(const double* from, Index point) {
  const double* const place = from + 3 * static_cast<std::size_t>(point);
  return Four{place[0], place[1], place[2], 0.0};
}
[[gnu::always_inline]] inline double sum_of_xyz(const Four& a) {
  return a[0] + a[1] + a[2];
}

}  // namespace

ShortPathSeries::ShortPathSeries(const RodRows& rods, const Numbering& numbering, std::span<const double> inverse_mass,
                                 std::vector<Index>* islands)
    : inverse_mass_(inverse_mass) {
  std::erase_if(*islands, [&](Index island) {
    const Index* const start = numbering.island_start.data() + island;
    if (static_cast<std::size_t>(start[1] - start[0]) >= plan::fewest_rods_of_cut_path) return false;
    const std::optional<RodPath> path = find_path(rods.ends, numbering, island);
    if (!path || path->is_ring) return false;
    std::vector<Vec3> offsets;
    for (std::size_t k = 0; !rods.offset.empty() && k < path->num_rows(); ++k) {
      const std::size_t row = static_cast<std::size_t>(path->first_row) + k;
      const bool is_turned = rods.ends[row][0] != path->points[k];
      offsets.push_back(is_turned ? -rods.offset[row] : rods.offset[row]);
    }
    paths_.push_back({*path, std::move(offsets)});
    num_points_ += path->points.size();
    most_rods_ = std::max(most_rods_, path->num_rows());
    return true;
  });
}

/// The expansion of one path.
struct ShortPathSeries::OnePath {
  std::size_t num_rods, stride;
  Rod* rods;
  Point* points;
  Four* series;

  [[gnu::always_inline]] Four& coefficient(std::size_t rod, int k) const {
    return series[rod * stride + static_cast<std::size_t>(k)];
  }
  [[gnu::always_inline]] void take_coefficient(int k) const {
    for (std::size_t i = 0; i < num_rods; ++i) coefficient(i, k) = points[i + 1].r - points[i].r;
  }

  /// Reads r_0, r_1 and r_2 and lambda_0 of the rods, and factorizes S.
  void begin(std::span<double* const> coefficients, const double* lambda, const Vec3* offsets,
             const NeededTerms& needed) const {
    dispatch([own = *this, from = coefficients.data(), lambda, offsets, rtol = needed.step.rtol] {
      const auto weigh = [&](const Four& r, double atol) __attribute__((always_inline)) {
        return 1.0 / (atol * atol + rtol * rtol * sum_of_xyz(r * r));
      };
      for (int k = 0; k <= 2; ++k) {
        for (std::size_t i = 0; i <= own.num_rods; ++i) {
          Point& point = own.points[i];
          point.r = load_four(from[k], point.number);
          if (k == 0) point.of_position = weigh(point.r, point.of_position);
          if (k == 1) point.of_velocity = weigh(point.r, point.of_velocity);
        }
        own.take_coefficient(k);
      }
      for (std::size_t i = 0; i < own.num_rods; ++i) {
        const Four a = own.coefficient(i, 0);
        own.rods[i].u = offsets == nullptr ? a : a + Four{offsets[i].x, offsets[i].y, offsets[i].z, 0.0};
      }
      double below = 0.0, l = 0.0;
      for (std::size_t i = 0; i < own.num_rods; ++i) {
        Rod& rod = own.rods[i];
        const double square = sum_of_xyz(rod.u * rod.u), between = own.points[i + 1].inverse_mass;
        own.take_multiplier(i, 0, lambda[i] / std::sqrt(square));
        rod.inverse_pivot = 1.0 / (square * (own.points[i].inverse_mass + between) - l * below);
        below = i + 1 < own.num_rods ? -between * sum_of_xyz(rod.u * own.rods[i + 1].u) : 0.0;
        rod.l = l = below * rod.inverse_pivot;
      }
    });
  }

  /// Computes order k + 2 and writes it. Returns the largest squares of its ratios.
  TermCounter::Largest advance(int k, int passes, double* to) const {
    return dispatch([own = *this, k, passes, to] {
      const double scale = (k + 1.0) * (k + 2.0);
      own.begin_order(k, 1.0 / scale);
      for (int pass = 0; pass < passes; ++pass) own.solve(k, scale, pass > 0);
      own.take_coefficient(k + 2);
      double position = 0.0, velocity = 0.0, sum = 0.0;
      for (std::size_t i = 0; i <= own.num_rods; ++i) {
        const Point& point = own.points[i];
        const double square = sum_of_xyz(point.r * point.r);
        position = std::max(position, square * point.of_position);
        velocity = std::max(velocity, square * point.of_velocity);
        sum += square;
        if (point.inverse_mass > 0.0) store(to, point.number, {point.r[0], point.r[1], point.r[2]});
      }
      return TermCounter::Largest{Pack<>{position}, Pack<>{velocity}, Pack<>{sum}};
    });
  }

 private:
  [[gnu::always_inline]] void take_multiplier(std::size_t i, int k, double mu) const {
    Four c = coefficient(i, k);
    c[3] = mu;
    coefficient(i, k) = c;
  }
  /// Computes the known terms of r_{k+2} and half_square, see RodSeries::multiply.
  [[gnu::always_inline]] void begin_order(int k, double factor) const {
    const Four nothing{};
    Four before = nothing;
    for (std::size_t i = 0; i < num_rods; ++i) {
      const Four* const c = series + i * stride;
      Four force = nothing, squares = nothing;
      for (int j = 1; j <= k; ++j) force += c[k - j][3] * c[j];
      for (int j = 1; 2 * j < k + 2; ++j) squares += c[j] * c[k + 2 - j];
      if (k % 2 == 0) squares += 0.5 * (c[k / 2 + 1] * c[k / 2 + 1]);
      rods[i].half_square = sum_of_xyz(squares);
      points[i].r = (factor * points[i].inverse_mass) * (before - force);
      before = force;
    }
    points[num_rods].r = (factor * points[num_rods].inverse_mass) * before;
  }
  /// Solves S x = -(half_square + a_0.(r_{i+1} - r_i)), and adds M^-1 K x to r and x to mu_k, or puts it there.
  [[gnu::always_inline]] void solve(int k, double scale, bool is_added) const {
    double y = 0.0, l = 0.0;
    for (std::size_t i = 0; i < num_rods; ++i) {
      Rod& rod = rods[i];
      rod.x = y = -(rod.half_square + sum_of_xyz(rod.u * (points[i + 1].r - points[i].r))) - l * y;
      l = rod.l;
    }
    double x = 0.0;
    Four behind{};
    for (std::size_t i = num_rods; i-- > 0;) {
      const Rod& rod = rods[i];
      x = rod.x * rod.inverse_pivot - rod.l * x;
      const Four tension = x * rod.u;
      points[i + 1].r += points[i + 1].inverse_mass * (tension - behind);
      take_multiplier(i, k, is_added ? coefficient(i, k)[3] + scale * x : scale * x);
      behind = tension;
    }
    points[0].r -= points[0].inverse_mass * behind;
  }
};

double ShortPathSeries::expand(const Parallel& parallel, const LaneExpansion& expansion) {
  const auto& [coefficients, lambda, passes, needed, last_term] = expansion;
  const std::size_t stride = expansion.stride();
  const int order = expansion.order();
  const bool is_counting = expansion.is_counting();
  const Parallel worth(num_points_ < plan::rows_of_lanes_worth_a_thread ? 1 : parallel.threads());
  rooms_.resize(static_cast<std::size_t>(parallel.threads()));
  for (Room& room : rooms_) {
    room.rods.resize(most_rods_);
    room.points.resize(most_rods_ + 1);
    room.series.resize(std::max(room.series.size(), (most_rods_ * stride + 1) / 2));
    room.longest = any_length;
  }
  worth.for_tasks(paths_.size(), [&](std::size_t p, std::size_t thread) {
    Room& room = rooms_[thread];
    const auto& [path, offsets] = paths_[p];
    for (std::size_t i = 0; i <= path.num_rows(); ++i) {
      const Index number = path.points[i];
      const auto [position, velocity] = is_counting ? needed.atol_of(number) : NeededTerms::Errors{};
      room.points[i] = {Four{}, inverse_mass_[static_cast<std::size_t>(number)], position, velocity, number};
    }
    const OnePath own{path.num_rows(), stride, room.rods.data(), room.points.data(),
                      reinterpret_cast<Four*>(room.series.data())};
    own.begin(coefficients, lambda + path.first_row, offsets.empty() ? nullptr : offsets.data(), needed);
    TermCounter terms(needed.step, 1);
    int reached = 2;
    for (bool are_enough = false; !are_enough && reached < order;) {
      const int k = reached++ - 1;
      const TermCounter::Largest largest = own.advance(k, passes, coefficients[reached]);
      are_enough = is_counting && terms.note(reached, largest);
    }
    const FoundTerms found = terms.found(0, order);
    room.longest = std::min(room.longest, found.longest);
    end_series(found, reached, static_cast<std::size_t>(path.first_point), static_cast<std::size_t>(path.end_point),
               coefficients, last_term);
  });
  double longest = any_length;
  for (const Room& room : rooms_) longest = std::min(longest, room.longest);
  return longest;
}

}  // namespace tanor::detail
