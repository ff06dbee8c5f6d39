#pragma once

#include "dynamics/model.hpp"

namespace tanor::detail {

/// Moves points of next to no mass so that they obey their rows: adds to dw [3n] what takes the residual `rows` [d], of
/// the form K'dw + b, away. `blocks` is K.
///
/// Such points follow the others, on which they have no influence: dw_i is the smallest with K_i'dw_i = -rows, point by
/// point (Gauss and Seidel). M^-1 K lambda loses these accelerations, since m_i^-1 multiplies the last digits of
/// lambda. Returns false if there are no such points.
bool settle_light_points(const Model& model, const double* blocks, double* rows, double* dw);

}  // namespace tanor::detail
