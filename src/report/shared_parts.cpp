#include "report/shared_parts.hpp"

namespace tanor::report {

std::string_view name_form(const PlanSummary& plan) {
  return plan.form == Form::Tangent ? "tangent" : "normal";
}

bool has_multipliers(const PlanSummary& plan) {
  return plan.form == Form::Normal || plan.equations > 0;
}

void write_certificate(JsonWriter* json, const std::optional<Certificate>& certificate) {
  std::optional<double> residual, reciprocal_condition, forms_agree;
  if (certificate) {
    residual = certificate->residual;
    forms_agree = certificate->forms_agree;
    reciprocal_condition = certificate->reciprocal_condition;
  }
  json->key("certificate").begin_object();
  json->key("normal_identity").null();
  json->key("tangent_identity").null();
  json->key("orthogonality").null();
  json->key("residual").value(residual);
  json->key("forms_agree").value(forms_agree);
  json->key("power_balance").null();
  json->key("reciprocal_condition").value(reciprocal_condition);
  json->end_object();
}

void write_left_out(JsonWriter* json, const std::vector<std::string>& left_out) {
  json->key("left_out").begin_array();
  for (const std::string& what : left_out) json->value(what);
  json->end_array();
}

}  // namespace tanor::report
