#include "host/host_configuration.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tanor {

void HostConfiguration::set_images(std::unique_ptr<PeriodicImages> given) {
  images = std::move(given);
  host.resize(r.size());
}

bool HostConfiguration::find(const ConstPointArray& positions, double t, const PeriodicCell* of_positions,
                             IncomingPoints* incoming) {
  was_called = true;
  bool is_elsewhere = transfer.differ(positions, images ? host.data() : r.data());
  if (!images) {
    if (is_elsewhere) incoming->copy(positions, r.data());
  } else if (is_elsewhere || (of_positions != nullptr && *of_positions != cell)) {
    is_elsewhere = true;
    transfer.gather(positions, host.data());
    cell = of_positions != nullptr ? *of_positions : images->cell();
    images->unwrap(work.model().parallel, Lattice(cell), host.data(), r.data());
  }
  const bool is_other_time = t != std::exchange(time, t) && work.constraints.depends_on_time();
  stands = stands && !is_elsewhere && !is_other_time && linearization.factor().is_fresh();
  return stands;
}

Outcome HostConfiguration::stand_at(const ConstPointArray& positions, double t, const PeriodicCell* of_positions,
                                    IncomingPoints* incoming) {
  if (find(positions, t, of_positions, incoming)) {
    bring(work.model().parallel, incoming, 0, work.model().num_points());
    return {};
  }
  Outcome outcome = linearization.update(t, r.data(), incoming);
  stands = outcome.ok();
  const auto is_finite = [](double x) { return std::isfinite(x); };
  if (!stands && !std::ranges::all_of(r, is_finite)) return work.model().not_finite(t);
  return outcome;
}

void MovedPositions::gather(const ConstPointArray& positions) {
  if (!place.images) return place.transfer.gather(positions, r.data());
  before.resize(r.size());
  place.transfer.gather(positions, before.data());
  place.images->unwrap(place.work.model().parallel, place.images->lattice(), before.data(), r.data());
  before = r;
}

void MovedPositions::follow(const ConstPointArray& positions, IncomingPoints* incoming) {
  if (!place.images) return incoming->copy(positions, r.data());
  place.transfer.gather(positions, r.data());
  place.images->follow(place.work.model().parallel, Lattice(place.cell), place.r.data(), r.data());
  before = r;
}

double MovedPositions::scatter(const PointArray& positions) {
  const Model& model = place.work.model();
  if (!place.images) return place.transfer.scatter(r.data(), model.num_moving(), positions);
  model.parallel.for_ranges(before.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) before[k] = r[k] - before[k];
  });
  return place.transfer.add(before.data(), model.num_moving(), positions);
}

}  // namespace tanor
