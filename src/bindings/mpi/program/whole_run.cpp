#include "mpi/program/whole_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <string>

#include "base/disjoint_sets.hpp"
#include "mpi/program/together.hpp"
#include "report/shared_parts.hpp"
#include "system/members.hpp"

namespace tanor::mpi {
using namespace detail;

namespace {

constexpr double least_scale = std::numeric_limits<double>::min();  // for accelerations that are all 0

/// Replaces each of these numbers by that of all ranks.
template <class... Numbers>
void combine(MpiRanks& ranks, void (MpiRanks::*how)(std::span<double>), Numbers&... numbers) {
  std::array<double, sizeof...(numbers)> all{static_cast<double>(numbers)...};
  (ranks.*how)(all);
  std::size_t k = 0;
  ((numbers = static_cast<Numbers>(all[k++])), ...);
}

std::size_t count_islands(const System& system) {
  std::vector<Index> root(system.num_points());
  std::iota(root.begin(), root.end(), 0);
  const std::vector<char> is_support = find_supports(system);
  std::vector<char> has_rows(root.size(), 0);
  for_each_member(system, [&](std::span<const Index> points, int) {
    Index first = -1;
    for (const Index point : points) {
      if (is_support[static_cast<std::size_t>(point)] != 0) continue;
      has_rows[static_cast<std::size_t>(point)] = 1;
      if (first < 0) first = point;
      join_sets(root.data(), first, point);
    }
  });
  std::size_t count = 0;
  for (std::size_t i = 0; i < root.size(); ++i) count += has_rows[i] != 0 && root[i] == static_cast<Index>(i) ? 1 : 0;
  return count;
}

}  // namespace

WholeRun::WholeRun(MpiRanks& ranks, const Division& division, Simulation& simulation)
    : ranks_(ranks),
      division_(division),
      part_(division.part()),
      contacts_(report::count_contacts(part_.system)),
      plan_(simulation.plan()),
      report_(simulation.report()),
      rank_(simulation.rank()) {
  merge_plan();
  merge_friction();
  if (division.whole() == nullptr) return;
  positions_ = gather_points(simulation.positions());
  velocities_ = gather_points(simulation.velocities());
  accelerations_ = gather_points(simulation.accelerations());
  multipliers_ = gather_rows(simulation.multipliers());
  reactions_ = gather_points(simulation.reactions(), OfSupports::AreSummed);
  support_forces_ = gather_points(simulation.support_forces(), OfSupports::AreSummed);
}

/// Counts points and equations on the ranks that write or count them, and everything else where it is.
void WholeRun::merge_plan() {
  const std::vector<char> is_support = find_supports(part_.system);
  plan_.points = count_to_write(ranks_, part_);
  plan_.supports = static_cast<std::size_t>(std::count(is_support.begin(), is_support.begin() + plan_.points, 1));
  for (const Part::SharedRow& row : part_.part.shared_rows) plan_.equations -= row.is_counted ? 0 : 1;
  combine(ranks_, &MpiRanks::sum, plan_.points, plan_.supports, plan_.equations, plan_.islands, plan_.coordinates,
          plan_.factor_nonzeros, plan_.factor_flops, contacts_);
  if (part_.part.is_cut()) plan_.islands = count_islands(*division_.whole());
  const auto lists = gather(ranks_, plan_.left_out);
  std::erase_if(plan_.left_out, [&](const std::string& each) {  // what one rank needs was not left out
    return std::ranges::any_of(lists, [&](const auto& list) { return std::ranges::find(list, each) == list.end(); });
  });
}

/// Counts add up, of the rest the weakest result counts. Ranks without friction say nothing.
void WholeRun::merge_friction() {
  constexpr double never = std::numeric_limits<double>::infinity();
  FrictionSummary& all = report_.friction;
  const Uniqueness own = all.uniqueness;
  bool is_unproven = own != Uniqueness::NotAsked && std::isnan(all.error_bound);
  if (std::isnan(all.error_bound)) all.error_bound = 0.0;
  double iterations = static_cast<double>(all.solves) * all.iterations_mean,
         first_several = all.several > 0 ? -all.first_several : -never;
  combine(ranks_, &MpiRanks::sum, all.solves, all.several, iterations);
  combine(ranks_, &MpiRanks::find_largest, all.iterations_max, all.contraction_max, all.residual_max, all.method_used,
          all.uniqueness, is_unproven, all.error_bound, first_several);
  all.iterations_mean = all.solves > 0 ? iterations / static_cast<double>(all.solves) : 0.0;
  all.first_several = all.several > 0 ? -first_several : std::numeric_limits<double>::quiet_NaN();
  if (all.uniqueness == Uniqueness::NotAsked || is_unproven) all.error_bound = std::numeric_limits<double>::quiet_NaN();
  const auto reasons = gather(ranks_, own == all.uniqueness ? all.uniqueness_reason : std::string());
  const auto known = std::ranges::find_if(reasons, [](const std::string& reason) { return !reason.empty(); });
  all.uniqueness_reason = known != reasons.end() ? *known : std::string();
}

/// Gathers numbers of points from their owners. Those of supports are the first rank's, or the sum over all ranks.
std::vector<double> WholeRun::gather_points(std::span<const double> own, OfSupports of_supports) const {
  const std::size_t end = of_supports == OfSupports::AreSummed ? part_.points.size() - part_.part.guests.size()
                                                               : count_to_write(ranks_, part_);
  std::vector<double> packed;
  for (std::size_t i = 0; i < end; ++i)
    packed.insert(packed.end(), {3.0 * part_.points[i], own[3 * i], own[3 * i + 1], own[3 * i + 2]});
  return add_on_first(packed, 3, 3 * plan_.points);
}

/// Gathers numbers of rows. Shared equations come from the rank that counts them.
std::vector<double> WholeRun::gather_rows(std::span<const double> own) const {
  std::vector<char> is_counted(part_.equations.size(), 1);
  for (const Part::SharedRow& row : part_.part.shared_rows) is_counted[row.equation] = row.is_counted ? 1 : 0;
  std::vector<double> packed;
  for (std::size_t a = 0; a < is_counted.size(); ++a)
    if (is_counted[a] != 0) packed.insert(packed.end(), {static_cast<double>(part_.equations[a]), own[a]});
  return add_on_first(packed, 1, plan_.equations);
}

/// Adds up on the first rank what all ranks have packed: a place in an array of so many numbers, and the `width`
/// numbers from there on. No other rank holds the array.
std::vector<double> WholeRun::add_on_first(const std::vector<double>& packed, std::size_t width,
                                           std::size_t size) const {
  auto count = static_cast<double>(packed.size());
  if (ranks_.rank() != 0) {
    ranks_.exchange(std::array{Ranks::Message{0, {&count, 1}, {}}, Ranks::Message{0, packed, {}}});
    return {};
  }
  std::vector<double> all(size, 0.0), received = packed;
  for (int rank = 0; rank < ranks_.size(); ++rank) {
    const auto receive = [&](std::span<double> numbers) {
      ranks_.exchange(std::array{Ranks::Message{rank, {}, numbers}});
    };
    if (rank > 0) {
      receive({&count, 1});
      received.resize(static_cast<std::size_t>(count));
      receive(received);
    }
    for (std::size_t at = 0; at < received.size(); at += width + 1)
      for (std::size_t k = 0; k < width; ++k) all[static_cast<std::size_t>(received[at]) + k] += received[at + 1 + k];
  }
  return all;
}

Certificate WholeRun::prove() const {
  Dynamics alone(*division_.whole(), division_.scene().solver);
  const StateView state{.time = report_.time, .positions = positions_, .velocities = velocities_};
  std::vector<double> w(positions_.size()), eta(positions_.size());
  const bool is_solved = alone.solve(state, {.accelerations = w, .reactions = eta}).outcome.ok();
  Certificate certificate = alone.certify(state);  // certifies this solution
  if (!is_solved) return certificate;
  double error = 0.0, scale = 0.0;
  for (std::size_t i = 0; i < w.size(); ++i) {
    error = std::max(error, std::abs(w[i] - accelerations_[i]));
    scale = std::max(scale, std::abs(w[i]));
  }
  const double allowed = std::min(Certificate::fewest_digits, 1e-12 / certificate.reciprocal_condition);
  certificate.checks.push_back({"w of all ranks = w of one", error / std::max(scale, least_scale), allowed, {}});
  return certificate;
}

report::RunEnd WholeRun::end() const {
  std::optional<report::EndArrays> arrays;
  const System* const whole = division_.whole();
  if (whole != nullptr)
    arrays = {positions_, velocities_, accelerations_, multipliers_, {}, reactions_, support_forces_};
  return {contacts_,
          plan_,
          report_,
          rank_,
          report_.time,
          arrays,
          {},
          {},
          part_.system.units,
          whole != nullptr ? report::list_groups(*whole) : report::Json()};
}

}  // namespace tanor::mpi
