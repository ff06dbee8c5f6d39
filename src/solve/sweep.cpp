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

/// What `make_sweep` is given.
struct Given {
  const Constraints& constraints;
  const ReactionGather& gather;
  std::span<const Incidence> incidences;
  const Numbering& numbering;
  std::span<const double> inverse_mass;

  IslandGroup group(const std::vector<Index>& islands) const {
    return {constraints, gather, incidences, numbering, inverse_mass, islands};
  }
};

struct Part {
  std::unique_ptr<Sweep> sweep;
  std::vector<Index> islands;
};

const char* obstacle_to_all(const Constraints& constraints, const Numbering& numbering) {
  if (numbering.num_rows() == 0) return "there are no constraints";
  if (numbering.first_idle_row() < numbering.num_rows()) return "some constraints join supports alone";
  if (constraints.tangents().size() > 0) return "contacts with friction have rows that come and go";
  return nullptr;
}

/// Each way takes the islands that it serves out of `islands`.
std::vector<Part> take_short_islands(const Given& given, const SolverOptions& wanted, std::vector<Index>* islands) {
  const auto& constraints = given.constraints;
  const auto& numbering = given.numbering;
  const auto& inverse_mass = given.inverse_mass;
  std::vector<Part> parts;
  const auto take = [&](Way way, const auto& make) {
    if (wanted.way != Way::Auto && wanted.way != way) return;
    const std::vector<Index> before = *islands;
    std::unique_ptr<Sweep> sweep = make();
    if (sweep == nullptr) return;
    parts.push_back({std::move(sweep), {}});
    std::ranges::set_difference(before, *islands, std::back_inserter(parts.back().islands));
  };
  const bool eagerly = wanted.way != Way::Auto;
  take(Way::ClosedForm, [&] { return PointSweep::make(constraints, numbering, inverse_mass, islands); });
  take(Way::Bundles,
       [&] { return BundleSweep::make(constraints, numbering, inverse_mass, wanted.threads, eagerly, islands); });
  take(Way::Paths, [&] { return PathSweep::make(constraints, numbering, inverse_mass, islands); });
  take(Way::Trees, [&] { return TreeSweep::make(constraints, numbering, inverse_mass, islands); });
  return parts;
}

/// Sparse factors of the islands that are left over; null where they are too much of the system. Then all of it is the
/// general way's, which goes on with old factors inside steps (see Reuse). Clusters beside a net of 100 x 100: steps of
/// dop853 take as long on both where the net's factor takes 300 products for each row of a cluster, half as long on the
/// general way at 3000; with less of a net all methods gain from the mixture, up to 2.7 times. A row left over seldom
/// takes fewer than 100 products, so no analysis is made in vain where there are too many.
std::unique_ptr<Sweep> make_general_part(const Given& given, const std::vector<Index>& left) {
  constexpr double most_rows = 3.0, most_products = 300.0;  // for each row that a short way serves
  IslandGroup group = given.group(left);
  const auto num_left = static_cast<double>(group.rows.size());
  const double num_short = static_cast<double>(given.numbering.num_rows()) - num_left;
  if (num_left > most_rows * num_short) return nullptr;
  auto result = std::make_unique<GeneralSweep>(std::move(group), given.incidences);
  if (result->factor().products > most_products * num_short) return nullptr;
  return result;
}

/// Of several parts each has to project.
std::unique_ptr<Sweep> join(const Given& given, std::vector<Part> parts) {
  if (parts.size() == 1) return std::move(parts.front().sweep);
  std::vector<std::unique_ptr<Sweep>> sweeps;
  for (auto& [sweep, islands] : parts) {
    if (!sweep->projects()) sweep = std::make_unique<ProjectingSweep>(std::move(sweep), given.group(islands));
    sweeps.push_back(std::move(sweep));
  }
  return std::make_unique<MixedSweep>(std::move(sweeps));
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
  // Lanes and chunks would stay nearly empty (bench/rivals, the pendulum).
  constexpr std::size_t few_rows = 8;
  if (wanted.way == Way::General || (!is_forced && numbering.num_rows() < few_rows)) return nullptr;
  if (wanted.ordering != Ordering::Auto) return refuse("an ordering is asked for, which belongs to the general way");
  if (const char* obstacle = obstacle_to_all(constraints, numbering)) return refuse(obstacle);

  const Given given{constraints, gather, incidences, numbering, inverse_mass};
  std::vector<Index> left(numbering.num_islands());
  std::iota(left.begin(), left.end(), 0);
  std::vector<Part> parts = take_short_islands(given, wanted, &left);
  if (!left.empty()) {
    if (is_forced) return refuse("some islands have another structure");
    std::unique_ptr<Sweep> general = parts.empty() ? nullptr : make_general_part(given, left);
    if (general == nullptr) return nullptr;
    parts.push_back({std::move(general), left});
  }
  return join(given, std::move(parts));
}

}  // namespace tanor
