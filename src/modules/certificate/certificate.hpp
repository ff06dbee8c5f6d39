#pragma once

#include <tanor/certificate.hpp>

#include "certificate/second_factor.hpp"
#include "dynamics/forms.hpp"

namespace tanor::detail {

/// The answer to be verified: an instant and what was found there, in the inner order.
struct Answer {
  double t;
  const std::vector<double>&r, &v, &w, &eta;  ///< [3n]
  const std::vector<double>& lambda;          ///< [rows]; rows of contacts are ignored
  const std::vector<double>& tau;             ///< [3n] of all contacts, including those that stick
  const FrictionReport& friction;             ///< what was reported of friction
};

/// Returns the certificate of a solve that found no answer.
Certificate make_failed_certificate(const Outcome& outcome);

/// Verifies an answer with the forms' present matrices and factors (the last accelerations were those of the answer),
/// and by a second evaluation and factorization, `by` which, that share none of them.
Certificate certify(Forms& forms, const Answer& answer, SecondFactorization by = SecondFactorization::Auto);

/// Does so for a system with one-sided constraints, without friction.
Certificate certify_one_sided(Forms& forms, const Answer& answer, SecondFactorization by);

}  // namespace tanor::detail
