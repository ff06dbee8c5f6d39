/// Reads a motion of one point in a file that ends in TANOR_EXTENSION (.csv or .npy), as `tanor forces` does: a table
/// of
/// numbers, a spline through its rows, the forces at its samples.

#include <algorithm>
#include <vector>

#include <tanor/inverse_dynamics.hpp>

#include "scene/number_table.hpp"

#include "target.hpp"

namespace {

using namespace tanor;

void find_forces(const scene::NumberTable& rows) {
  std::vector<double> times, values;
  for (std::size_t k = 0; k < rows.rows; ++k) {
    times.push_back(rows(k, 0));
    for (std::size_t j = 1; j < rows.columns; ++j) values.push_back(rows(k, j));
  }
  const MotionTable motion(std::move(times), std::move(values), rows.columns - 1);
  System system;
  system.positions = {1.0, 0.0, 0.0};
  system.masses = {2.0};
  system.constraints.emplace_back(Spheres{.name = "sphere", .points = {0}, .center = {}, .radius = 1.0});
  InverseDynamics problem(system);
  if (motion.num_columns() != 3) return;
  for (std::size_t k = 0; k < std::min<std::size_t>(motion.times().size(), 8); ++k) {
    const double t = motion.times()[k];
    (void)problem.evaluate(t, motion.at(t));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile file(TANOR_EXTENSION);
  file.write(fuzz::text_of(data, size));
  fuzz::takes([&] { find_forces(scene::read_number_table(file.path())); });
  return 0;
}
