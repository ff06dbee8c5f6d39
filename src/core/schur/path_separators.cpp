#include "schur/path_separators.hpp"

#include <cmath>
#include <limits>

namespace tanor::detail {

namespace {

/// Returns what a separator has less the part of the piece behind it. The last one of an open path is followed by a
/// piece with a coupling of 0.
double pivot_of(const Separator& own, const Separator& next) {
  return own.pivot - next.coupling * next.coupling * next.taken;
}
double y_of(const Separator& own, const Separator& next) {
  return own.y - next.coupling * next.taken_y;
}

}  // namespace

double factorize_separators(std::span<Separator> separators, bool is_ring) {
  constexpr double negligible = 1e-100;  // beside the first product; smaller spikes would become denormal
  Separator &front = separators.front(), &last = separators.back();
  for (std::size_t q = 0; q < separators.size(); ++q) {
    Separator& own = separators[q];
    const Vec3 before = q > 0 ? separators[q - 1].u : is_ring ? last.u : Vec3{};
    own.coupling = -own.inverse_mass_before * dot(before, own.first);
  }
  double largest = 1.0, of_last_row = 0.0, spike = 0.0;
  // Includes S_aa/pivot, infinite if the pivot is not positive or not a number.
  const auto invert = [&](double pivot, Separator* own) {
    own->inverse_pivot = 1.0 / pivot;
    const double ratio = own->diagonal * own->inverse_pivot;
    largest = larger(largest, ratio > 0.0 ? ratio : std::numeric_limits<double>::infinity());
  };
  for (std::size_t q = 0; q + 1 < separators.size(); ++q) {
    Separator &own = separators[q], &next = separators[q + 1];
    const double with_before = own.coupling * own.spread;
    own.l = q > 0 ? with_before * separators[q - 1].inverse_pivot : 0.0;
    const double pivot = pivot_of(own, next);
    invert(q > 0 ? pivot - own.l * with_before : pivot, &own);
    spike = q > 0 ? -own.l * spike : with_before;
    if (std::abs(spike) <= negligible * std::abs(front.coupling)) spike = 0.0;
    own.spike = &next != &last ? spike : spike + next.coupling * next.spread;
    of_last_row += own.spike * own.spike * own.inverse_pivot;
  }
  invert(pivot_of(last, front) - of_last_row, &last);
  return largest;
}

void join_points(std::span<Separator> separators, bool is_ring) {
  for (std::size_t q = is_ring ? 0 : 1; q < separators.size(); ++q) {
    Separator &own = separators[q], &before = q > 0 ? separators[q - 1] : separators.back();
    own.b_of_first = -dot(own.first, before.r.behind);
    own.y -= own.spread * own.b_of_first;
    own.taken_y -= own.taken * own.b_of_first;
    before.y -= dot(before.u, own.r.before);
  }
}

void solve_separators(std::span<Separator> separators) {
  Separator& last = separators.back();
  double y = 0.0, of_last_row = 0.0;
  for (std::size_t q = 0; q + 1 < separators.size(); ++q) {
    Separator& own = separators[q];
    own.x = y = y_of(own, separators[q + 1]) - own.l * y;
    of_last_row += own.spike * own.inverse_pivot * y;
  }
  last.x = (y_of(last, separators.front()) - of_last_row) * last.inverse_pivot;
  double l = 0.0, x = 0.0;
  for (std::size_t q = separators.size() - 1; q-- > 0;) {
    Separator& own = separators[q];
    own.x = x = (own.x - own.spike * last.x) * own.inverse_pivot - l * x;
    l = own.l;
  }
}

double residual_of_separators(std::span<const Separator> separators, bool is_ring) {
  double result = 0.0;
  for (std::size_t q = 0; q < separators.size(); ++q) {
    const Separator& own = separators[q];
    const bool is_end = q + 1 == separators.size() && !is_ring;
    const Separator& next = q + 1 < separators.size() ? separators[q + 1] : separators.front();
    const Vec3 behind = is_end ? own.inverse_mass_behind * own.force() : next.dw.first;
    result = larger(result, std::abs(dot(own.u, behind - own.dw.last) + own.b));
  }
  return result;
}

}  // namespace tanor::detail
