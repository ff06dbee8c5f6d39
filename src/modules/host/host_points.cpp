#include "host/host_points.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/memory.hpp"
#include "host/point_address.hpp"

namespace tanor::detail {

std::vector<Index> HostPoints::list_supports() const {
  std::vector<Index> result;
  std::ranges::copy_if(of_host, std::back_inserter(result), [&](Index point) { return is_support(point); });
  return result;
}

void HostPoints::keep(std::span<const Index> numbers) {
  host_point.assign(size(), -1);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] >= 0) host_point[static_cast<std::size_t>(numbers[i])] = static_cast<Index>(i);
  }
}

std::vector<Index> HostPoints::admit(std::vector<Index> numbers, std::span<const double> masses) {
  std::vector<Index> result;
  auto free = host_point.begin();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] >= 0) continue;
    const auto place = std::find(free, host_point.end(), -1);
    numbers[i] = static_cast<Index>(place - host_point.begin());
    const auto point = static_cast<std::size_t>(numbers[i]);
    if (place == host_point.end()) {
      host_point.push_back(-1);
      mass.push_back(0.0);
      positions.resize(positions.size() + 3);
    }
    host_point[point] = static_cast<Index>(i);
    free = host_point.begin() + numbers[i];
    mass[point] = masses[i];
    result.push_back(numbers[i]);
  }
  of_host = std::move(numbers);
  return result;
}

HostPoints HostPoints::renamed(const std::vector<Index>& numbers, std::size_t count) const {
  HostPoints result{numbers, std::vector<Index>(count, -1), std::vector<double>(count), std::vector<double>(3 * count),
                    cell};
  if (count < numbers.size()) Memory::refuse();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto to = static_cast<std::size_t>(numbers[i]), from = static_cast<std::size_t>(of_host[i]);
    if (numbers[i] < 0 || to >= count || result.host_point[to] >= 0) Memory::refuse();
    result.host_point[to] = static_cast<Index>(i);
    result.mass[to] = mass[from];
    std::copy_n(&positions[3 * from], 3, &result.positions[3 * to]);
  }
  return result;
}

System HostPoints::make_system(std::span<const Index> numbers) const {
  System system;
  Support supports{"supports", {}, {}};
  for (const Index point : numbers) {
    if (is_support(point)) supports.points.push_back(static_cast<Index>(system.masses.size()));
    system.masses.push_back(is_support(point) ? 1.0 : mass[static_cast<std::size_t>(point)]);
    const auto position = positions.begin() + 3 * static_cast<std::ptrdiff_t>(point);
    system.positions.insert(system.positions.end(), position, position + 3);
  }
  if (!supports.points.empty()) system.supports.push_back(std::move(supports));
  return system;
}

void copy_points(const ConstPointArray& from, std::span<const Index> number, double* to) {
  for (std::size_t i = 0; i < number.size(); ++i)
    std::ranges::copy(read_point(from, i), to + 3 * static_cast<std::size_t>(number[i]));
}

}  // namespace tanor::detail
