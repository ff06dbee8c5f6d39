#pragma once

#include <limits>
#include <string>
#include <vector>

#include <tanor/export.hpp>

namespace tanor {

/// One identity checked on an answer, with its relative error and the error that rounding may explain.
struct [[nodiscard]] CertificateCheck {
  std::string identity;  ///< in the paper's symbols, "K'w + phi = 0"
  double error = 0.0;
  double allowed = 0.0;  ///< at most `Certificate::fewest_digits`
  std::string where{};   ///< worst constraint or point; empty if there is none
  std::string words{};   ///< the identity in plain words, "Newton's law"
};

/// Verification of an answer (w, lambda, eta) by identities of the paper and by second methods for the same numbers.
/// Values are relative errors; NaN where there is nothing to compute.
struct [[nodiscard]] Certificate {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  /// A larger error proves nothing, whatever rounding may explain; no check allows more.
  static constexpr double fewest_digits = 1e-4;

  /// (9) and (10) on random vectors; with constraints alone, Q = I - M^-1 K S^-1 K' is a projector, symmetric in M, and
  /// K'Q = 0.
  double normal_identity = none;
  /// (15) on random vectors; with constraints alone, K Gamma^-1 K' is the orthogonal projector onto N; with coordinates
  /// alone, the same holds of A H^-1 A'M.
  double tangent_identity = none;
  double bases_orthogonal = none;  ///< K'A = 0 (3)
  double orthogonality = none;     ///< w_T'M w_N = 0, if all masses are equal (36)
  /// K'w + phi = 0 with K and phi from the second definition; M w = f + K lambda; A'(M w - f) = 0 (with friction, f +
  /// tau in place of f); w is the second derivative of r(q(t), t); inverse dynamics finds eta and no control force.
  double residual = none;
  double forms_agree = none;  ///< w and eta by A and by K; NaN if one of them is not given
  /// With constraints alone, w and lambda by a QR of M^-1/2 K, or by Cholesky in another order if R would take too much
  /// memory.
  double second_factorization = none;
  double power_balance = none;  ///< eta'v = -lambda'xi_t
  /// tau obeys its law, read again from the system, at lambda (41); sticking contacts stay at rest and below mu_s |N|;
  /// (43) by its three blocks.
  double friction = none;
  double reciprocal_condition = none;  ///< smaller one of the scaled S and H

  std::vector<CertificateCheck> checks;  ///< all of the above, one by one
  std::vector<std::string> left_out;     ///< checks that were not possible, and why: "second factorization: …"

  TANOR_API bool passed() const;
  /// Returns the largest error of all checks.
  TANOR_API double certified_to() const;
  /// Returns "certified to 3.1e-13", or "not certified: Newton's law fails by 1.2e-4 at point 17 (rounding explains
  /// 1e-11)".
  TANOR_API std::string line() const;
};

}  // namespace tanor
