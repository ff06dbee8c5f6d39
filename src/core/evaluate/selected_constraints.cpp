#include "evaluate/constraints.hpp"

/// \file The evaluations of Constraints for selected members.
namespace tanor::detail {

Constraints::Selection Constraints::select(std::span<const char> takes_part) const {
  const auto select_of = [&](const auto& family) {
    IndexRanges members;
    for (std::size_t k = 0; k < family.size(); ++k) {
      if (takes_part[static_cast<std::size_t>(family.rows[k])] != 0) members.append(k);
    }
    return members;
  };
  return std::apply([&](const auto&... family) { return Selection{select_of(family)...}; }, families_);
}

bool Constraints::gradients_are_constant(const Selection& some) const {
  return largest(some, [&](const auto& family, const IndexRanges&) {
           return family.kernel.gradients_are_constant() ? 0.0 : 1.0;
         }) == 0.0;
}

double Constraints::evaluate_values(const Parallel& parallel, const Selection& some, const double* r,
                                    double* xi) const {
  return largest(some, [&](const auto& family, const IndexRanges& members) {
    return family.evaluate_values(parallel, members, r, xi);
  });
}

double Constraints::evaluate_rates(const Parallel& parallel, const Selection& some, const double* r, const double* v,
                                   double* rate) const {
  return largest(some, [&](const auto& family, const IndexRanges& members) {
    return family.evaluate_rates(parallel, members, r, v, rate);
  });
}

void Constraints::evaluate_gradients(const Parallel& parallel, const Selection& some, const double* r,
                                     double* blocks) const {
  (void)largest(some, [&](const auto& family, const IndexRanges& members) {
    family.evaluate_gradients(parallel, members, r, blocks);
    return 0.0;
  });
}

double Constraints::evaluate_right_side(const Parallel& parallel, const Selection& some, const double* r,
                                        const double* v, const double* w0, double* phi, double* blocks) const {
  return largest(some, [&](const auto& family, const IndexRanges& members) {
    return blocks != nullptr ? family.template evaluate_right_side<true>(parallel, members, r, v, w0, phi, blocks)
                             : family.template evaluate_right_side<false>(parallel, members, r, v, w0, phi, blocks);
  });
}

double Constraints::apply_transposed(const Parallel& parallel, const Selection& some, const double* blocks,
                                     const double* x, const double* shift, double* y) const {
  return largest(some, [&](const auto& family, const IndexRanges& members) {
    return family.apply_transposed(parallel, members, blocks, x, shift, y);
  });
}

}  // namespace tanor::detail
