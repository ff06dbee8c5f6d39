#include "host/host_input.hpp"

#include <limits>
#include <utility>

namespace tanor {

System make_system(std::span<const double> masses, std::vector<Constraint> constraints, const ConstPointArray& at) {
  if (!at) throw InputError("", "positions are missing");
  check_array(at, masses.size(), 3, "positions");
  System system;
  system.masses.assign(masses.begin(), masses.end());
  system.constraints = std::move(constraints);
  const std::ptrdiff_t stride = at.stride != 0 ? at.stride : static_cast<std::ptrdiff_t>(3 * sizeof(double));
  const auto* const bytes = reinterpret_cast<const std::byte*>(at.data);
  Support supports{"supports", {}, {}};
  for (std::size_t i = 0; i < masses.size(); ++i) {
    const std::ptrdiff_t number = at.index != nullptr ? at.index[i] : static_cast<std::ptrdiff_t>(i);
    const auto* const point = reinterpret_cast<const double*>(bytes + number * stride);
    system.positions.insert(system.positions.end(), point, point + 3);
    if (masses[i] != std::numeric_limits<double>::infinity()) continue;
    supports.points.push_back(static_cast<Index>(i));
    system.masses[i] = 1.0;
  }
  if (!supports.points.empty()) system.supports = {supports};
  return system;
}

}  // namespace tanor
