#pragma once

#include <tanor/certificate.hpp>

#include "certificate/second_factor.hpp"
#include "dynamics/forms.hpp"

namespace tanor {

/// What is to be proven: an instant and what was found there, in the inner order.
struct Answer {
  double t;
  const std::vector<double>&r, &v, &w, &eta;  ///< [3n]
  const std::vector<double>& lambda;          ///< [rows]; of contacts: not looked at
  const std::vector<double>& tau;             ///< [3n] of all contacts, those that stick too
  const FrictionReport& friction;             ///< what was reported of it
};

/// There is no answer to prove.
Certificate make_failed_certificate(const Outcome& outcome);

/// Tries an answer with the forms' matrices and factors as they stand (the last accelerations were those of the
/// answer), and with second ways that share none of them; `way` of the second factorization.
Certificate certify(Forms& forms, const Answer& answer, SecondWay way = SecondWay::Auto);

}  // namespace tanor
