#include "statics/one_sided_search.hpp"

#include "base/text.hpp"

namespace tanor::detail {

namespace {

/// Returns true if the constraints cannot hold together, at least not from that start.
bool contradicts(const EquilibriumResult& found) {
  constexpr double broken = 1e-6;
  return !found.outcome.ok() && found.violation > broken;
}

}  // namespace

/// Searches from the last equilibrium. If that fails, as for a chain that hung through the floor, it searches from the
/// start.
EquilibriumResult OneSidedSearch::rest(bool assesses_stability) {
  EquilibriumOptions options = options_;
  if (has_rested_) options.load_steps = 1;
  const System closed = without_open_constraints(input_.system, rows_.open());
  const std::vector<double> prestress = rows_.keep(input_.prestress);
  const auto rest_at = [&](const std::vector<double>& start) {
    EquilibriumResult found = rest_from(closed, input_.frame, options, prestress, start, assesses_stability);
    search_.iterations += found.search.iterations;
    search_.factorizations += found.search.factorizations;
    search_.residuals.insert(search_.residuals.end(), found.search.residuals.begin(), found.search.residuals.end());
    return found;
  };
  EquilibriumResult found = rest_at(positions_);
  return contradicts(found) && has_rested_ ? rest_at(input_.system.positions) : found;
}

/// Returns the next change after a failed search. If the closed constraints contradict each other, part of the last
/// change is undone. If they do not hold the system, the open rows are closed that its points run into next; without
/// such rows the wrong rows change, and without those all open rows close. Returns nothing if this set was tried
/// before.
OneSidedRows::Rows OneSidedSearch::change_after(const EquilibriumResult& failed) {
  if (contradicts(failed) && !changed_.empty()) return take_part_of_change();
  if (!failed_.insert(rows_.open()).second) return {};
  wanted_ = rows_.find_pushed(failed);
  if (wanted_.empty()) wanted_ = rows_.find_wrong(failed);
  if (wanted_.empty()) wanted_ = rows_.find_open();
  return wanted_;
}

/// Halves the change that was tried; if it was a single row, returns the other rows that were wanted.
OneSidedRows::Rows OneSidedSearch::take_part_of_change() {
  if (changed_.size() == 1) std::erase(wanted_, changed_.front());
  if (wanted_.empty()) return {};
  rows_.change(changed_);
  if (changed_.size() == 1) return wanted_;
  changed_.resize(changed_.size() / 2);
  return changed_;
}

EquilibriumResult OneSidedSearch::run() {
  bool assesses_stability = false;
  for (int round = 0;; ++round) {
    EquilibriumResult found = rest(assesses_stability);
    const bool rests = found.outcome.ok() || found.stability.status != Stability::None;
    const bool is_final = assesses_stability && !rests;
    if (rests) {
      changed_ = wanted_ = exchange_.choose(rows_.find_wrong(found), rows_.open());
      positions_ = found.positions;
      has_rested_ = true;
    } else if (!is_final) {
      changed_ = change_after(found);
    }
    if (is_final || (changed_.empty() && (assesses_stability || !rests))) return write(std::move(found));
    if (exchange_.is_stuck() || round == options_.max_iterations) {
      found.stability.status = Stability::None;
      found.outcome = {Status::NotConverged, "one-sided constraints do not settle after " +
                                                 text_of_count(static_cast<std::size_t>(round + 1), "round") + ": " +
                                                 rows_.name(changed_) + " would close and open in turn"};
      return write(std::move(found));
    }
    assesses_stability = changed_.empty();
    rows_.change(changed_);
  }
}

/// Writes the results for the rows of all constraints, in the user's order.
EquilibriumResult OneSidedSearch::write(EquilibriumResult found) {
  const OneSidedRows::Rows weak = rows_.find_weak(found);
  if (found.outcome.ok() && !weak.empty())
    found.left_out.push_back("one-sided constraints that touch and carry nothing (" + rows_.name(weak) +
                             "): stability takes them as held both ways");
  found.multipliers = rows_.spread(found.multipliers);
  std::vector<bool> unique(rows_.open().size(), true);
  for (std::size_t row = 0, k = 0; row < unique.size(); ++row) {
    if (!rows_.open()[row] && k < found.multipliers_unique.size()) unique[row] = found.multipliers_unique[k++];
  }
  found.multipliers_unique = std::move(unique);
  for (std::string& each : found.dependences) rows_.rename(&each);
  found.open = rows_.open();
  search_.method_used = found.search.method_used;
  found.search = std::move(search_);
  return found;
}

}  // namespace tanor::detail
