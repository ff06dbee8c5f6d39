#include "report/shared_parts.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace tanor::report {

bool has_multipliers(const PlanSummary& plan) {
  return plan.form == Form::Normal || plan.equations > 0;
}

Json if_started(const RunFacts& facts, double number) {
  return facts.has_started ? Json(number) : Json();
}

Json describe_certificate(const std::optional<Certificate>& certificate) {
  const auto figure = [&](double Certificate::*which) { return certificate ? Json(*certificate.*which) : Json(); };
  Json checks = Json::array();
  for (const CertificateCheck& check : certificate ? certificate->checks : std::vector<CertificateCheck>()) {
    checks.push_back({{"words", check.words},
                      {"identity", check.identity},
                      {"error", check.error},
                      {"allowed", check.allowed},
                      {"where", json_or_null(check.where)}});
  }
  return {{"normal_identity", figure(&Certificate::normal_identity)},
          {"tangent_identity", figure(&Certificate::tangent_identity)},
          {"bases_orthogonal", figure(&Certificate::bases_orthogonal)},
          {"orthogonality", figure(&Certificate::orthogonality)},
          {"residual", figure(&Certificate::residual)},
          {"forms_agree", figure(&Certificate::forms_agree)},
          {"second_factorization", figure(&Certificate::second_factorization)},
          {"power_balance", figure(&Certificate::power_balance)},
          {"friction", figure(&Certificate::friction)},
          {"reciprocal_condition", figure(&Certificate::reciprocal_condition)},
          {"verdict", certificate ? Json(certificate->line()) : Json()},
          {"checks", checks},
          {"left_out", certificate ? certificate->left_out : std::vector<std::string>()}};
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
