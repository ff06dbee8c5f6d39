#pragma once

#include <span>
#include <string>
#include <vector>

#include "dynamics/contacts.hpp"
#include "dynamics/workspace.hpp"
#include "friction/contact_islands.hpp"
#include "friction/contraction.hpp"
#include "friction/enumeration.hpp"
#include "friction/laws.hpp"
#include "friction/response.hpp"

namespace tanor::detail {

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
    ContactProblem problem;            // of all members, which move; friction changes no acceleration
  };
  void list_members();
  void reduce();
  bool are_small() const;
  bool are_coulomb(const Island& island) const;
  double amplification_of_full_reactions() const;
  std::string name(const Island& island) const;
  bool is_counted(const Island& island, const UniquenessCheck& check) const {
    return !check.are_counted.empty() && check.are_counted[island.number] != 0;
  }
  bool holds_what_sticks(const Island& island, const Eigen::VectorXd& sizes, const double* at);
  Outcome note_several(const Island& island, std::size_t count, double t, const UniquenessCheck& check,
                       FrictionReport* report) const;
  void leave_out_uncoupled(std::size_t least_contacts);
  SlidingSolutions count(const Island& island, const double* at);
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
