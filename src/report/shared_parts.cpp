#include "report/shared_parts.hpp"

#include <fmt/format.h>

#include <algorithm>

#include <cmath>

namespace tanor::report {

bool has_multipliers(const PlanSummary& plan) {
  return plan.form == Form::Normal || plan.equations > 0;
}

void write_certificate(JsonWriter* json, const std::optional<Certificate>& certificate) {
  const auto write = [&](const char* key, double Certificate::*figure) {
    const bool is_known = certificate && !std::isnan(*certificate.*figure);
    json->key(key).value(is_known ? std::optional(*certificate.*figure) : std::nullopt);
  };
  json->key("certificate").begin_object();
  write("normal_identity", &Certificate::normal_identity);
  write("tangent_identity", &Certificate::tangent_identity);
  write("bases_orthogonal", &Certificate::bases_orthogonal);
  write("orthogonality", &Certificate::orthogonality);
  write("residual", &Certificate::residual);
  write("forms_agree", &Certificate::forms_agree);
  write("second_factorization", &Certificate::second_factorization);
  write("power_balance", &Certificate::power_balance);
  write("friction", &Certificate::friction);
  write("reciprocal_condition", &Certificate::reciprocal_condition);
  json->key("verdict");
  certificate ? json->value(certificate->line()) : json->null();
  json->key("checks").begin_array();
  for (const CertificateCheck& check : certificate ? certificate->checks : std::vector<CertificateCheck>()) {
    json->begin_object();
    json->key("identity").value(check.identity);
    json->key("error").value(std::isnan(check.error) ? std::nullopt : std::optional(check.error));
    json->key("allowed").value(check.allowed);
    json->key("where");
    check.where.empty() ? json->null() : json->value(check.where);
    json->end_object();
  }
  json->end_array();
  json->key("left_out").begin_array();
  for (const std::string& what : certificate ? certificate->left_out : std::vector<std::string>()) json->value(what);
  json->end_array();
  json->end_object();
}

void write_rank(JsonWriter* json, const std::optional<RankReport>& rank) {
  json->key("rank");
  rank && rank->is_known ? json->value(rank->rank) : json->null();
  json->key("degrees_of_freedom");
  rank ? json->value(rank->degrees_of_freedom) : json->null();
  json->key("redundant");
  if (!rank) {
    json->null();
    return;
  }
  json->begin_array();
  for (const RowDependence& dependence : rank->dependences) json->value(dependence.what);
  json->end_array();
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

void write_left_out(JsonWriter* json, const std::vector<std::string>& left_out) {
  json->key("left_out").begin_array();
  for (const std::string& what : left_out) json->value(what);
  json->end_array();
}

}  // namespace tanor::report
