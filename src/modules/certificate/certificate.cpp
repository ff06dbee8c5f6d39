#include "certificate/certificate.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "certificate/verifier.hpp"

namespace tanor {
using namespace detail;

bool Certificate::passed() const {
  return std::ranges::all_of(checks, [](const CertificateCheck& check) { return check.error <= check.allowed; });
}

double Certificate::certified_to() const {
  double worst = 0.0;
  for (const CertificateCheck& check : checks) {
    if (!(check.error <= worst)) worst = check.error;
  }
  return worst;
}

std::string Certificate::line() const {
  const auto digits = [](double x) -> std::string {
    if (std::isnan(x)) return "an unknown amount";
    if (std::isinf(x)) return "more than any number";
    std::array<char, 16> buffer;
    const auto end =
        std::to_chars(buffer.data(), buffer.data() + buffer.size(), x, std::chars_format::scientific, 1).ptr;
    return std::string(buffer.data(), end);
  };
  const auto why_not = [&](const CertificateCheck& check) {
    if (check.allowed < fewest_digits) return "rounding explains " + digits(check.allowed);
    return "fewer than four digits are proven" +
           (reciprocal_condition > 0.0 ? "; the reciprocal condition is " + digits(reciprocal_condition) : "");
  };
  for (const CertificateCheck& check : checks) {
    if (check.error <= check.allowed) continue;
    return "not certified: " + check.words + " fails by " + digits(check.error) +
           (check.where.empty() ? "" : " at " + check.where) + " (" + why_not(check) + ")";
  }
  if (checks.empty()) return "nothing to certify: no point moves";
  return "certified to " + digits(certified_to());
}

Certificate detail::make_failed_certificate(const Outcome& outcome) {
  Certificate certificate;
  const std::string words = "there is an answer: " + outcome.what;
  certificate.checks.push_back({words, Certificate::none, 0.0, "", words});
  return certificate;
}

Certificate detail::certify(Forms& forms, const Answer& answer, SecondFactorization by) {
  if (!forms.model.numbering.one_sided.empty()) return certify_one_sided(forms, answer, by);
  return Verifier(forms, answer, by).verify();
}

}  // namespace tanor
