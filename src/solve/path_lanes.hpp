#pragma once

#include <array>
#include <cstddef>

namespace tanor {

// Functions that take or return lanes are all inlined: there is no binary interface to keep.
#pragma GCC diagnostic ignored "-Wpsabi"

/// The same number of `width` rods or points, side by side; aligned, or each load would touch two cache lines.
template <std::size_t width>
struct LaneOf;
template <>
struct LaneOf<8> {
  using Type = double __attribute__((vector_size(64), aligned(64)));
};
template <>
struct LaneOf<2> {
  using Type = double __attribute__((vector_size(16), aligned(16)));
};

/// Three components.
template <std::size_t width>
struct Lane3 {
  using Lane = typename LaneOf<width>::Type;
  Lane x, y, z;

  [[gnu::always_inline]] friend Lane3 operator+(const Lane3& a, const Lane3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  [[gnu::always_inline]] friend Lane3 operator-(const Lane3& a, const Lane3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  [[gnu::always_inline]] friend Lane3 operator*(const Lane& s, const Lane3& a) { return {s * a.x, s * a.y, s * a.z}; }
  [[gnu::always_inline]] friend Lane dot(const Lane3& a, const Lane3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
};

/// Paths in lanes and their series, see PathSeries and RodLanes. `is_cut`: the lanes are pieces of one path, which are
/// joined by the last rod of each, the separators.
template <std::size_t width, bool is_cut>
struct PathLanes {
  using Lane = typename LaneOf<width>::Type;
  using Vector = Lane3<width>;

  struct Rod {
    Vector u;                       // a_0/|a_0|; 0 where there is no rod
    Lane inverse_length, is_there;  // 1/|a_0|; 1 or 0
    Lane inverse_pivot, l, spike;   // S = L D L': 1/D; L of the next row, and of the separator before
    Vector force;                   // of the order under work: what is known of it
    Lane half_square, x;            // likewise: of a.a; right-hand side, then the unknown
  };
  struct Point {
    Lane inverse_mass;
    Vector r;  // of the order under work
  };
  struct Coefficient {
    Vector a;
    Lane mu;
  };

  std::size_t length;                      // rods a lane
  std::size_t stride;                      // coefficients a rod
  Rod* rods;                               // [length]
  Point* points;                           // [length + 1]; where cut, the last one is the first of the next lane
  Coefficient* series;                     // [length][stride]
  std::array<double, width>* separator_l;  // of the tridiagonal system of the separators
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
  /// 1 where the last point is not the next lane's first.
  [[gnu::always_inline]] static Lane ends() {
    Lane result = Lane{} + 1.0;
    for (std::size_t s = 0; is_cut && s + 1 < width; ++s) result[s] = 0.0;
    return result;
  }

  [[gnu::always_inline]] void factorize() const {
    const Rod& last = rods[length - 1];
    // S_ab of neighbours = -u_a.u_b/m of the point between them
    Lane e = -dot(from_before(last.u), rods[0].u) * from_before(points[length].inverse_mass);
    Lane taken{}, below{}, l{};  // from the separator before; S and L of the row before
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

  /// sum over j = 1 … k of a_j mu_{k-j}, and half the coefficient k + 2 of a.a without a_{k+2}.
  [[gnu::always_inline]] static void multiply(const Coefficient* c, int k, Rod* rod) {
    Lane x{}, y{}, z{}, square{};
    int j = 1;
    // a_j.a_{k+2-j} for j = 1 … k + 1, each pair once
    for (; 2 * j < k + 2; ++j) {
      const Vector a = c[j].a;
      const Lane mu = c[k - j].mu;
      square += dot(a, c[k + 2 - j].a);
      x += a.x * mu;
      y += a.y * mu;
      z += a.z * mu;
    }
    if (2 * j == k + 2) square += 0.5 * dot(c[j].a, c[j].a);
    for (; j <= k; ++j) {
      const Lane mu = c[k - j].mu;
      x += c[j].a.x * mu;
      y += c[j].a.y * mu;
      z += c[j].a.z * mu;
    }
    rod->force = {x, y, z};
    rod->half_square = square;
  }

  /// r_{k+2} into the points; a_{k+2} and mu_k into the series. `passes` above 1 refine where S is ill-conditioned.
  [[gnu::always_inline]] void advance(int k, int passes) const {
    const double inverse_factor = (k + 1.0) * (k + 2.0), factor = 1.0 / inverse_factor;
    for (std::size_t i = 0; i < length; ++i) multiply(series + i * stride, k, rods + i);

    // factor M^-1 (force of the rod before - force of the rod behind): r_{k+2} but for mu_k
    Point& end = points[length];
    Vector before = from_before(rods[length - 1].force);
    for (std::size_t i = 0; i < length; ++i) {
      points[i].r = (factor * points[i].inverse_mass) * (before - rods[i].force);
      before = rods[i].force;
      series[i * stride + static_cast<std::size_t>(k)].mu = Lane{};
    }
    end.r = (factor * ends() * end.inverse_mass) * before + from_next(points[0].r);
    for (int pass = 0; pass < passes; ++pass) {
      find_multipliers();
      add_reactions(k, inverse_factor);
    }
    for (std::size_t i = 0; i < length; ++i)
      series[i * stride + static_cast<std::size_t>(k) + 2].a = rods[i].is_there * (points[i + 1].r - points[i].r);
  }

  /// S x = -(half_square/|a_0| + u.(r_{i+1} - r_i)), forwards and backwards.
  [[gnu::always_inline]] void find_multipliers() const {
    Lane sum{}, l{}, x{};
    for (std::size_t i = 0; i < length; ++i) {
      Rod& rod = rods[i];
      x = -(rod.half_square * rod.inverse_length + dot(rod.u, points[i + 1].r - points[i].r)) - l * x;
      if (i + 1 == length) break;
      rod.x = x;
      l = rod.l;
      sum += rod.spike * x;
    }
    Rod& last = rods[length - 1];
    if constexpr (is_cut) {
      x -= from_next(sum);
      solve_separators(&x);
    } else {
      x *= last.inverse_pivot;
    }
    last.x = x;
    const Lane separator = from_before(x);
    for (std::size_t i = length - 1; i-- > 0;) {
      Rod& rod = rods[i];
      rod.x = x = rod.x * rod.inverse_pivot - rod.l * x - rod.spike * separator;
    }
  }

  /// r += M^-1 K x, and mu_k from x = factor lambda_k.
  [[gnu::always_inline]] void add_reactions(int k, double inverse_factor) const {
    const Rod& last = rods[length - 1];
    Point& end = points[length];
    Vector before = from_before(last.x * last.u);
    for (std::size_t i = 0; i < length; ++i) {
      const Vector tension = rods[i].x * rods[i].u;
      points[i].r = points[i].r + points[i].inverse_mass * (before - tension);
      before = tension;
      series[i * stride + static_cast<std::size_t>(k)].mu += inverse_factor * rods[i].x * rods[i].inverse_length;
    }
    const Vector of_next = from_next(points[0].r);
    end.r = (1.0 - ends()) * of_next + ends() * (end.r + end.inverse_mass * before);
  }
};

}  // namespace tanor
