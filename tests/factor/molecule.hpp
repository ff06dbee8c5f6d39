#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "base/vec3.hpp"
#include "factor/sparse_qr.hpp"
#include "scene/imported.hpp"

/// \file Gradients of a molecule's rigid bonds and angles.
namespace tanor::patterns {
using namespace detail;

/// Returns C = M^-1/2 K with columns of unit length, first bonds and then angles as in the file. Nothing is periodic.
inline SparseColumns gradients_of(const scene::Imported& data) {
  SparseColumns C;
  C.num_rows = static_cast<int>(3 * data.positions.size());
  const auto place = [&](int atom) {
    const Vector3& r = data.positions[static_cast<std::size_t>(atom)];
    return Vec3{r[0], r[1], r[2]};
  };
  struct Gradient {
    int atom;
    Vec3 value;
  };
  const auto append = [&](auto gradients) {
    std::ranges::sort(gradients, {}, &Gradient::atom);
    double square = 0.0;
    for (Gradient& g : gradients) {
      g.value = (1.0 / std::sqrt(data.masses[static_cast<std::size_t>(g.atom)])) * g.value;
      square += dot(g.value, g.value);
    }
    for (const Gradient& g : gradients) {
      const Vec3 value = (1.0 / std::sqrt(square)) * g.value;
      C.rows.insert(C.rows.end(), {3 * g.atom, 3 * g.atom + 1, 3 * g.atom + 2});
      C.values.insert(C.values.end(), {value.x, value.y, value.z});
    }
    C.start.push_back(static_cast<int>(C.rows.size()));
  };
  for (const auto& bond : data.bonds) {
    const auto [i, j] = bond.atoms;
    const Vec3 d = place(i) - place(j);
    append(std::array{Gradient{i, d}, Gradient{j, -1.0 * d}});
  }
  for (const auto& angle : data.angles) {
    const auto [i, corner, k] = angle.atoms;
    // xi = a'b / (|a| |b|)
    const Vec3 a = place(i) - place(corner), b = place(k) - place(corner);
    const double length_a = norm(a), length_b = norm(b), cosine = dot(a, b) / (length_a * length_b);
    const Vec3 of_i = (1.0 / length_a) * ((1.0 / length_b) * b - (cosine / length_a) * a),
               of_k = (1.0 / length_b) * ((1.0 / length_a) * a - (cosine / length_b) * b);
    append(std::array{Gradient{i, of_i}, Gradient{corner, -1.0 * (of_i + of_k)}, Gradient{k, of_k}});
  }
  return C;
}

}  // namespace tanor::patterns
