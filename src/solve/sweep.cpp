#include "solve/sweep.hpp"

#include <tanor/error.hpp>

#include <algorithm>
#include <iterator>
#include <numeric>

#include "solve/bundle_sweep.hpp"
#include "solve/general_sweep.hpp"
#include "solve/mixed_sweep.hpp"
#include "solve/path_sweep.hpp"
#include "solve/point_sweep.hpp"
#include "solve/projecting_sweep.hpp"
#include "solve/tree_sweep.hpp"

namespace tanor {

namespace {

const char* obstacle_to_all(const Constraints& constraints, const Numbering& numbering) {
  if (numbering.num_rows() == 0) return "there are no constraints";
  if (numbering.first_idle_row() < numbering.num_rows()) return "some constraints join supports alone";
  if (constraints.tangents().size() > 0) return "contacts with friction have rows that come and go";
  return nullptr;
}

std::size_t count_rows(const Numbering& numbering, const std::vector<Index>& islands) {
  std::size_t result = 0;
  for (const Index island : islands) {
    const Index* const start = numbering.island_start.data() + island;
    result += static_cast<std::size_t>(start[1] - start[0]);
  }
  return result;
}

}  // namespace

std::unique_ptr<Sweep> make_sweep(const Constraints& constraints, const ReactionGather& gather,
                                  std::span<const Incidence> incidences, const Numbering& numbering,
                                  std::span<const double> inverse_mass, const SolverOptions& wanted) {
  const bool is_forced = wanted.way != Way::Auto;
  const auto refuse = [&](const std::string& why) -> std::unique_ptr<Sweep> {
    if (is_forced) throw InputError("/solver/way", "it does not serve this system: " + why);
    return nullptr;
  };
  // Lanes and chunks would stay nearly empty (bench/rivals, the pendulum: 0.27 ms against 0.35).
  constexpr std::size_t few_rows = 8;
  if (wanted.way == Way::General || (!is_forced && numbering.num_rows() < few_rows)) return nullptr;
  if (wanted.ordering != Ordering::Auto) return refuse("an ordering is asked for, which belongs to the general way");
  if (const char* obstacle = obstacle_to_all(constraints, numbering)) return refuse(obstacle);

  constexpr double most_left = 0.5;  // of all rows

  // Each way takes the islands that it serves.
  struct Part {
    std::unique_ptr<Sweep> sweep;
    std::vector<Index> islands;
  };
  std::vector<Part> parts;
  std::vector<Index> islands(numbering.num_islands());
  std::iota(islands.begin(), islands.end(), 0);
  const auto may_be = [&](Way way) { return wanted.way == Way::Auto || wanted.way == way; };
  const auto take = [&](const auto& make) {
    std::vector<Index> before = islands, taken;
    std::unique_ptr<Sweep> sweep = make();
    if (sweep == nullptr) return;
    std::ranges::set_difference(before, islands, std::back_inserter(taken));
    parts.push_back({std::move(sweep), std::move(taken)});
  };
  if (may_be(Way::ClosedForm)) take([&] { return PointSweep::make(constraints, numbering, inverse_mass, &islands); });
  if (may_be(Way::Bundles)) {
    take([&] { return BundleSweep::make(constraints, numbering, inverse_mass, wanted.threads, is_forced, &islands); });
  }
  if (may_be(Way::Paths)) take([&] { return PathSweep::make(constraints, numbering, inverse_mass, &islands); });
  if (may_be(Way::Trees)) take([&] { return TreeSweep::make(constraints, numbering, inverse_mass, &islands); });
  const auto make_group = [&](const std::vector<Index>& of_part) {
    return IslandGroup(constraints, gather, incidences, numbering, inverse_mass, of_part);
  };
  if (!islands.empty()) {
    const auto num_left = static_cast<double>(count_rows(numbering, islands));
    if (is_forced || num_left > most_left * static_cast<double>(numbering.num_rows()))
      return refuse("some islands have another structure");
    parts.push_back({std::make_unique<GeneralSweep>(make_group(islands), incidences), islands});
  }
  if (parts.size() == 1) return std::move(parts.front().sweep);
  std::vector<std::unique_ptr<Sweep>> sweeps;
  for (auto& [sweep, of_part] : parts) {
    const bool projects = sweep->projects();
    sweeps.push_back(projects ? std::move(sweep)
                              : std::make_unique<ProjectingSweep>(std::move(sweep), make_group(of_part)));
  }
  return std::make_unique<MixedSweep>(std::move(sweeps));
}

}  // namespace tanor
