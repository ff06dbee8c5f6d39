#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace tanor::detail {

/// Three numbers in registers, with the arithmetic that kernels need.
struct Vec3 {
  double x = 0.0, y = 0.0, z = 0.0;

  friend Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
  friend Vec3 operator*(double s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
};

inline double dot(Vec3 a, Vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline double squared(Vec3 a) {
  return dot(a, a);
}
inline double norm(Vec3 a) {
  return std::sqrt(squared(a));
}
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Returns point `i` of an array stored point by point.
template <class Integer>
inline Vec3 load(const double* array, Integer i) {
  const double* p = array + 3 * static_cast<std::size_t>(i);
  return {p[0], p[1], p[2]};
}
template <class Integer>
inline void store(double* array, Integer i, Vec3 a) {
  double* p = array + 3 * static_cast<std::size_t>(i);
  p[0] = a.x;
  p[1] = a.y;
  p[2] = a.z;
}
template <class Integer>
inline void add_to(double* array, Integer i, Vec3 a) {
  store(array, i, load(array, i) + a);
}
inline Vec3 make_vec3(const std::array<double, 3>& a) {
  return {a[0], a[1], a[2]};
}

}  // namespace tanor::detail
