#pragma once

#include "schur/findings.hpp"

/// \file Closed form of S of points on guides, eight points at once. Arrays are [group of eight], or [row][group] for
/// the rows of points. See instruction_sets.hpp.
namespace tanor::detail {

/// The factor G'G = L D L' of the gradients of a point with two or three rows: L below the diagonal, and 1/D on it.
struct PointFactor {
  Pack<> at[3][3];
};

/// So many groups of consecutive points, with plain arrays of their numbers.
struct PointGroups {
  std::size_t count;
  const double *inverse_mass, *r = nullptr, *v = nullptr, *w0 = nullptr;
  const Vec3* uniform = nullptr;  ///< if not null, w0 of all points
  double* w = nullptr;            ///< may be w0
};

/// Centers or normals of guides [group], or, with a stride of 0, of the one guide that all points are on.
struct OfGuides {
  const Pack3<>* each;
  std::size_t stride;
  const Pack3<>& operator[](std::size_t group) const { return each[group * stride]; }
};

/// Evaluates gradients and phi of points on spheres: u = a/|a|, phi = (v.v - (u.v)^2)/|a| with a = r - center.
void evaluate_spheres(const PointGroups& points, const OfGuides& centers, Pack3<>* gradients, Pack<>* phi);
/// Evaluates those of points on circles: the same in the plane of the normal; the first row is the plane's.
void evaluate_circles(const PointGroups& points, const OfGuides& centers, const OfGuides& normals, Pack3<>* gradients,
                      Pack<>* phi);

/// Factorizes G'G; points of one row need no factor. Then, if `phi` is not null, computes lambda := -m (G'G)^-1 b with
/// b = phi + K'w0, and w := w0 + G lambda/m.
void solve_points(std::size_t num_rows, const PointGroups& points, const Pack3<>* gradients, const Pack<>* phi,
                  PointFactor* factors, Pack<>* lambda, lanes::Findings* found);
/// Computes lambda := -m (G'G)^-1 b with the factor that there is.
void substitute_points(std::size_t num_rows, const PointGroups& points, const PointFactor* factors, const Pack<>* b,
                       Pack<>* lambda);

}  // namespace tanor::detail
