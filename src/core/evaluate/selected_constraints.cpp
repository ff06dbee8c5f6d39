#include "evaluate/constraints.hpp"

/// \file The evaluations of Constraints for selected members.
namespace tanor::detail {

namespace {

template <class F>
std::vector<Index> rows_of(const F& family) {
  return family.rows;
}
std::vector<Index> rows_of(const UserFamily& family) {
  std::vector<Index> result;
  for (const UserGroup& group : family.kernel.groups) result.insert(result.end(), group.rows.begin(), group.rows.end());
  return result;
}

}  // namespace

Constraints::Selection Constraints::select(std::span<const char> takes_part) const {
  const auto select_of = [&](const auto& family) {
    IndexRanges members;
    const std::vector<Index> rows = rows_of(family);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (takes_part[static_cast<std::size_t>(rows[k])] != 0) members.append(k);
    }
    return members;
  };
  return std::apply([&](const auto&... family) { return Selection{select_of(family)...}; }, families_);
}

bool Constraints::gradients_are_constant(const Selection& some) const {
  bool result = true;
  for_each_family(
      some, [&](const auto& family, const IndexRanges&) { result = result && family.kernel.gradients_are_constant(); });
  return result;
}

double Constraints::evaluate_values(const Parallel& parallel, const Selection& some, const double* r,
                                    double* xi) const {
  double worst = 0.0;
  for_each_family(some, [&](const auto& family, const IndexRanges& members) {
    worst = larger(worst, family.evaluate_values(parallel, members, r, xi));
  });
  return worst;
}

double Constraints::evaluate_rates(const Parallel& parallel, const Selection& some, const double* r, const double* v,
                                   double* rate) const {
  double worst = 0.0;
  for_each_family(some, [&](const auto& family, const IndexRanges& members) {
    worst = larger(worst, family.evaluate_rates(parallel, members, r, v, rate));
  });
  return worst;
}

void Constraints::evaluate_gradients(const Parallel& parallel, const Selection& some, const double* r,
                                     double* blocks) const {
  for_each_family(some, [&](const auto& family, const IndexRanges& members) {
    family.evaluate_gradients(parallel, members, r, blocks);
  });
}

double Constraints::evaluate_right_side(const Parallel& parallel, const Selection& some, const double* r,
                                        const double* v, const double* w0, double* phi, double* blocks) const {
  double worst = 0.0;
  for_each_family(some, [&](const auto& family, const IndexRanges& members) {
    const double largest = blocks != nullptr
                               ? family.template evaluate_right_side<true>(parallel, members, r, v, w0, phi, blocks)
                               : family.template evaluate_right_side<false>(parallel, members, r, v, w0, phi, blocks);
    worst = larger(worst, largest);
  });
  return worst;
}

double Constraints::apply_transposed(const Parallel& parallel, const Selection& some, const double* blocks,
                                     const double* x, const double* shift, double* y) const {
  double worst = 0.0;
  for_each_family(some, [&](const auto& family, const IndexRanges& members) {
    worst = larger(worst, family.apply_transposed(parallel, members, blocks, x, shift, y));
  });
  return worst;
}

}  // namespace tanor::detail
