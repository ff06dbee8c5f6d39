#include "host/host_configuration.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tanor::detail {

void HostConfiguration::set_images(std::unique_ptr<PeriodicImages> given) {
  images = std::move(given);
  host.resize(r.size());
  cell_of_offsets = images->cell();
}

void HostConfiguration::set_offsets(const PeriodicCell& of_cell) {
  if (!images || !images->close_ways() || of_cell == cell_of_offsets) return;
  cell_of_offsets = of_cell;
  linearization.set_offsets(images->find_offsets(Lattice(of_cell)));
}

std::span<const Constraints::RowOffset> HostConfiguration::offset_changes() {
  if (!images || cell == images->cell()) return {};
  const Lattice before(cell);
  return images->find_offsets(images->lattice(), &before);
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
  set_offsets(cell);
  const bool is_other_time = t != std::exchange(time, t) && work.constraints.depends_on_time();
  stands = stands && !is_elsewhere && !is_other_time && linearization.is_fresh();
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

}  // namespace tanor::detail
