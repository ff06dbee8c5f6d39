#include "evaluate/potential_family.hpp"

#include <algorithm>
#include <array>

#include "base/vec3.hpp"

namespace tanor {

namespace {

constexpr std::size_t most_numbers = 3 * static_cast<std::size_t>(PotentialKernel::most_points);

/// body(first, count) for chunks of `series_width` members.
template <class Body>
void for_chunks(const Parallel& parallel, std::size_t size, const Body& body) {
  const std::size_t num_chunks = (size + series_width - 1) / series_width;
  parallel.for_ranges(
      num_chunks,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t chunk = begin; chunk < end; ++chunk) {
          const std::size_t first = chunk * series_width;
          body(first, std::min(series_width, size - first));
        }
      },
      32);
}

}  // namespace

PotentialFamily::PotentialFamily(const EnergyGroup& group, const Numbering& numbering)
    : kernel_(group.kernel),
      p_(static_cast<std::size_t>(group.kernel.num_points)),
      num_constants_(static_cast<std::size_t>(group.kernel.num_constants)),
      constants_(group.constants) {
  if (kernel_.expression) program_ = SeriesProgram(*kernel_.expression, true);
  for (const Index point : group.points) points_.push_back(numbering.inner_point[static_cast<std::size_t>(point)]);
}

void PotentialFamily::run(const Chunk& chunk) const {
  if (kernel_.expression)
    run_program(chunk);
  else
    run_kernel(chunk);
}

void PotentialFamily::run_kernel(const Chunk& chunk) const {
  std::array<double, series_width * most_numbers> r;  // NOLINT: filled before use
  std::array<double, series_width> energies;          // NOLINT
  for (std::size_t i = 0; i < chunk.count * p_; ++i) store(r.data(), i, load(chunk.r, points_[chunk.first * p_ + i]));
  kernel_.evaluate(kernel_.context.get(),
                   {chunk.count, chunk.t, r.data(), constants_.data() + chunk.first * num_constants_, energies.data(),
                    chunk.gradients, chunk.hessians, chunk.rates});
  if (chunk.energies != nullptr) std::copy_n(energies.begin(), chunk.count, chunk.energies);
}

/// The last member stands in the lanes that are left.
SeriesLane* PotentialFamily::load_lanes(const Chunk& chunk, int order) const {
  thread_local std::vector<double> room;  // grows in the first steps only
  room.resize(std::max(room.size(), program_.num_lanes(order) * series_width));
  auto* const lanes = reinterpret_cast<SeriesLane*>(room.data());
  const std::size_t num_variables = program_.num_variables();
  for (std::size_t i = 0; i < num_variables; ++i) {
    SeriesLane* const variable = program_.variable(lanes, order, i);
    for (int k = 1; k <= order; ++k) variable[k] = SeriesLane{};
    for (std::size_t lane = 0; lane < series_width; ++lane) {
      const std::size_t member = chunk.first + std::min(lane, chunk.count - 1);
      if (i < 3 * p_)
        variable[0][lane] = chunk.r[3 * static_cast<std::size_t>(points_[member * p_ + i / 3]) + i % 3];
      else if (i + 1 < num_variables)
        variable[0][lane] = constants_[member * num_constants_ + i - 3 * p_];
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
  if (chunk.energies != nullptr) {
    for (std::size_t lane = 0; lane < chunk.count; ++lane)
      chunk.energies[lane] = program_.result(lanes, order, 0)[0][lane];
  }
  if (chunk.gradients == nullptr && chunk.hessians == nullptr && chunk.rates == nullptr) return;
  const SeriesLane one = SeriesLane{} + 1.0, zero{};
  program_.differentiate(lanes, order, 0, &one);
  for (std::size_t i = 0; i < size && chunk.gradients != nullptr; ++i) {
    for (std::size_t lane = 0; lane < chunk.count; ++lane)
      chunk.gradients[lane * size + i] = program_.adjoint(lanes, order, i)[0][lane];
  }
  for (std::size_t lane = 0; lane < chunk.count && chunk.rates != nullptr; ++lane)
    chunk.rates[lane] = program_.adjoint(lanes, order, program_.num_variables() - 1)[0][lane];
  // Along r + e e_j the gradient grows by the column j of the Hessian.
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

void PotentialFamily::evaluate_forces(const Parallel& parallel, double t, const double* r, double* forces,
                                      double* rates) const {
  const Parallel serial(1);
  for_chunks(kernel_.thread_safe ? parallel : serial, size(), [&](std::size_t first, std::size_t count) {
    double* const f = forces + 3 * p_ * first;
    run({first, count, t, r, nullptr, f, nullptr, depends_on_time() ? rates + first : nullptr});
    for (std::size_t i = 0; i < 3 * p_ * count; ++i) f[i] = -f[i];
  });
}

void PotentialFamily::evaluate_energies(const Parallel& parallel, double t, const double* r, double* energies) const {
  const Parallel serial(1);
  for_chunks(kernel_.thread_safe ? parallel : serial, size(), [&](std::size_t first, std::size_t count) {
    run({first, count, t, r, energies + first, nullptr, nullptr, nullptr});
  });
}

void PotentialFamily::evaluate_stiffness(const Parallel& parallel, double t, const double* r, Block3* blocks) const {
  const Parallel serial(1);
  const std::size_t size_of_member = 3 * p_;
  for_chunks(kernel_.thread_safe ? parallel : serial, size(), [&](std::size_t first, std::size_t count) {
    std::array<double, series_width * most_numbers * most_numbers> hessians;  // NOLINT: filled before use
    run({first, count, t, r, nullptr, nullptr, hessians.data(), nullptr});
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

}  // namespace tanor
