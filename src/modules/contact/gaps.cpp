#include "contact/gaps.hpp"

namespace tanor::detail {

Gaps::Gaps(Workspace& work, ConstrainedSystem& system)
    : workspace_(work),
      model_(work.model()),
      system_(system),
      rows_(model_.numbering.one_sided),
      selection_(work.constraints.select(model_.numbering.may_open)),
      closed_(rows_.size(), 1),
      gaps_(rows_.size()),
      all_rows_(model_.num_rows()) {
  std::vector<std::size_t> number(model_.num_rows());
  for (std::size_t k = 0; k < rows_.size(); ++k) number[static_cast<std::size_t>(rows_[k].row)] = k;
  arms_ = {rows_.size(), [&](const auto& add) {
             for (const Incidence& incidence : model_.incidences) {
               const auto row = static_cast<std::size_t>(incidence.row);
               if (model_.numbering.may_open[row] != 0) add(number[row], incidence);
             }
           }};
}

void Gaps::apply() {
  std::vector<char> is_open(model_.num_rows(), 0);
  for (std::size_t k = 0; k < rows_.size(); ++k) is_open[static_cast<std::size_t>(rows_[k].row)] = closed_[k] == 0;
  workspace_.constraints.open.set(workspace_.constraints, is_open);
  Tangents& tangents = workspace_.constraints.tangents();
  for (std::size_t c = 0; c < tangents.size(); ++c)
    tangents.set_open(c, is_open[static_cast<std::size_t>(tangents[c].guide_row[0])] != 0);
}

/// Writes s times the one-sided rows of `all_rows_`.
void Gaps::take_rows(std::vector<double>* numbers) const {
  numbers->resize(rows_.size());
  for (std::size_t k = 0; k < rows_.size(); ++k)
    (*numbers)[k] = rows_[k].sign * all_rows_[static_cast<std::size_t>(rows_[k].row)];
}

void Gaps::measure_gaps(double t, const double* r) {
  workspace_.set_time(t);
  (void)workspace_.constraints.evaluate_values(model_.parallel, selection_, r, all_rows_.data());
  take_rows(&gaps_);
}

void Gaps::measure_rates(const double* r, const double* v, std::vector<double>* rates) {
  (void)workspace_.constraints.evaluate_rates(model_.parallel, selection_, r, v, all_rows_.data());
  take_rows(rates);
}

void Gaps::measure_accelerations(const double* r, const double* v, const double* w) {
  (void)workspace_.constraints.evaluate_right_side(model_.parallel, selection_, r, v, w, all_rows_.data(), nullptr);
  take_rows(&accelerations_);
}

void Gaps::measure_right_side(const double* r, const double* v, const double* w, std::vector<double>* b) {
  b->resize(model_.num_rows());
  (void)workspace_.constraints.evaluate_right_side(model_.parallel, r, v, w, b->data(), nullptr);
  measure_accelerations(r, v, w);
  for (const OneSidedRow& each : rows_) {
    const auto row = static_cast<std::size_t>(each.row);
    (*b)[row] = all_rows_[row];
  }
}

double Gaps::inverse_effective_mass(std::size_t k) const {
  double sum = 0.0;
  for (const Incidence& arm : arms_[k]) {
    const Vec3 g = load(system_.blocks().data(), arm.block);
    sum += model_.inverse_mass[static_cast<std::size_t>(arm.point)] * dot(g, g);
  }
  return sum;
}

ContactChange Gaps::name_change(std::size_t k, bool closes) const {
  const bool is_tie = rows_[k].sign < 0.0 && arms_[k].size() > 1;
  if (closes) return is_tie ? ContactChange::Snap : ContactChange::Touch;
  return is_tie ? ContactChange::Slack : ContactChange::LiftOff;
}

}  // namespace tanor::detail
