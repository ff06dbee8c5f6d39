#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "base/pack.hpp"
#include "evaluate/rod_series.hpp"

namespace tanor::detail {

/// The numbers of paths in lanes. A thread needs as many of them as its longest paths have.
template <std::size_t lanes>
struct PathNumbers {
  using Lane = Pack<lanes>;
  using Vector = Pack3<lanes>;

  using Known = typename RodSeries<lanes>::Known;
  using Coefficient = typename RodSeries<lanes>::Coefficient;

  struct Rod {
    Vector u;                       // a_0/|a_0|; 0 where there is no rod
    Lane inverse_length, is_there;  // 1/|a_0|; 1 or 0
    Lane inverse_pivot, l, spike;   // S = L D L': 1/D; L of the next row, and of the separator before
    Lane half_square, x;            // of the current order: half of a.a, if it is refined; the unknown
    Known next;                     // that of the next order
  };
  struct Point {
    Lane inverse_mass;
    Vector r;  // that of the current order
  };
};

/// Paths in lanes and their series; see PathSeries and RodLanes. If `is_cut` is true, the lanes are pieces of one path,
/// which are joined by the last rod of each, the separators.
template <std::size_t lanes, bool is_cut>
struct PathLanes {
  static constexpr std::size_t width = lanes;
  static constexpr bool are_one_path = is_cut;
  using Numbers = PathNumbers<width>;
  using Lane = typename Numbers::Lane;
  using Vector = typename Numbers::Vector;
  using Known = typename Numbers::Known;
  using Rod = typename Numbers::Rod;
  using Point = typename Numbers::Point;
  using Coefficient = typename Numbers::Coefficient;

  std::size_t length;                      // rods a lane
  std::size_t stride;                      // coefficients a rod
  Rod* rods;                               // [length]
  Point* points;                           // [length + 1]; if cut, the last one is the first of the next lane
  Coefficient* series;                     // [length][stride]
  const Vector* offsets;                   // [length] part of a_0; null if there are none
  std::array<double, width>* separator_l;  // L of the tridiagonal system of the separators
  std::array<double, width>* separator_inverse_pivot;

  [[gnu::always_inline]] static Lane from_before(const Lane& x) {  // lane s gets that of s - 1
    if constexpr (is_cut) {
      return __builtin_shufflevector(x, Lane{}, 8, 0, 1, 2, 3, 4, 5, 6);
    } else {
      return Lane{};
    }
  }
  [[gnu::always_inline]] static Lane from_next(const Lane& x) {  // lane s gets that of s + 1
    if constexpr (is_cut) {
      return __builtin_shufflevector(x, Lane{}, 1, 2, 3, 4, 5, 6, 7, 8);
    } else {
      return Lane{};
    }
  }
  [[gnu::always_inline]] static Vector from_before(const Vector& a) {
    return {from_before(a.x), from_before(a.y), from_before(a.z)};
  }
  [[gnu::always_inline]] static Vector from_next(const Vector& a) {
    return {from_next(a.x), from_next(a.y), from_next(a.z)};
  }
  /// Returns 1 in lanes whose last point is not the first one of the next lane, else 0.
  [[gnu::always_inline]] static Lane ends() {
    Lane result = Lane{} + 1.0;
    for (std::size_t s = 0; is_cut && s + 1 < width; ++s) result[s] = 0.0;
    return result;
  }

  /// Computes a_k from the points' r.
  [[gnu::always_inline]] void take_coefficient(std::size_t k) const {
    for (std::size_t i = 0; i < length; ++i) {
      Vector a = points[i + 1].r - points[i].r;
      if (k == 0 && offsets != nullptr) a = a + offsets[i];
      series[i * stride + k].a = rods[i].is_there * a;
    }
  }

  /// Computes u, mu_0 = lambda_0/|a_0| and S = L D L' from a_0 and from lambda_0 in the place of mu_0.
  [[gnu::always_inline]] void begin() const {
    for (std::size_t i = 0; i < length; ++i) {
      Rod& rod = rods[i];
      Coefficient& first = series[i * stride];
      std::array<double, width> root;
      const Lane square = dot(first.a, first.a) + (1.0 - rod.is_there);
      for (std::size_t s = 0; s < width; ++s) root[s] = std::sqrt(square[s]);
      Lane norm;
      std::memcpy(&norm, root.data(), sizeof(norm));
      rod.inverse_length = rod.is_there / norm;
      rod.u = rod.inverse_length * first.a;
      first.mu = first.mu * rod.inverse_length;
    }
    factorize();
  }

  [[gnu::always_inline]] void factorize() const {
    const Rod& last = rods[length - 1];
    // S_ab of neighbours = -u_a.u_b/m of the point between them
    Lane e = -dot(from_before(last.u), rods[0].u) * from_before(points[length].inverse_mass);
    Lane taken{}, below{}, l{};  // subtracted from the separator before; S and L of the row before
    for (std::size_t i = 0; i < length; ++i) {
      Rod& rod = rods[i];
      Lane pivot = points[i].inverse_mass + points[i + 1].inverse_mass + (1.0 - rod.is_there) - l * below;
      if (is_cut && i + 1 == length) return factorize_separators(pivot - from_next(taken), e);
      rod.inverse_pivot = 1.0 / pivot;
      if (i + 1 == length) return;
      below = -dot(rod.u, rods[i + 1].u) * points[i + 1].inverse_mass;
      rod.l = l = below * rod.inverse_pivot;
      rod.spike = e * rod.inverse_pivot;
      taken += e * rod.spike;
      e = -l * e;
    }
  }

  [[gnu::always_inline]] void factorize_separators(const Lane& diagonal, const Lane& with_before) const {
    auto &l = *separator_l, &inverse_pivot = *separator_inverse_pivot;
    inverse_pivot[0] = 1.0 / diagonal[0];
    for (std::size_t s = 1; s < width; ++s) {
      l[s] = with_before[s] * inverse_pivot[s - 1];
      inverse_pivot[s] = 1.0 / (diagonal[s] - l[s] * with_before[s]);
    }
  }
  [[gnu::always_inline]] void solve_separators(Lane* x) const {
    const auto &l = *separator_l, &inverse_pivot = *separator_inverse_pivot;
    std::array<double, width> y;
    y[0] = (*x)[0];
    for (std::size_t s = 1; s < width; ++s) y[s] = (*x)[s] - l[s] * y[s - 1];
    y[width - 1] *= inverse_pivot[width - 1];
    for (std::size_t s = width - 1; s-- > 0;) y[s] = y[s] * inverse_pivot[s] - l[s + 1] * y[s + 1];
    for (std::size_t s = 0; s < width; ++s) (*x)[s] = y[s];
  }

  [[gnu::always_inline]] static Known multiply(const Coefficient* c, int k, Rod* rod) {
    return RodSeries<lanes>::multiply(c, k, &rod->next);
  }

  /// Computes r_{k+2} into the points, and a_{k+2} and mu_k into the series. `passes` above 1 refine where S is
  /// ill-conditioned. Calls done(i) for the points between the ends of the lanes from the last to the first.
  template <class Done>
  [[gnu::always_inline]] void advance(int k, int passes, const Done& done) const {
    const double inverse_factor = (k + 1.0) * (k + 2.0);
    begin_order(k, 1.0 / inverse_factor, passes > 1);
    for (int pass = 0; pass < passes; ++pass) {
      if (pass > 0) eliminate();
      substitute(k, inverse_factor, pass > 0, done);
    }
  }

  /// Computes factor M^-1 (force of the rod before - force of the rod behind), which is r_{k+2} without the part of
  /// mu_k, and eliminates forwards in
  ///
  ///   S x = -(half_square/|a_0| + u.(r_{i+1} - r_i))
  [[gnu::always_inline]] void begin_order(int k, double factor, bool keeps_squares) const {
    const Known last = multiply(series + (length - 1) * stride, k, rods + length - 1);
    Known here = length > 1 ? multiply(series, k, rods) : last;
    Vector r = (factor * points[0].inverse_mass) * (from_before(last.force) - here.force);
    r.write(&points[0].r);
    points[length].r = (factor * ends() * points[length].inverse_mass) * last.force + from_next(r);
    Forwards forwards;
    const auto go_on = [&](std::size_t i, const Lane& half_square, const Vector& next) __attribute__((always_inline)) {
      if (keeps_squares) rods[i].half_square = half_square;
      eliminate(i, half_square, next - r, &forwards);
      r = next;
    };
    for (std::size_t i = 0; i + 1 < length; ++i) {
      const Known behind = i + 2 < length ? multiply(series + (i + 1) * stride, k, rods + i + 1) : last;
      const Vector next = (factor * points[i + 1].inverse_mass) * (here.force - behind.force);
      next.write(&points[i + 1].r);
      go_on(i, here.half_square, next);
      here = behind;
    }
    go_on(length - 1, last.half_square, points[length].r);
    finish(forwards);
  }

  struct Forwards {
    Lane sum{}, l{}, x{};
  };
  [[gnu::always_inline]] void eliminate(std::size_t i, const Lane& half_square, const Vector& difference,
                                        Forwards* at) const {
    Rod& rod = rods[i];
    rod.x = at->x = -(half_square * rod.inverse_length + dot(rod.u, difference)) - at->l * at->x;
    if (i + 1 == length) return;
    at->l = rod.l;
    at->sum += rod.spike * at->x;
  }
  [[gnu::always_inline]] void eliminate() const {
    Forwards forwards;
    for (std::size_t i = 0; i < length; ++i)
      eliminate(i, rods[i].half_square, points[i + 1].r - points[i].r, &forwards);
    finish(forwards);
  }
  /// Computes x of the last rods.
  [[gnu::always_inline]] void finish(const Forwards& forwards) const {
    Rod& last = rods[length - 1];
    if constexpr (is_cut) {
      last.x = forwards.x - from_next(forwards.sum);
      solve_separators(&last.x);
    } else {
      last.x = forwards.x * last.inverse_pivot;
    }
  }

  /// Substitutes backwards: x = factor lambda_k, r += M^-1 K x, mu_k and a_{k+2}.
  template <class Done>
  [[gnu::always_inline]] void substitute(int k, double inverse_factor, bool refines, const Done& done) const {
    const auto row = static_cast<std::size_t>(k);
    Rod& last = rods[length - 1];
    Point& end = points[length];
    const Lane separator = from_before(last.x);
    const Vector last_tension = last.x * last.u;
    end.r = end.r + (ends() * end.inverse_mass) * last_tension;
    const auto add = [refines](const Lane& part, Lane* mu) __attribute__((always_inline)) {
      *mu = refines ? *mu + part : part;
    };
    add(inverse_factor * last.x * last.inverse_length, &series[(length - 1) * stride + row].mu);
    Lane x = last.x;
    Vector tension = last_tension, behind = end.r;
    for (std::size_t i = length - 1; i-- > 0;) {
      Rod& rod = rods[i];
      x = rod.x * rod.inverse_pivot - rod.spike * separator - rod.l * x;
      const Vector before = x * rod.u;
      Point& point = points[i + 1];
      const Vector r = point.r + point.inverse_mass * (before - tension);
      r.write(&point.r);
      add(inverse_factor * x * rod.inverse_length, &series[i * stride + row].mu);
      series[(i + 1) * stride + row + 2].a = rods[i + 1].is_there * (behind - r);
      behind = r;
      tension = before;
      done(i + 1);
    }
    points[0].r = points[0].r + points[0].inverse_mass * (from_before(last_tension) - tension);
    end.r = (1.0 - ends()) * from_next(points[0].r) + ends() * end.r;
    series[row + 2].a = rods[0].is_there * (points[1].r - points[0].r);
    series[(length - 1) * stride + row + 2].a = last.is_there * (end.r - points[length - 1].r);
  }
};

}  // namespace tanor::detail
