#include "report/shared_parts.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "report/field_json.hpp"

namespace tanor::report {

bool has_multipliers(const PlanSummary& plan) {
  return plan.form == Form::Normal || plan.equations > 0;
}

Json if_started(const RunFacts& facts, double number) {
  return facts.has_started ? Json(number) : Json();
}

Json describe_certificate(const std::optional<Certificate>& certificate) {
  using C = Certificate;
  using Check = CertificateCheck;
  const C shown = certificate.value_or(C());
  Json json = json_of_members<&C::normal_identity, &C::tangent_identity, &C::bases_orthogonal, &C::orthogonality,
                              &C::residual, &C::forms_agree, &C::second_factorization, &C::power_balance, &C::friction,
                              &C::reciprocal_condition>(shown);
  json["verdict"] = certificate ? Json(shown.line()) : Json();
  json["checks"] = Json::array();
  for (const Check& check : shown.checks)
    json["checks"].push_back(
        json_of_members<&Check::words, &Check::identity, &Check::error, &Check::allowed, &Check::where>(check));
  json["left_out"] = shown.left_out;
  return json;
}

void add_rank(const std::optional<RankReport>& rank, JsonObjectFile* json) {
  json->add("rank", rank && rank->is_known ? Json(rank->rank) : Json());
  json->add("degrees_of_freedom", rank ? Json(rank->degrees_of_freedom) : Json());
  Json redundant;
  if (rank) {
    redundant = Json::array();
    for (const RowDependence& dependence : rank->dependences) redundant.push_back(dependence.what);
  }
  json->add("redundant", redundant);
}

std::string describe_redundancy(const RankReport& rank) {
  constexpr std::size_t most_lines = 3;
  const std::size_t count = rank.dependences.size();
  if (count == 0) return {};
  std::string text =
      fmt::format("{} of {} equations {} redundant: ", count, rank.rank + count, count == 1 ? "is" : "are");
  for (std::size_t k = 0; k < std::min(count, most_lines); ++k) {
    text += (k > 0 ? "; " : "") + rank.dependences[k].what;
  }
  return text + (count > most_lines ? "; …" : "");
}

}  // namespace tanor::report
