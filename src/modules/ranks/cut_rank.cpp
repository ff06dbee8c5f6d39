#include "ranks/cut_rank.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/text.hpp"

namespace tanor::detail {

CutRank::CutRank(Workspace& work, const Part& part)
    : Dependences(work),
      work_(work),
      model_(work.model()),
      row_number_(model_.numbering.first_idle_row()),
      is_counted_(row_number_.size(), 1) {
  std::vector<const Part::SharedRow*> shared_of(model_.num_rows(), nullptr);  // [equation]
  for (const Part::SharedRow& shared : part.shared_rows) shared_of[shared.equation] = &shared;
  const auto shared_at = [&](std::size_t row) {
    return shared_of[static_cast<std::size_t>(model_.numbering.user_row[row])];
  };
  const Share rows = work.team().share(row_number_.size() - part.shared_rows.size());
  const Share points = work.team().share(model_.num_moving());
  first_point_ = points.first;
  num_all_points_ = points.all();
  num_all_rows_ = rows.all() + part.num_shared_rows;
  std::size_t next = rows.first;
  for (std::size_t a = 0; a < row_number_.size(); ++a) {
    const Part::SharedRow* const shared = shared_at(a);
    row_number_[a] = shared != nullptr ? rows.all() + shared->place : next++;
    if (shared != nullptr) is_counted_[a] = shared->is_counted ? 1 : 0;
  }
}

/// Returns K or M^-1/2 K of all ranks. Each rank sends the gradients at its own points.
SparseColumns CutRank::gather_columns(const double* blocks, Scaling scaling) {
  constexpr std::size_t width = 5;  // row, point, gradient
  std::vector<double> own;
  for (const Incidence& incidence : model_.incidences) {
    const auto row = static_cast<std::size_t>(incidence.row), point = static_cast<std::size_t>(incidence.point);
    if (point >= model_.num_moving() || row >= row_number_.size()) continue;
    const double scale = scaling == Scaling::ByMasses ? std::sqrt(model_.inverse_mass[point]) : 1.0;
    const Vec3 g = incidence.sign * scale * load(blocks, incidence.block);
    own.insert(own.end(),
               {static_cast<double>(row_number_[row]), static_cast<double>(first_point_ + point), g.x, g.y, g.z});
  }
  const Share place = work_.team().share(own.size());
  std::vector<double> all(place.all(), 0.0);
  std::ranges::copy(own, all.begin() + static_cast<std::ptrdiff_t>(place.first));
  work_.team().add(all);
  std::vector<std::size_t> order(place.all() / width);
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](std::size_t entry) { return std::array{all[width * entry], all[width * entry + 1]}; };
  std::ranges::sort(order, {}, key);
  SparseColumns columns;
  columns.num_rows = static_cast<int>(3 * num_all_points_);
  for (const std::size_t entry : order) {
    const auto [row, point] = key(entry);
    while (static_cast<double>(columns.num_columns()) <= row) columns.start.push_back(columns.start.back());
    const auto first = static_cast<int>(3.0 * point);
    const bool is_new =
        columns.rows.size() == static_cast<std::size_t>(columns.start.end()[-2]) || columns.rows.end()[-3] != first;
    if (is_new) {
      columns.rows.insert(columns.rows.end(), {first, first + 1, first + 2});
      columns.values.insert(columns.values.end(), 3, 0.0);
    }
    // A tuple may name a point twice.
    for (std::size_t c = 0; c < 3; ++c)
      columns.values.end()[static_cast<std::ptrdiff_t>(c) - 3] += all[width * entry + 2 + c];
    columns.start.back() = static_cast<int>(columns.rows.size());
  }
  while (columns.num_columns() < num_all_rows_) columns.start.push_back(columns.start.back());
  return columns;
}

bool CutRank::decide(const std::vector<double>& blocks, const double* r) {
  ++work_.counters.rank_decisions;
  const std::vector<double> tolerances = work_.rank_tolerances(r);
  const double own = tolerances.empty() ? 0.0 : *std::ranges::max_element(tolerances);
  Team& team = work_.team();
  solver_ = decide_rank([&](Scaling scaling) { return gather_columns(blocks.data(), scaling); }, team.largest(own),
                        [&] { return team.largest(model_.mass_ratio); });
  std::vector<char> depends(num_all_rows_, 0);
  for (const Dependence& dependence : solver_->dependences()) depends[static_cast<std::size_t>(dependence.column)] = 1;
  std::vector<char> active(row_number_.size());
  for (std::size_t a = 0; a < active.size(); ++a) active[a] = depends[row_number_[a]] == 0 ? 1 : 0;
  if (active_.empty()) active_.assign(active.size(), 1);
  const auto count = [&](const std::vector<char>& of) {
    std::size_t result = 0;
    for (std::size_t a = 0; a < of.size(); ++a) result += is_counted_[a] != 0 && of[a] == 0 ? 1 : 0;
    return result;
  };
  work_.rank = work_.rank + count(active_) - count(active);
  const bool has_changed = team.any(active != active_);
  active_ = std::move(active);
  note_change(blocks);
  return has_changed;
}

std::string CutRank::explain(const std::string& verb) const {
  std::string text;
  if (!is_found()) return text;
  const Dependence& first = solver_->dependences().front();
  const auto name = [&](int number) {
    const auto here = std::ranges::find(row_number_, static_cast<std::size_t>(number));
    const bool knows = here != row_number_.end();
    return work_.team().first_text(knows ? work_.name_row(static_cast<std::size_t>(here - row_number_.begin())) : "");
  };
  text = name(first.column) + " " + verb + " ";
  constexpr std::size_t most = 3;
  for (std::size_t k = 0; k < std::min(most, first.terms.size()); ++k)
    text += (k > 0 ? ", " : "") + name(first.terms[k].column);
  return text + (first.terms.size() > most ? ", …" : "");
}

Outcome CutRank::explain_contradiction(double t, const std::vector<double>&, const std::vector<double>&, double,
                                       const char*) const {
  return {Status::Contradictory, explain("contradicts") + " at t = " + text(t)};
}

void CutRank::minimize_norm(double* lambda) const {
  if (!is_found()) return;
  std::vector<double> all(num_all_rows_, 0.0);
  for (std::size_t a = 0; a < row_number_.size(); ++a)
    if (is_counted_[a] != 0) all[row_number_[a]] = lambda[a];
  work_.team().add(all);
  solver_->minimize_norm(all.data());
  for (std::size_t a = 0; a < row_number_.size(); ++a) lambda[a] = all[row_number_[a]];
}

}  // namespace tanor::detail
