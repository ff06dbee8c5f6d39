#include "host/host_part.hpp"

#include <algorithm>
#include <utility>

namespace tanor::detail {

namespace {

/// Returns what StepProjection remembers: the multipliers of the last step [d] and of the one before, and their h.
std::vector<double> read_steps(ConstrainedHost* host) {
  std::vector<double> numbers;
  Memory memory(&numbers);
  host->form.steps().exchange_memory(memory);
  return numbers;
}

}  // namespace

/// Rows are only added at the end, or move forward together with all that follow. So if the first and the last row move
/// by the same number, all rows do.
void HostPart::number_rows(const Inventory& inventory) {
  if (members.empty()) return;
  const std::size_t first = inventory.first_row(members.front());
  const std::size_t last = inventory.first_row(members.back());
  const std::size_t first_move = std::exchange(first_row_, first) - first;
  const std::size_t last_move = std::exchange(last_row_, last) - last;
  std::vector<Index>& rows = host->host_row;
  if (std::exchange(has_rows_, true) && first_move == last_move) {
    if (last_move == 0) return;
    for (Index& row : rows) row -= static_cast<Index>(last_move);
    return;
  }
  const Numbering& numbering = host->model.numbering;
  std::vector<Index> of_user;
  for (const ConstraintId id : members) {
    for (std::size_t k = 0; k < inventory.num_rows(id); ++k)
      of_user.push_back(static_cast<Index>(inventory.first_row(id) + k));
  }
  for (std::size_t a = 0; a < rows.size(); ++a) rows[a] = of_user[static_cast<std::size_t>(numbering.user_row[a])];
}

void HostPart::number_points(const HostPoints& points) const {
  std::vector<Index> host_points;
  for (const Index point : places) host_points.push_back(points.host_point[static_cast<std::size_t>(point)]);
  host->transfer.set_points(host_points);
}

// ---- what parts hand over ----

void add_up(const Counters& more, Counters* sum) {
  sum->evaluations += more.evaluations;
  sum->factorizations += more.factorizations;
  sum->solves += more.solves;
  sum->iterations += more.iterations;
  sum->rank_decisions += more.rank_decisions;
}

void PartHistory::read_positions(HostPart* part) {
  ConstrainedHost* const host = part->host.get();
  if (host == nullptr || !std::exchange(host->place.was_called, false)) return;
  const std::vector<double>& from = host->place.images ? host->place.host : host->place.r;
  for (std::size_t i = 0; i < part->places.size(); ++i) {
    const auto inner = static_cast<std::size_t>(host->model.numbering.inner_point[i]);
    std::copy_n(&from[3 * inner], 3, &points_.positions[3 * static_cast<std::size_t>(part->places[i])]);
  }
  if (host->place.images) points_.cell = host->place.cell;
}

void PartHistory::read(HostPart* part) {
  read_positions(part);
  if (part->host == nullptr) return;
  add_up(part->host->work.counters, &counters_);
  if (part->members.empty()) return;
  const std::vector<double> steps = read_steps(part->host.get());
  const Numbering& numbering = part->host->model.numbering;
  const std::size_t num_rows = numbering.num_rows();
  last_h_ = steps[2 * num_rows];
  before_h_ = steps[2 * num_rows + 1];
  for (std::size_t m = 0; m < part->members.size(); ++m) {
    const ConstraintId id = part->members[m];
    for (std::size_t k = 0; k < inventory_.num_rows(id); ++k) {
      const std::size_t row = static_cast<std::size_t>(numbering.member_row[m]) + k;
      part->guesses.push_back({id, k, steps[row], steps[num_rows + row], part->host->place.was_checked});
    }
  }
}

void PartHistory::hand_over(HostPart* part) const {
  std::vector<MultiplierGuess> guesses = std::exchange(part->guesses, {});
  if (guesses.empty()) return;
  const auto name = [](const MultiplierGuess& guess) { return std::pair(guess.id, guess.row); };
  std::ranges::sort(guesses, {}, name);
  std::vector<double> steps = read_steps(part->host.get());
  const Numbering& numbering = part->host->model.numbering;
  const std::size_t num_rows = numbering.num_rows();
  steps[2 * num_rows] = last_h_;
  steps[2 * num_rows + 1] = before_h_;
  std::size_t num_checked = 0;
  for (std::size_t m = 0; m < part->members.size(); ++m) {
    const ConstraintId id = part->members[m];
    auto guess = std::ranges::lower_bound(guesses, std::pair(id, std::size_t{0}), {}, name);
    for (; guess != guesses.end() && guess->id == id; ++guess) {
      const std::size_t row = static_cast<std::size_t>(numbering.member_row[m]) + guess->row;
      steps[row] = guess->last;
      steps[num_rows + row] = guess->before;
      num_checked += guess->was_checked ? 1 : 0;
    }
  }
  part->host->place.was_checked = num_checked == num_rows;
  Memory memory{std::span<const double>(steps)};
  part->host->form.steps().exchange_memory(memory);
}

}  // namespace tanor::detail
