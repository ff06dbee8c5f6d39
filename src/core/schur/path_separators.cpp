#include "schur/path_separators.hpp"

#include <cmath>
#include <limits>

namespace tanor::detail {

namespace {

/// A separator without a successor, or the one that closes a ring, is followed by a piece that takes nothing.
const Separator nothing;

const Separator& behind_of(std::span<const Separator> all, std::size_t q, bool is_ring) {
  if (q + 1 < all.size()) return all[q + 1];
  return is_ring ? all.front() : nothing;
}

/// Returns S_aa/pivot, infinite if the pivot is not positive or not a number.
double check(const Separator& own) {
  const double ratio = own.diagonal * own.inverse_pivot;
  return ratio > 0.0 ? ratio : std::numeric_limits<double>::infinity();
}

}  // namespace

double factorize_separators(std::span<Separator> separators, bool is_ring) {
  constexpr double negligible = 1e-100;  // beside the first product; smaller spikes would become denormal
  for (std::size_t q = 0; q < separators.size(); ++q) {
    Separator& own = separators[q];
    const Vec3 before = q > 0 ? separators[q - 1].u : is_ring ? separators.back().u : Vec3{};
    own.coupling = -own.inverse_mass_before * dot(before, own.first);
  }
  double largest = 1.0, of_closing_row = 0.0, spike = 0.0;
  const std::size_t count = separators.size() - (is_ring ? 1 : 0);
  for (std::size_t q = 0; q < count; ++q) {
    Separator& own = separators[q];
    const Separator& next = behind_of(separators, q, is_ring);
    const double with_before = own.coupling * own.spread;
    own.l = q > 0 ? with_before * separators[q - 1].inverse_pivot : 0.0;
    const double pivot = own.pivot - next.coupling * next.coupling * next.taken;
    own.inverse_pivot = 1.0 / (q > 0 ? pivot - own.l * with_before : pivot);
    largest = larger(largest, check(own));
    if (!is_ring) continue;
    spike = q > 0 ? -own.l * spike : with_before;
    if (std::abs(spike) <= negligible * std::abs(separators.front().coupling)) spike = 0.0;
    own.spike = q + 1 < count ? spike : spike + next.coupling;
    of_closing_row += own.spike * own.spike * own.inverse_pivot;
  }
  if (is_ring) {
    Separator& own = separators.back();
    const Separator& next = separators.front();
    own.inverse_pivot = 1.0 / (own.pivot - next.coupling * next.coupling * next.taken - of_closing_row);
    largest = larger(largest, check(own));
  }
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

void solve_separators(std::span<Separator> separators, bool is_ring) {
  double y = 0.0, of_closing_row = 0.0;
  const std::size_t count = separators.size() - (is_ring ? 1 : 0);
  for (std::size_t q = 0; q < count; ++q) {
    Separator& own = separators[q];
    const Separator& next = behind_of(separators, q, is_ring);
    own.x = y = own.y - next.coupling * next.taken_y - own.l * y;
    of_closing_row += own.spike * own.inverse_pivot * y;
  }
  double closing = 0.0;
  if (is_ring) {
    Separator& own = separators.back();
    const Separator& next = separators.front();
    own.x = closing = (own.y - next.coupling * next.taken_y - of_closing_row) * own.inverse_pivot;
  }
  double l = 0.0, x = 0.0;
  for (std::size_t q = count; q-- > 0;) {
    Separator& own = separators[q];
    own.x = x = (own.x - own.spike * closing) * own.inverse_pivot - l * x;
    l = own.l;
  }
}

double residual_of_separators(std::span<const Separator> separators, bool is_ring) {
  double result = 0.0;
  for (std::size_t q = 0; q < separators.size(); ++q) {
    const Separator& own = separators[q];
    const bool is_end = q + 1 == separators.size() && !is_ring;
    const Vec3 behind = is_end ? own.inverse_mass_behind * own.force() : behind_of(separators, q, is_ring).dw.first;
    result = larger(result, std::abs(dot(own.u, behind - own.dw.last) + own.b));
  }
  return result;
}

}  // namespace tanor::detail
