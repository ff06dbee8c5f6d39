#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/block3.hpp"

namespace tanor::detail {

/// Contacts with Coulomb friction at one instant, in one step or in one impact:
///
///   u = W r + q,  K_mu contains r,  K_mu* contains u + mu |u_t| n,  r.(u + mu |u_t| n) = 0
///
/// r are forces or impulses, u are accelerations or velocities of the contacts, W = H'(M^-1 - M^-1 K S^-1 K'M^-1) H is
/// the Delassus operator with the bilateral constraints eliminated, and q is u without forces of contacts (Moreau 1988;
/// Jean 1999; Acary and Brogliato 2008).
struct ConeProblem {
  std::vector<double> friction;  ///< [contacts] mu >= 0
  std::vector<double> q;         ///< [3 contacts]
  /// W by rows of blocks: those of contact c are blocks[start[c]] … blocks[start[c + 1] - 1], columns increasing.
  std::vector<std::size_t> start{0};
  std::vector<int> columns;
  std::vector<Block3> blocks;

  std::size_t num_contacts() const { return friction.size(); }
  /// Computes u = W r + q of one contact, [3 contacts].
  Vec3 velocity(std::size_t contact, const double* r) const;
  /// Computes u = W r + q, [3 contacts].
  void find_velocities(const double* r, double* u) const;
  /// Returns the block of a contact on the diagonal.
  const Block3& own_block(std::size_t contact) const;
  /// Returns a third of the mean trace of the blocks on the diagonal; 1 without contacts.
  double scale() const;
};

/// Returns |r - P(r - u/a)| a/|q| with u as with_dilatancy() makes it, P the projection onto the cones, and a the
/// scale() of W. It is 0 at solutions alone, and does not depend on units. It is 0 if q is.
double error_of_contacts(const ConeProblem& problem, std::span<const double> r);

}  // namespace tanor::detail
