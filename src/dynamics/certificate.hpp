#pragma once

#include <tanor/certificate.hpp>

#include "dynamics/forms.hpp"

namespace tanor {

/// What is to be proven: an instant and what was found there, in the inner order.
struct Answer {
  double t;
  const std::vector<double>&r, &v, &w, &eta;  ///< [3n]
  const std::vector<double>& lambda;          ///< [d]
};

/// There is no answer to prove.
Certificate make_failed_certificate(const Outcome& outcome);

/// Tries an answer with the forms' matrices and factors as they stand (the last accelerations were those of the
/// answer), and with second ways that share none of them.
Certificate certify(Forms& forms, const Answer& answer);

}  // namespace tanor
