#pragma once

#include "schur/batch_kernels.hpp"

/// \file Points on guides that stand still, and the closed form of S of each: eight points at once, arrays [group of
/// eight]; those of a point's rows one after the other, [row][group]. Plain numbers are of points that follow one
/// another. See instruction_sets.hpp.
namespace tanor {

/// G'G = L D L' of a point's gradients: what lies below the diagonal of L, and 1/D; [group].
struct PointFactor {
  Eight l10, l20, l21, inverse_d0, inverse_d1, inverse_d2;
};

/// Centers and normals of guides [group], or, with a stride of 0, of the one that all are on.
struct OfGuides {
  const Eight3* each;
  std::size_t stride;
  const Eight3& operator[](std::size_t group) const { return each[group * stride]; }
};

/// Gradients and phi of points on spheres: u = a/|a|, phi = (v.v - (u.v)^2)/|a| with a = r - center.
void evaluate_spheres(std::size_t count, const double* r, const double* v, const OfGuides& centers, Eight3* gradients,
                      Eight* phi);
/// On circles: the same in the plane of the normal; the first row is the plane's.
void evaluate_circles(std::size_t count, const double* r, const double* v, const OfGuides& centers,
                      const OfGuides& normals, Eight3* gradients, Eight* phi);

/// `smallest` := the least of it and of the pivots of unit gradients; 0 where there is no factor.
void factorize_points(int num_rows, std::size_t count, const Eight3* gradients, PointFactor* factors, Eight* smallest);

/// x := -(G'G)^-1 b
void solve_points(int num_rows, std::size_t count, const PointFactor* factors, const Eight* b, Eight* x);

/// b := phi + K'w0 in the place of phi; `uniform`, where it is not null, is w0 of all.
void add_free(int num_rows, std::size_t count, const Eight3* gradients, const double* w0, const Vec3* uniform,
              Eight* phi, Largest* largest);
/// w := w0 + G x, and the largest of |G'Gx + b|; w may be w0.
void add_reactions(int num_rows, std::size_t count, const Eight3* gradients, const Eight* b, const Eight* x,
                   const double* w0, const Vec3* uniform, double* w, Largest* largest);
/// x := m x
void scale_by_mass(int num_rows, std::size_t count, const double* inverse_mass, Eight* x);

/// All of that for points of one row, at once.
void solve_single_rows(std::size_t count, const Eight3* gradients, const Eight* phi, const double* inverse_mass,
                       const double* w0, const Vec3* uniform, double* lambda, double* w, Largest* right_side,
                       Largest* residual);

}  // namespace tanor
