#include "evaluate/potential_family.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/text.hpp"
#include "base/vec3.hpp"

namespace tanor::detail {

namespace {

constexpr std::size_t most_numbers = 3 * static_cast<std::size_t>(PotentialKernel::most_points);
static_assert(series_width == num_lanes);
/// Hand-written laws take some ten microseconds for a thousand tuples. A smaller share is done before a thread has
/// woken.
constexpr std::size_t chunks_worth_a_thread = 1024;

/// Transposes rows [member][column] to columns, each filled up to `stride` with its last entry.
template <class Number>
std::vector<Number> transpose_columns(const std::vector<Number>& rows, std::size_t size, std::size_t stride) {
  const std::size_t width = size > 0 ? rows.size() / size : 0;
  std::vector<Number> columns(width * stride);
  for (std::size_t k = 0; k < columns.size(); ++k)
    columns[k] = rows[std::min(k % stride, size - 1) * width + k / stride];
  return columns;
}

}  // namespace

PotentialFamily::PotentialFamily(EnergyGroup group, const Numbering& numbering)
    : group_(std::move(group)),
      p_(static_cast<std::size_t>(group_.kernel.num_points)),
      num_constants_(static_cast<std::size_t>(group_.kernel.num_constants)),
      size_(group_.points.size() / p_),
      stride_((size_ + series_width - 1) / series_width * series_width),
      points_(transpose_columns(group_.points, size_, stride_)),
      constants_(transpose_columns(group_.constants, size_, stride_)),
      prepared_(transpose_columns(group_.prepared, size_, stride_)) {
  if (group_.kernel.expression) program_ = SeriesProgram(*group_.kernel.expression, true);
  for (Index& point : points_) point = numbering.inner_point[static_cast<std::size_t>(point)];
  for (std::size_t first = 0; first < points_.size(); first += series_width) {
    bool follow = true;
    for (std::size_t lane = 1; lane < series_width; ++lane)
      follow = follow && points_[first + lane] == points_[first] + static_cast<Index>(lane);
    in_a_row_.push_back(follow ? 1 : 0);
  }
}

/// Calls body(first, count) for chunks of `series_width` members.
template <class Body>
void PotentialFamily::for_chunks(const Parallel& parallel, const Body& body) const {
  const Parallel serial(1);
  (group_.kernel.thread_safe ? parallel : serial)
      .for_ranges(
          stride_ / series_width,
          [&](std::size_t begin, std::size_t end) {
            for (std::size_t first = begin * series_width; first < end * series_width; first += series_width)
              body(first, std::min(series_width, size_ - first));
          },
          chunks_worth_a_thread / 8);
}

void PotentialFamily::run(const Chunk& chunk) const {
  group_.kernel.expression ? run_program(chunk) : run_kernel(chunk);
}

void PotentialFamily::run_kernel(const Chunk& chunk) const {
  const PotentialKernel& kernel = group_.kernel;
  std::array<double, series_width * most_numbers> r;  // NOLINT: filled before use
  for (std::size_t n = 0; n < chunk.count * p_; ++n)
    store(r.data(), n, load(chunk.r, point(chunk.first + n / p_, n % p_)));
  kernel.evaluate(kernel.context.get(),
                  {chunk.count, chunk.t, r.data(), group_.constants.data() + chunk.first * num_constants_,
                   chunk.energies, chunk.gradients, chunk.hessians, chunk.rates});
}

SeriesLane* PotentialFamily::load_lanes(const Chunk& chunk, int order) const {
  thread_local std::vector<double> room;  // grows in the first steps only
  room.resize(std::max(room.size(), program_.num_lanes(order) * series_width));
  auto* const lanes = reinterpret_cast<SeriesLane*>(room.data());
  const std::size_t num_variables = program_.num_variables();
  for (std::size_t i = 0; i < num_variables; ++i) {
    SeriesLane* const variable = program_.variable(lanes, order, i);
    for (int k = 1; k <= order; ++k) variable[k] = SeriesLane{};
    for (std::size_t lane = 0; lane < series_width; ++lane) {
      const std::size_t member = chunk.first + lane;
      if (i < 3 * p_)
        variable[0][lane] = chunk.r[3 * static_cast<std::size_t>(point(member, i / 3)) + i % 3];
      else if (i + 1 < num_variables)
        variable[0][lane] = constants_[(i - 3 * p_) * stride_ + member];
      else
        variable[0][lane] = chunk.t;
    }
  }
  return lanes;
}

void PotentialFamily::run_program(const Chunk& chunk) const {
  const int order = chunk.hessians != nullptr ? 1 : 0;
  SeriesLane* const lanes = load_lanes(chunk, order);
  const std::size_t size = 3 * p_;
  program_.evaluate(lanes, order, 0);
  for (std::size_t lane = 0; lane < chunk.count; ++lane)
    chunk.energies[lane] = program_.result(lanes, order, 0)[0][lane];
  if (chunk.gradients == nullptr && chunk.hessians == nullptr && chunk.rates == nullptr) return;
  const SeriesLane one = SeriesLane{} + 1.0, zero{};
  program_.differentiate(lanes, order, 0, &one);
  for (std::size_t i = 0; i < size && chunk.gradients != nullptr; ++i) {
    for (std::size_t lane = 0; lane < chunk.count; ++lane)
      chunk.gradients[lane * size + i] = program_.adjoint(lanes, order, i)[0][lane];
  }
  for (std::size_t lane = 0; lane < chunk.count && chunk.rates != nullptr; ++lane)
    chunk.rates[lane] = program_.adjoint(lanes, order, program_.num_variables() - 1)[0][lane];
  // The gradient grows along r + e e_j by the column j of the Hessian.
  for (std::size_t j = 0; j < size && chunk.hessians != nullptr; ++j) {
    program_.variable(lanes, order, j)[1] = one;
    program_.evaluate(lanes, order, 1);
    program_.differentiate(lanes, order, 1, &zero);
    program_.variable(lanes, order, j)[1] = zero;
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t lane = 0; lane < chunk.count; ++lane)
        chunk.hessians[(lane * size + i) * size + j] = program_.adjoint(lanes, order, i)[1][lane];
    }
  }
}

void PotentialFamily::run_by_hand(const Parallel& parallel, const double* r, double* forces, double* energies) const {
  parallel.for_ranges(
      stride_ / series_width,
      [&](std::size_t begin, std::size_t end) {
        group_.by_hand.run(group_.by_hand.law.get(),
                           {begin * series_width, std::min(end * series_width, size_), stride_, r, points_.data(),
                            in_a_row_.data(), prepared_.data(), forces, energies, size_});
      },
      chunks_worth_a_thread);
}

void PotentialFamily::evaluate_forces(const Parallel& parallel, double t, const double* r, double* forces,
                                      double* rates) const {
  if (group_.by_hand) return run_by_hand(parallel, r, forces, nullptr);
  for_chunks(parallel, [&](std::size_t first, std::size_t count) {
    std::array<double, series_width> energies;                  // NOLINT: filled before use
    std::array<double, series_width * most_numbers> gradients;  // NOLINT
    run({first, count, t, r, energies.data(), gradients.data(), nullptr, depends_on_time() ? rates + first : nullptr});
    for (std::size_t lane = 0; lane < count; ++lane) {
      const double sign = std::isfinite(energies[lane]) ? -1.0 : std::numeric_limits<double>::quiet_NaN();
      for (std::size_t i = 0; i < p_; ++i)
        store(forces, i * size_ + first + lane, sign * load(gradients.data(), lane * p_ + i));
    }
  });
}

void PotentialFamily::evaluate_energies(const Parallel& parallel, double t, const double* r, double* energies) const {
  if (group_.by_hand) return run_by_hand(parallel, r, nullptr, energies);
  for_chunks(parallel, [&](std::size_t first, std::size_t count) {
    run({first, count, t, r, energies + first, nullptr, nullptr, nullptr});
  });
}

void PotentialFamily::evaluate_stiffness(const Parallel& parallel, double t, const double* r, Block3* blocks) const {
  const std::size_t size_of_member = 3 * p_;
  for_chunks(parallel, [&](std::size_t first, std::size_t count) {
    std::array<double, series_width> energies;                                // NOLINT: filled before use
    std::array<double, series_width * most_numbers * most_numbers> hessians;  // NOLINT
    run({first, count, t, r, energies.data(), nullptr, hessians.data(), nullptr});
    for (std::size_t k = 0; k < count; ++k) {
      for (std::size_t ij = 0; ij < p_ * p_; ++ij) {
        const std::size_t i = ij / p_, j = ij % p_;
        Block3& block = blocks[(first + k) * p_ * p_ + ij];
        for (std::size_t entry = 0; entry < 9; ++entry)
          block.entries[entry] =
              -hessians[(k * size_of_member + 3 * i + entry / 3) * size_of_member + 3 * j + entry % 3];
      }
    }
  });
}

std::string PotentialFamily::find_undefined(const Parallel& parallel, double t, const double* r) const {
  std::vector<double> forces(3 * p_ * size_), rates(size_), energies(size_);
  evaluate_forces(parallel, t, r, forces.data(), rates.data());
  evaluate_energies(parallel, t, r, energies.data());
  for (std::size_t k = 0; k < size_; ++k) {
    double sum = energies[k];
    std::vector<double> places(3 * p_);
    for (std::size_t i = 0; i < p_; ++i) {
      const Vec3 force = load(forces.data(), i * size_ + k);
      sum += force.x + force.y + force.z;
      store(places.data(), i, load(r, point(k, i)));
    }
    if (std::isfinite(sum)) continue;
    const bool are_places = std::ranges::all_of(places, [](double x) { return std::isfinite(x); });
    if (!are_places) return {};
    std::string reason;
    if (group_.complaint) reason = group_.complaint(places.data(), group_.constants.data() + k * num_constants_);
    if (reason.empty()) reason = "the energy or its gradient is not finite";
    return group_.name + ": " + text(std::span(group_.points).subspan(k * p_, p_)) + ": " + reason;
  }
  return {};
}

}  // namespace tanor::detail
