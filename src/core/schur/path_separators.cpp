#include "schur/path_separators.hpp"

#include <cmath>
#include <limits>

#include "base/numbers.hpp"

namespace tanor::detail::lanes {

template <class Visit>
void Separators::for_pairs(const Visit& visit) const {
  for (std::size_t q = is_ring_ ? 0 : 1; q < size(); ++q) visit(at(q > 0 ? q - 1 : size() - 1), at(q));
}

double Separators::factorize() const {
  constexpr double negligible = 1e-100;  // beside the first product; smaller spikes would become denormal
  const One front = at(0), last = at(size() - 1);
  front(&B::coupling) = 0.0;
  for_pairs([](const One& before, const One& own) {
    own(&B::coupling) = -own(&B::inverse_mass_before) * dot(before(&B::u), own(&B::first));
  });
  double largest = 1.0, of_last_row = 0.0, spike = 0.0;
  // Returns a pivot less the part of the piece behind it, whose coupling is 0 behind the last one of an open path.
  const auto pivot_of = [](const One& own, const One& next) {
    return own(&B::pivot) - next(&B::coupling) * next(&B::coupling) * next(&B::taken);
  };
  // Includes S_aa/pivot, infinite if the pivot is not positive or not a number.
  const auto invert = [&](double pivot, const One& own) {
    own(&B::inverse_pivot) = 1.0 / pivot;
    const double ratio = own(&B::diagonal) * own(&B::inverse_pivot);
    largest = larger(largest, ratio > 0.0 ? ratio : std::numeric_limits<double>::infinity());
  };
  for (std::size_t q = 0; q + 1 < size(); ++q) {
    const One own = at(q), next = at(q + 1);
    const double with_before = own(&B::coupling) * own(&B::spread);
    own(&B::l) = q > 0 ? with_before * at(q - 1)(&B::inverse_pivot) : 0.0;
    const double pivot = pivot_of(own, next);
    invert(q > 0 ? pivot - own(&B::l) * with_before : pivot, own);
    spike = q > 0 ? -own(&B::l) * spike : with_before;
    if (std::abs(spike) <= negligible * std::abs(front(&B::coupling))) spike = 0.0;
    own(&B::spike) = q + 2 < size() ? spike : spike + next(&B::coupling) * next(&B::spread);
    of_last_row += own(&B::spike) * own(&B::spike) * own(&B::inverse_pivot);
  }
  invert(pivot_of(last, front) - of_last_row, last);
  return largest;
}

void Separators::join_points() const {
  for_pairs([](const One& before, const One& own) {
    own.set(&B::r_joined, before(&B::r_behind));
    const double b = own(&B::joined) = -dot(own(&B::first), before(&B::r_behind));
    own(&B::y) -= own(&B::spread) * b;
    own(&B::taken_y) -= own(&B::taken) * b;
    before(&B::y) -= dot(before(&B::u), own(&B::r_before));
  });
}

void Separators::solve() const {
  const auto y_of = [](const One& own, const One& next) { return own(&B::y) - next(&B::coupling) * next(&B::taken_y); };
  const One last = at(size() - 1);
  double y = 0.0, of_last_row = 0.0;
  for (std::size_t q = 0; q + 1 < size(); ++q) {
    const One own = at(q);
    own(&B::x) = y = y_of(own, at(q + 1)) - own(&B::l) * y;
    of_last_row += own(&B::spike) * own(&B::inverse_pivot) * y;
  }
  const double x_of_last = last(&B::x) = (y_of(last, at(0)) - of_last_row) * last(&B::inverse_pivot);
  double l = 0.0, x = 0.0;
  for (std::size_t q = size() - 1; q-- > 0;) {
    const One own = at(q);
    own(&B::x) = x = (own(&B::x) - own(&B::spike) * x_of_last) * own(&B::inverse_pivot) - l * x;
    l = own(&B::l);
  }
  hand_on();
}

void Separators::hand_on() const {
  for_pairs([](const One& before, const One& own) {
    own(&B::b_of_first) = own(&B::coupling) * before(&B::x) + own(&B::joined);
    own.set(&B::force_before, before.force());
  });
}

double Separators::residual() const {
  double result = 0.0;
  const auto include = [&](const One& own, Vec3 behind) {
    result = larger(result, std::abs(dot(own(&B::u), behind - own(&B::dw_of_last)) + own(&B::b)));
  };
  for_pairs([&](const One& own, const One& next) { include(own, next(&B::dw_of_first)); });
  const One last = at(size() - 1);
  if (!is_ring_) include(last, last(&B::inverse_mass_behind) * last.force());
  return result;
}

}  // namespace tanor::detail::lanes
