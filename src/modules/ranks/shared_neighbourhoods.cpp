#include "ranks/shared_neighbourhoods.hpp"

#include <algorithm>
#include <limits>
#include <map>

#include "system/members.hpp"
#include "system/neighbourhoods.hpp"

namespace tanor::detail {

SharedNeighbourhoods::SharedNeighbourhoods(Workspace& work, const Part& part)
    : ranks_(*part.ranks), num_shared_(part.num_shared_neighbourhoods) {
  measure_lengths(work, part);
  const Model& model = work.model();
  std::map<std::size_t, std::size_t> shared;
  for (std::size_t i = 0; i < model.num_moving(); ++i) {
    const Index of_all = part.shared_neighbourhood[static_cast<std::size_t>(model.numbering.user_point[i])];
    if (of_all >= 0) shared[work.scales.of_point(i)] = static_cast<std::size_t>(of_all);
  }
  for (const auto& [here, of_all] : shared) shared_.push_back({here, of_all});
}

/// Gives them the length of all their points together.
void SharedNeighbourhoods::measure_lengths(Workspace& work, const Part& part) {
  constexpr double far = -std::numeric_limits<double>::max();
  std::vector<double> ends(6 * num_shared_, far);  // largest r and largest -r
  const Model& model = work.model();
  const System& system = model.system;
  const auto shared_of = [&](Index point) { return part.shared_neighbourhood[static_cast<std::size_t>(point)]; };
  const auto include = [&](Index neighbourhood, std::size_t point) {
    double* const own = ends.data() + 6 * static_cast<std::size_t>(neighbourhood);
    for (std::size_t c = 0; c < 3; ++c) {
      own[c] = std::max(own[c], system.positions[3 * point + c]);
      own[3 + c] = std::max(own[3 + c], -system.positions[3 * point + c]);
    }
  };
  for (std::size_t i = 0; i < system.num_points(); ++i)
    if (shared_of(static_cast<Index>(i)) >= 0) include(shared_of(static_cast<Index>(i)), i);
  // Supports belong to no neighbourhood, but hold those that do.
  for_each_member(system, [&](std::span<const Index> points, int) {
    const auto shared = std::ranges::max(points, {}, shared_of);
    for (const Index point : points)
      if (shared_of(shared) >= 0) include(shared_of(shared), static_cast<std::size_t>(point));
  });
  ranks_.find_largest(ends);
  Neighbourhoods all = find_neighbourhoods(system, work.time());
  for (std::size_t i = 0; i < system.num_points(); ++i) {
    const Index own = shared_of(static_cast<Index>(i));
    if (own < 0 || all.of_point[i] < 0) continue;
    const double* const box = ends.data() + 6 * static_cast<std::size_t>(own);
    all.length[static_cast<std::size_t>(all.of_point[i])] =
        norm(Vec3{box[0] + box[3], box[1] + box[4], box[2] + box[5]});
  }
  work.scales = Scales(all, model.numbering, model.incidences, model.scene_size);
  work.scales.stand_beside_others();
}

void SharedNeighbourhoods::find_largest(std::span<double> of_neighbourhoods) const {
  std::vector<double> largest(num_shared_, std::numeric_limits<double>::lowest());
  for (const auto& [here, of_all] : shared_) largest[of_all] = std::max(largest[of_all], of_neighbourhoods[here]);
  ranks_.find_largest(largest);
  for (const auto& [here, of_all] : shared_) of_neighbourhoods[here] = largest[of_all];
}

}  // namespace tanor::detail
