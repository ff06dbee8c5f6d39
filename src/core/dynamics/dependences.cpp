#include "dynamics/dependences.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"

namespace tanor::detail {

Dependences::Dependences(const Workspace& work)
    : Redundancy(work.model().incidences, work.model().inverse_mass, work.model().numbering), work_(work) {}

void Dependences::note_change(const std::vector<double>& blocks) {
  gradient_norms_.assign(work_.model().num_rows(), 0.0);
  for (const Incidence& incidence : work_.model().incidences) {
    const Vec3 g = load(blocks.data(), incidence.block);
    gradient_norms_[static_cast<std::size_t>(incidence.row)] += dot(g, g);
  }
  // Rows of contacts that slide have no gradient now, and a unit one when they stick.
  for (double& norm : gradient_norms_) norm = norm > 0.0 ? std::sqrt(norm) : 1.0;
}

double Dependences::largest_active(const std::vector<double>& rows, const std::vector<double>& units) const {
  double largest = 0.0;
  for (std::size_t a = 0; a < rows.size(); ++a) {
    if (is_dependent(a)) continue;
    const double unit = units[work_.scales.of_row(a)] * (gradient_norms_.empty() ? 1.0 : gradient_norms_[a]);
    largest = larger(largest, std::abs(rows[a]) / unit);
  }
  return work_.team().largest(largest);
}

double Dependences::largest_dependent(const std::vector<double>& rows, const std::vector<double>& units) const {
  if (!is_found()) return 0.0;
  double largest = 0.0;
  for (std::size_t a = 0; a < rows.size(); ++a) {
    const double unit = units[work_.scales.of_row(a)] * gradient_norms_[a];
    if (is_dependent(a)) largest = larger(largest, std::abs(rows[a]) / unit);
  }
  return work_.team().largest(largest);
}

std::string Dependences::describe(const Found& found, const char* verb) const {
  constexpr std::size_t most_names = 6;
  std::string text = work_.name_row(static_cast<std::size_t>(found.row)) + " " + verb + " ";
  for (std::size_t k = 0; k < std::min(found.terms.size(), most_names); ++k) {
    text += (k > 0 ? ", " : "") + work_.name_row(static_cast<std::size_t>(found.terms[k].first));
  }
  return text + (found.terms.size() > most_names ? ", …" : "");
}

Outcome Dependences::explain_contradiction(double t, const std::vector<double>& rows, const std::vector<double>& sizes,
                                           double allowed, const char* unit) const {
  std::vector<double> scales = gradient_norms_;
  for (std::size_t a = 0; a < scales.size(); ++a) scales[a] *= sizes[work_.scales.of_row(a)];
  const auto contradiction = find_contradiction(rows, scales, allowed);
  if (!contradiction) return {};
  return {Status::Contradictory, describe(contradiction->found, "contradicts") + " at t = " + text(t) + " (by " +
                                     text(std::abs(contradiction->excess)) + unit + ")"};
}

}  // namespace tanor::detail
