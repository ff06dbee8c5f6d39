#include "kinds/energy_loop.hpp"

#include <algorithm>

#include "base/instruction_sets.hpp"

namespace tanor::detail {

namespace {

/// Loads column i of eight members' points.
[[gnu::always_inline]] inline Pack3<> load_column(const EnergyRange& range, std::size_t i, std::size_t first) {
  const Index* const points = range.points + i * range.stride + first;
  Pack3<> column;
  if (range.in_a_row[(i * range.stride + first) / num_lanes] != 0) {
    load_points(range.r + 3 * static_cast<std::size_t>(points[0]), &column.x, &column.y, &column.z);
  } else {
    for (std::size_t lane = 0; lane < num_lanes; ++lane) set_lane(&column, lane, load(range.r, points[lane]));
  }
  return column;
}

[[gnu::always_inline]] inline void write_forces(const Pack3<>& gradient, const EnergyRange& range, std::size_t i,
                                                std::size_t first) {
  double* const to = range.forces + 3 * (i * range.size + first);
  if (first + num_lanes <= range.last) {
    store_points(-gradient.x, -gradient.y, -gradient.z, to);
    return;
  }
  for (std::size_t lane = 0; first + lane < range.last; ++lane)
    store(to, lane, {-gradient.x[lane], -gradient.y[lane], -gradient.z[lane]});
}

/// Runs the kernel on eight members at a time. A member reads p points and writes p forces, with some 100 flops.
template <bool with_energy, class Kernel>
[[gnu::always_inline]] inline void run_lanes(const Kernel& kernel, const EnergyRange& range) {
  constexpr std::size_t p = Kernel::num_points;
  for (std::size_t first = range.first; first < range.last; first += num_lanes) {
    Pack3<> r[p];
    Pack<> numbers[Kernel::num_numbers];
    for (std::size_t i = 0; i < p; ++i) r[i] = load_column(range, i, first);
    for (std::size_t i = 0; i < Kernel::num_numbers; ++i)
      numbers[i] = pack_at(range.numbers + i * range.stride + first);
    const EnergyAndGradient<p> found = kernel.template run<with_energy>(r, numbers);
    for (std::size_t i = 0; i < p && range.forces != nullptr; ++i) write_forces(found.gradient[i], range, i, first);
    for (std::size_t lane = 0; with_energy && lane < num_lanes && first + lane < range.last; ++lane)
      range.energies[first + lane] = found.energy[lane];
  }
}

template <class Group>
void run(const void* law, const EnergyRange& range) {
  const auto& kernel = *static_cast<const EnergyKernel<Group>*>(law);
  dispatch([&kernel, &range] {
    range.energies != nullptr ? run_lanes<true>(kernel, range) : run_lanes<false>(kernel, range);
  });
}

template <class Group>
EnergyLoop make_loop(const Group& group) {
  return {std::make_shared<const EnergyKernel<Group>>(group), EnergyKernel<Group>::num_numbers, run<Group>};
}

}  // namespace

EnergyLoop make_energy_loop(const Bonds& bonds) {
  return make_loop(bonds);
}
EnergyLoop make_energy_loop(const Bendings& bendings) {
  return make_loop(bendings);
}
EnergyLoop make_energy_loop(const Torsions& torsions) {
  return make_loop(torsions);
}

}  // namespace tanor::detail
