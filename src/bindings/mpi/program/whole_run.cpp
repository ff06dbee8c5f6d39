#include "mpi/program/whole_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "mpi/pieces.hpp"
#include "mpi/program/together.hpp"

namespace tanor::mpi {

namespace {

constexpr double least_scale = std::numeric_limits<double>::min();  // for accelerations that are all 0

double sum_of(MpiRanks& ranks, double own) {
  ranks.sum({&own, 1});
  return own;
}

std::size_t sum_of(MpiRanks& ranks, std::size_t own) {
  return static_cast<std::size_t>(sum_of(ranks, static_cast<double>(own)));
}

/// Adds the numbers of all ranks at their places, on the first rank, which takes them rank by rank.
void gather(const MpiRanks& ranks, std::span<const double> numbers, std::span<const std::size_t> places,
            std::vector<double>* all) {
  const auto add = [&](std::span<const double> own, std::span<const std::size_t> own_places) {
    for (std::size_t k = 0; k < own.size(); ++k) (*all)[own_places[k]] += own[k];
  };
  if (ranks.rank() != 0) {
    send_array(ranks.communicator(), 0, numbers);
    send_array(ranks.communicator(), 0, places);
    return;
  }
  add(numbers, places);
  for (int rank = 1; rank < ranks.size(); ++rank) {
    const auto received = receive_array<double>(ranks.communicator(), rank);
    add(received, receive_array<std::size_t>(ranks.communicator(), rank));
  }
}

/// Returns the friction of all ranks: counts add up, of the rest the weakest result counts. Ranks without friction say
/// nothing.
FrictionSummary merge_friction(MpiRanks& ranks, const FrictionSummary& own) {
  constexpr double never = std::numeric_limits<double>::infinity();
  const auto solves = static_cast<double>(own.solves);
  std::array<double, 3> sums{solves, static_cast<double>(own.several), solves * own.iterations_mean};
  ranks.sum(sums);
  const bool is_proven = own.uniqueness == Uniqueness::NotAsked || !std::isnan(own.error_bound);
  std::array<double, 8> largest{static_cast<double>(own.iterations_max),
                                own.contraction_max,
                                own.residual_max,
                                static_cast<double>(own.method_used),
                                static_cast<double>(own.uniqueness),
                                is_proven ? 0.0 : 1.0,
                                std::isnan(own.error_bound) ? 0.0 : own.error_bound,
                                own.several > 0 ? -own.first_several : -never};
  ranks.find_largest(largest);
  FrictionSummary all;
  all.solves = static_cast<std::size_t>(sums[0]);
  all.several = static_cast<std::size_t>(sums[1]);
  if (all.solves > 0) all.iterations_mean = sums[2] / sums[0];
  all.iterations_max = static_cast<int>(largest[0]);
  all.contraction_max = largest[1];
  all.residual_max = largest[2];
  all.method_used = static_cast<FrictionMethod>(largest[3]);
  all.uniqueness = static_cast<Uniqueness>(largest[4]);
  if (all.uniqueness != Uniqueness::NotAsked && largest[5] == 0.0) all.error_bound = largest[6];
  if (all.several > 0) all.first_several = -largest[7];
  for (const std::string& reason : gather_texts(ranks, own.uniqueness == all.uniqueness ? own.uniqueness_reason : "")) {
    if (all.uniqueness_reason.empty()) all.uniqueness_reason = reason;
  }
  return all;
}

}  // namespace

WholeRun::WholeRun(MpiRanks& ranks, const Division& division, Simulation& simulation)
    : ranks_(ranks), division_(division), part_(division.part()), rank_(simulation.rank()) {
  merge_plan(simulation.plan());
  merge_report(simulation.report());
  if (division.whole() == nullptr) return;
  positions_ = gather_points(simulation.positions());
  velocities_ = gather_points(simulation.velocities());
  accelerations_ = gather_points(simulation.accelerations());
  multipliers_ = gather_rows(simulation.multipliers());
  reactions_ = gather_points(simulation.reactions(), OfSupports::AreSummed);
  support_forces_ = gather_points(simulation.support_forces(), OfSupports::AreSummed);
}

/// Gathers numbers of points from their owners. Those of supports are the first rank's, or the sum over all ranks.
std::vector<double> WholeRun::gather_points(std::span<const double> own, OfSupports of_supports) const {
  std::vector<double> numbers;
  std::vector<std::size_t> places;
  const bool adds_supports = of_supports == OfSupports::AreSummed || ranks_.rank() == 0;
  const std::size_t end = adds_supports ? part_.points.size() - part_.part.guests.size() : part_.num_owned;
  for (std::size_t i = 0; i < end; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      numbers.push_back(own[3 * i + c]);
      places.push_back(3 * static_cast<std::size_t>(part_.points[i]) + c);
    }
  }
  std::vector<double> all(ranks_.rank() == 0 ? 3 * plan_.points : 0);
  gather(ranks_, numbers, places, &all);
  return all;
}

/// Gathers numbers of rows. Shared equations come from the rank that counts them.
std::vector<double> WholeRun::gather_rows(std::span<const double> own) const {
  std::vector<char> is_elsewhere(part_.equations.size(), 0);
  for (const Part::SharedRow& row : part_.part.shared_rows) is_elsewhere[row.equation] = row.is_counted ? 0 : 1;
  std::vector<double> numbers;
  std::vector<std::size_t> places;
  for (std::size_t a = 0; a < part_.equations.size(); ++a) {
    if (is_elsewhere[a] != 0) continue;
    numbers.push_back(own[a]);
    places.push_back(part_.equations[a]);
  }
  std::vector<double> all(ranks_.rank() == 0 ? plan_.equations : 0);
  gather(ranks_, numbers, places, &all);
  return all;
}

void WholeRun::merge_plan(const PlanSummary& own) {
  plan_ = own;
  plan_.points = division_.counts().points;
  plan_.supports = division_.counts().supports;
  plan_.equations = division_.counts().equations;
  const std::size_t own_islands = sum_of(ranks_, own.islands);
  plan_.islands = own.form == Form::Tangent ? own_islands : division_.counts().islands;
  plan_.coordinates = sum_of(ranks_, own.coordinates);
  const auto lists = gather_lines(ranks_, own.left_out);
  std::erase_if(plan_.left_out, [&](const std::string& each) {  // what one rank needs was not left out
    return std::ranges::any_of(lists, [&](const auto& list) { return std::ranges::find(list, each) == list.end(); });
  });
  plan_.factor_nonzeros = sum_of(ranks_, own.factor_nonzeros);
  plan_.factor_flops = sum_of(ranks_, own.factor_flops);
}

void WholeRun::merge_report(const MotionReport& own) {
  report_ = own;
  report_.friction = merge_friction(ranks_, own.friction);
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
  if (division_.whole() != nullptr)
    arrays = {positions_, velocities_, accelerations_, multipliers_, reactions_, support_forces_};
  return {division_.counts().contacts, plan_, report_, rank_, report_.time, arrays};
}

}  // namespace tanor::mpi
