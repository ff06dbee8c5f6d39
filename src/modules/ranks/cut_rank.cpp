#include "ranks/cut_rank.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"

namespace tanor::detail {

std::vector<const Part::SharedRow*> find_shared_rows(const Model& model, const Part& part) {
  std::vector<const Part::SharedRow*> of_equation(model.num_rows(), nullptr), result;
  for (const Part::SharedRow& shared : part.shared_rows) of_equation[shared.equation] = &shared;
  for (const Index equation : model.numbering.user_row)
    result.push_back(of_equation[static_cast<std::size_t>(equation)]);
  return result;
}

CutRank::CutRank(Workspace& work, const Part& part)
    : Dependences(work),
      work_(work),
      model_(work.model()),
      row_number_(model_.numbering.first_idle_row()),
      is_counted_(row_number_.size(), 1) {
  const Share rows = work.team().share(row_number_.size() - part.shared_rows.size());
  const Share points = work.team().share(model_.num_moving());
  first_point_ = points.first;
  num_all_points_ = points.all();
  num_all_rows_ = rows.all() + part.num_shared_rows;
  std::size_t next = rows.first;
  const std::vector<const Part::SharedRow*> shared = find_shared_rows(model_, part);
  for (std::size_t a = 0; a < row_number_.size(); ++a) {
    row_number_[a] = shared[a] != nullptr ? rows.all() + shared[a]->place : next++;
    if (shared[a] != nullptr) is_counted_[a] = shared[a]->is_counted ? 1 : 0;
  }
}

/// Returns K or M^-1/2 K of all ranks. Each rank sends the gradients at its own points.
SparseColumns CutRank::gather_columns(const double* blocks, Scaling scaling) {
  constexpr std::ptrdiff_t width = 5;  // row, point, gradient
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
  SparseColumns columns = collect_columns(num_all_rows_, [&](const auto& add) {
    for (auto entry = all.begin(); entry != all.end(); entry += width)
      add(static_cast<std::size_t>(entry[0]), PointEntry{static_cast<int>(entry[1]), {entry[2], entry[3], entry[4]}});
  });
  columns.num_rows = static_cast<int>(3 * num_all_points_);
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
  for (std::size_t a = 0; a < active.size(); ++a)
    if (is_counted_[a] != 0) work_.rank += static_cast<std::size_t>(active[a]) - static_cast<std::size_t>(active_[a]);
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
                                       Dimension) const {
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
