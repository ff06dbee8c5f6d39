#pragma once

#include "base/block3.hpp"

namespace tanor::detail {

/// Solves the problem of one contact exactly: u = W r + q with K_mu, see ConeProblem. `guess` is its last r. If
/// friction changes the normal force so much that several r serve, it returns the one that slides in the direction next
/// to that of the guess; if none does, W_nn <= mu |W_nt|, and it returns the guess.
Vec3 solve_one_contact(const Block3& W, Vec3 q, double mu, Vec3 guess);

}  // namespace tanor::detail
