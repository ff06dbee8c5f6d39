#pragma once

#include <span>
#include <string>
#include <vector>

#include "dynamics/contacts.hpp"
#include "dynamics/workspace.hpp"
#include "friction/contact_problem.hpp"
#include "friction/fixed_point.hpp"
#include "friction/laws.hpp"

namespace tanor::detail {

/// Contacts grouped by the islands of their constraints. At one instant friction has no effect on the contacts of other
/// islands.
struct ContactIslands {
  explicit ContactIslands(const Workspace& work);

  std::vector<std::vector<std::size_t>> contacts;  ///< [island]; islands without contacts are left out
  std::vector<std::size_t> of_contact;             ///< [contact] its island

  std::size_t size() const { return contacts.size(); }
};

/// Returns the unit normal along which the guide of a contact pushes, or 0 if it acts to both sides.
Eigen::Vector3d outward(const Tangents& tangents, std::size_t contact);

/// The contacts that slide, as one small dense problem for each island: the normal forces as functions of friction.
/// Such a problem tells if friction is unique, and all its solutions can be found.
class SlidingIslands {
 public:
  /// All arguments must outlive this object; `response` and `laws` must be at the same configuration.
  SlidingIslands(const Workspace& work, const FrictionLaws& laws, const ContactIslands& islands, Response& response);

  /// Checks if lambda [rows] is the only solution, and writes the result into the report. `amplification` becomes
  /// 1/(1 - L) if a contraction constant L < 1 is proven, otherwise NaN.
  Outcome verify_uniqueness(double t, const UniquenessCheck& check, const double* lambda, FrictionReport* report,
                            double* amplification);
  /// Finds the solutions by enumeration, where iterations fail. Writes the one nearest to `lambda` into `lambda`.
  Outcome enumerate(double t, const UniquenessCheck& check, double* lambda, FrictionReport* report);

 private:
  struct Island {
    std::size_t number = 0;
    std::vector<std::size_t> members;  // sliding contacts; may be empty
    ContactProblem problem;            // of all members, which move; sizes of friction stand for accelerations
  };
  void list_members();
  void reduce();
  bool are_coulomb(const Island& island) const;
  double amplification_of_full_reactions() const;
  std::string name(const Island& island) const;
  bool is_counted(const Island& island, const UniquenessCheck& check) const {
    return !check.are_counted.empty() && check.are_counted[island.number] != 0;
  }
  Eigen::VectorXd sizes(const Island& island, const double* at) const;
  bool holds_what_sticks(const Island& island, const Eigen::VectorXd& sizes, const double* at);
  Outcome note_several(const Island& island, std::size_t count, double t, const UniquenessCheck& check,
                       FrictionReport* report) const;
  void leave_out_uncoupled(std::size_t least_contacts);
  ContactSolutions count(const Island& island, const UniquenessCheck& check, const double* at);
  Outcome choose_nearest(const Island& island, double t, const UniquenessCheck& check, const double* lambda,
                         double* force, FrictionReport* report) const;

  const Workspace& work_;
  const Model& model_;
  const Tangents& tangents_;
  const FrictionLaws& laws_;
  const ContactIslands& numbered_;
  Response& response_;
  std::vector<Island> islands_;  // kept from step to step
  ContractionBound contraction_;
  std::vector<double> force_, lambda_;  // [parts], [rows], scratch
};

}  // namespace tanor::detail
