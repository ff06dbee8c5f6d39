#include "solve/sweep.hpp"

#include <tanor/error.hpp>

#include <numeric>

#include "solve/bundle_sweep.hpp"
#include "solve/mixed_sweep.hpp"
#include "solve/path_sweep.hpp"
#include "solve/point_sweep.hpp"
#include "solve/tree_sweep.hpp"

namespace tanor {

namespace {

const char* obstacle_to_all(const Constraints& constraints, const Numbering& numbering) {
  if (numbering.num_rows() == 0) return "there are no constraints";
  if (numbering.first_idle_row() < numbering.num_rows()) return "some constraints join supports alone";
  if (constraints.tangents().size() > 0) return "contacts with friction have rows that come and go";
  return nullptr;
}

}  // namespace

std::unique_ptr<Sweep> make_sweep(const Constraints& constraints, const Numbering& numbering,
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

  // Each way takes the islands that it serves.
  std::vector<Index> islands(numbering.num_islands());
  std::iota(islands.begin(), islands.end(), 0);
  std::vector<std::unique_ptr<Sweep>> sweeps;
  const auto may_be = [&](Way way) { return wanted.way == Way::Auto || wanted.way == way; };
  const auto take = [&](std::unique_ptr<Sweep> sweep) {
    if (sweep != nullptr) sweeps.push_back(std::move(sweep));
  };
  if (may_be(Way::ClosedForm)) take(PointSweep::make(constraints, numbering, inverse_mass, &islands));
  if (may_be(Way::Bundles))
    take(BundleSweep::make(constraints, numbering, inverse_mass, wanted.threads, is_forced, &islands));
  if (may_be(Way::Paths)) take(PathSweep::make(constraints, numbering, inverse_mass, &islands));
  if (may_be(Way::Trees)) take(TreeSweep::make(constraints, numbering, inverse_mass, &islands));
  if (!islands.empty()) return refuse("some islands have another structure");
  if (sweeps.size() == 1) return std::move(sweeps.front());
  return std::make_unique<MixedSweep>(std::move(sweeps));
}

}  // namespace tanor
