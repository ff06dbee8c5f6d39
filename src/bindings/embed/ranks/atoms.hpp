#pragma once

#include <array>
#include <cstddef>
#include <span>

/// \file The common data of LAMMPS and its kin, in plain types, since this folder is compiled without their headers.
namespace tanor::embed {

/// Two atoms at a fixed distance. Atoms are given by their tags.
struct Bond {
  int a = 0, b = 0;  // a < b
  int type = 0;
  double length = 0.0;  // 0 if not known yet

  bool joins_as(const Bond& other) const { return a == other.a && b == other.b; }
};
inline bool operator<(const Bond& one, const Bond& other) {
  return one.a != other.a ? one.a < other.a : one.b < other.b;
}

/// The box. Atoms have images at r + a, r + b, r + c, along the edges that repeat. The z of a and b and the y of a are
/// 0.
struct Box {
  std::array<std::array<double, 3>, 3> edges{};
  std::array<bool, 3> repeats{};
};

/// The atoms of this rank, where the host has them at the time of a call.
struct Atoms {
  int count = 0;
  const int* tag = nullptr;
  const int* image = nullptr;  ///< three whole numbers of ten bits each: how often the atom has left the box
  double* x = nullptr;         ///< [3 count], inside the box; v and f likewise
  double* v = nullptr;
  double* f = nullptr;
  double* stress = nullptr;             ///< [6 count], in the order of a virial; null if nobody asks for it
  const double* masses = nullptr;       ///< [count], or null if the masses are those of types
  const double* type_masses = nullptr;  ///< [type]
  const int* type = nullptr;
  Box box{};

  std::span<const int> tags() const { return {tag, static_cast<std::size_t>(count)}; }
  double mass(int i) const { return masses != nullptr ? masses[i] : type_masses[type[i]]; }
  /// Prefetches the three numbers of atom i in x, v or f, which may lie across the border between two cache lines.
  static void fetch(const double* array, int i) {
    __builtin_prefetch(array + 3 * i);
    __builtin_prefetch(array + 3 * i + 2);
  }
  void fetch_position(int i) const {
    fetch(x, i);
    __builtin_prefetch(image + i);
  }
  /// Sets r [3] to the position of atom i as if it had never been put back into the box.
  void unwrap(int i, double* r) const {
    constexpr int bits = 10, mask = (1 << bits) - 1, middle = 1 << (bits - 1);
    const int flags = image[i];
    const double nx = (flags & mask) - middle, ny = (flags >> bits & mask) - middle, nz = (flags >> 2 * bits) - middle;
    const auto& [a, b, c] = box.edges;
    r[0] = x[3 * i] + nx * a[0] + ny * b[0] + nz * c[0];
    r[1] = x[3 * i + 1] + ny * b[1] + nz * c[1];
    r[2] = x[3 * i + 2] + nz * c[2];
  }
};

}  // namespace tanor::embed
