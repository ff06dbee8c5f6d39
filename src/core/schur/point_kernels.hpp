#pragma once

#include "schur/lane_transfers.hpp"

/// \file Closed form of S of points on guides that stand still, eight points at once. Arrays are [group of eight], or
/// [row][group] for the rows of points. Arrays of plain numbers are those of consecutive points. See
/// instruction_sets.hpp.
namespace tanor::detail {

/// The factor G'G = L D L' of a point's gradients: the entries of L below the diagonal, and 1/D; [group].
struct PointFactor {
  Pack<> l10, l20, l21, inverse_d0, inverse_d1, inverse_d2;
};

/// Centers or normals of guides [group], or, with a stride of 0, of the one guide that all points are on.
struct OfGuides {
  const Pack3<>* each;
  std::size_t stride;
  const Pack3<>& operator[](std::size_t group) const { return each[group * stride]; }
};

/// Evaluates gradients and phi of points on spheres: u = a/|a|, phi = (v.v - (u.v)^2)/|a| with a = r - center.
void evaluate_spheres(std::size_t count, const double* r, const double* v, const OfGuides& centers, Pack3<>* gradients,
                      Pack<>* phi);
/// Evaluates those of points on circles: the same in the plane of the normal; the first row is the plane's.
void evaluate_circles(std::size_t count, const double* r, const double* v, const OfGuides& centers,
                      const OfGuides& normals, Pack3<>* gradients, Pack<>* phi);

/// Factorizes G'G. `smallest` becomes the least of itself and of the pivots of unit gradients; 0 if there is no factor.
void factorize_points(int num_rows, std::size_t count, const Pack3<>* gradients, PointFactor* factors,
                      Pack<>* smallest);

/// Computes x := -(G'G)^-1 b.
void solve_points(int num_rows, std::size_t count, const PointFactor* factors, const Pack<>* b, Pack<>* x);

/// Computes b := phi + K'w0 in the place of phi. `uniform`, if it is not null, is w0 of all points.
void add_free(int num_rows, std::size_t count, const Pack3<>* gradients, const double* w0, const Vec3* uniform,
              Pack<>* phi, Largest* largest);
/// Computes w := w0 + G x and the largest |G'Gx + b|; w may be w0.
void add_reactions(int num_rows, std::size_t count, const Pack3<>* gradients, const Pack<>* b, const Pack<>* x,
                   const double* w0, const Vec3* uniform, double* w, Largest* largest);
/// Computes x := m x.
void scale_by_mass(int num_rows, std::size_t count, const double* inverse_mass, Pack<>* x);

/// Does all of this at once for points of one row.
void solve_single_rows(std::size_t count, const Pack3<>* gradients, const Pack<>* phi, const double* inverse_mass,
                       const double* w0, const Vec3* uniform, double* lambda, double* w, Largest* right_side,
                       Largest* residual);

}  // namespace tanor::detail
