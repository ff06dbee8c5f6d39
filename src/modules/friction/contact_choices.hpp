#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "dynamics/instant.hpp"
#include "friction/contact_problem.hpp"
#include "friction/contact_state.hpp"
#include "friction/friction_solver.hpp"

namespace tanor::detail {

/// An acceleration is rounding if it is smaller than this part of the terms that cancel in it.
inline constexpr double rounding_of_accelerations = 1e-9;
/// Friction that is nearer to its limit than this part of it is at the limit.
inline constexpr double rounding_of_limits = 1e-9;
/// Relative excess of friction over its limit that counts as rounding.
inline constexpr double limit_slack = 1e-12;

/// An instant at which the contacts at rest choose whether to stick or to slide.
struct ModeSwitch {
  double t;
  const double* r;                      ///< [3n]
  double* v;                            ///< [3n]; contacts that have come to rest are put to rest exactly
  AccelerationOutput to;                ///< [3n] accelerations of the new modes
  Request request;                      ///< the request for those accelerations
  std::vector<char> at_rest{};          ///< [contact]
  std::vector<std::size_t> releases{};  ///< contacts that stick and have reached their limit
  std::vector<char> has_changed{};      ///< [island] whose modes are to be chosen
  std::vector<char> passes{};           ///< [contact] that are at rest for this instant only
  std::vector<double> before{};         ///< [3n] velocities before contacts were put to rest

  /// Returns true at a start, where no earlier step tells which of several motions continues.
  bool is_start() const { return request.refuses_several; }
  std::size_t num_at_rest() const { return static_cast<std::size_t>(std::count(at_rest.begin(), at_rest.end(), 1)); }
  bool is_released(std::size_t contact) const {
    return std::find(releases.begin(), releases.end(), contact) != releases.end();
  }
};

/// The Coulomb contacts of one island, and the modes chosen for those at rest.
struct ContactChoice {
  std::size_t island = 0;
  std::vector<std::size_t> members;  ///< contacts
  std::vector<Vec3> directions;      ///< of the components of friction
  ContactProblem problem;
  Eigen::MatrixXd P;  ///< [3 contacts][k], P0 [3 contacts]: accelerations of the points, P0 + P x, m/s^2
  Eigen::VectorXd P0;
  double acceleration_scale = 1.0;  ///< m/s^2, the largest terms that cancel in their accelerations
  Eigen::VectorXd before;           ///< [k] friction at the last instant, if there was any
  ContactSolutions solutions;
  Eigen::VectorXd x;  ///< the solution that is taken; empty if there is none

  std::vector<char> sticks;  ///< [member] in the solution x
  Eigen::VectorXd share;     ///< x, with the load shared so that the contacts that stick have most to spare
  Eigen::VectorXd weights;   ///< [member] weights of changes of the share
  double load = std::numeric_limits<double>::quiet_NaN();  ///< the largest load of a member; NaN if the share is unique
  bool has_shared = false;                                 ///< modes and shares have been set from x

  std::size_t size() const { return members.size(); }
  bool has_solution() const { return x.size() > 0; }
  /// Returns the acceleration of the point of a member, m/s^2.
  Vec3 acceleration(std::size_t member, const Eigen::VectorXd& at) const {
    const auto row = 3 * static_cast<Eigen::Index>(member);
    const Eigen::Vector3d a = P0.segment<3>(row) + P.middleRows<3>(row) * at;
    return {a(0), a(1), a(2)};
  }
  /// Returns the components [k] of a member as a vector.
  Vec3 combine(std::size_t member, const Eigen::VectorXd& components) const {
    const ContactProblem::Contact& contact = problem.contacts[member];
    Vec3 sum{};
    for (Eigen::Index k = contact.first; k < contact.first + contact.dimension; ++k)
      sum = sum + components(k) * directions[static_cast<std::size_t>(k)];
    return sum;
  }
  /// Returns mu |N| of a member at x, N.
  double limit(std::size_t member, const Eigen::VectorXd& at) const { return problem.limit(member, at); }
  /// Returns true if a member at rest begins to move in the solution x.
  bool begins(std::size_t member) const { return !problem.contacts[member].moves && sticks[member] == 0; }
  /// Returns true if a member at rest bears at least the part `least` of its limit with the friction `given` [k].
  bool is_at_limit(std::size_t member, const Eigen::VectorXd& given, double least) const {
    const ContactProblem::Contact& contact = problem.contacts[member];
    return !contact.moves && given.segment(contact.first, contact.dimension).norm() > least * limit(member, given);
  }
  /// Returns true if all contacts are on curves and friction changes no reaction.
  bool keeps_reactions() const {
    constexpr double rounding = 1e-11;
    return std::ranges::all_of(problem.contacts, [](const auto& each) { return each.dimension == 1; }) &&
           problem.W.norm() <= rounding;
  }
  /// Returns the acceleration below which a contact counts as at rest, m/s^2: the rounding of the terms that cancel at
  /// x.
  double rest_threshold() const {
    return rounding_of_accelerations * std::max(acceleration_scale, problem.acceleration_scale(x));
  }
};

// ---- the reduction of islands to small dense problems (docs/friction.md) ----

/// Lists the islands among those `wanted` [island] that have Coulomb contacts, and at most `most_contacts` of them,
/// each with its contacts and their last friction. The friction solver must be set to this configuration.
std::vector<ContactChoice> list_islands(const ContactState& state, const FrictionSolver& friction, const ModeSwitch& at,
                                        const std::vector<char>& wanted, std::size_t most_contacts);
/// Computes N0, W, a0, A of each island, with the factor of S in which none of their contacts sticks. One solve serves
/// the first component of every island at once, one the second, and so on.
void reduce_islands(const ContactState& state, FrictionSolver& friction, const ModeSwitch& at,
                    std::vector<ContactChoice>* choices);
/// Writes the multipliers that belong to the chosen friction into `lambda()` of the system, as initial guess of later
/// iterations.
void guess_multipliers(const ContactState& state, FrictionSolver& friction, const ModeSwitch& at,
                       const std::vector<ContactChoice>& choices);

// ---- the choice which contacts at rest stick and which begin to slide ----

/// Counts the motions of the islands that are `wanted` [island] and have at most `most_contacts` contacts, and notes
/// the verdict. Sets the modes of those with a solution, and adds them to `choices` with what each has chosen and what
/// `take_choices` takes. If `takes_all` is true, islands that were not taken are dropped. At a start several motions
/// are refused.
Outcome count_motions(ContactState& state, FrictionSolver& friction, const ModeSwitch& at,
                      const std::vector<char>& wanted, std::size_t most_contacts, bool takes_all,
                      std::vector<ContactChoice>* choices);
/// Sets modes and shares from x where contacts that stick share their load, or everywhere if `all` is true. Contacts
/// without acceleration stick. Where no share leaves a contact anything to spare, all accelerations are still 0 and do
/// not tell yet which contacts will move. Such contacts are held until their load exceeds its limit by more than
/// rounding (`ContactState::overload`).
Outcome take_choices(ContactState& state, const ModeSwitch& at, bool all, std::vector<ContactChoice>* choices);
/// Adds the verdict on islands that were not counted. Their motion is unique where friction changes reactions little or
/// not at all (`is_proven_unique`).
Outcome verify_uncounted(ContactState& state, FrictionSolver& friction, const ModeSwitch& at,
                         const std::vector<char>& wanted);
/// Searches the islands that have changed by block pivoting for modes whose forces and accelerations are complementary:
/// sticking contacts hold no more than their limit, and sliding contacts do not move backwards. `choices` are the
/// islands that were solved as a whole; those that have shared a load stay as they are. `are_counted` [island] is as in
/// ConstrainedSystem. Leaves the accelerations in `at.to`.
Outcome find_complementary_modes(ContactState& state, const ModeSwitch& at, const std::vector<ContactChoice>& choices,
                                 const ContactIslands& islands, std::span<const char> are_counted);

}  // namespace tanor::detail
