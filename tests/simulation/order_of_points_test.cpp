/// The answers of Dynamics are in the order in which its caller gave the points and the groups.

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "dynamics/solved.hpp"

namespace tanor {
namespace {

using Eigen::VectorXd;

/// A system and the same one with its points renamed: point i becomes name[i].
class Renamed {
 public:
  explicit Renamed(std::vector<Index> name) : name_(std::move(name)) {}

  std::vector<double> operator()(const std::vector<double>& user, std::size_t width = 3) const {
    std::vector<double> result(user.size());
    for (std::size_t i = 0; i < name_.size(); ++i) {
      for (std::size_t k = 0; k < width; ++k) {
        result[width * static_cast<std::size_t>(name_[i]) + k] = user[width * i + k];
      }
    }
    return result;
  }

  System operator()(System system) const {
    system.positions = (*this)(system.positions);
    system.masses = (*this)(system.masses, 1);
    for (Support& support : system.supports) rename(&support.points);
    for (Constraint& constraint : system.constraints) {
      std::visit([&](auto& group) { rename_members(&group); }, constraint);
    }
    for (Force& force : system.forces) {
      std::visit([&](auto& group) { rename_members(&group); }, force);
    }
    return system;
  }

 private:
  template <class Points>
  void rename(Points* points) const {
    for (Index& point : *points) point = name_[static_cast<std::size_t>(point)];
  }
  template <class Tuples>
  void rename_each(Tuples* tuples) const {
    for (auto& tuple : *tuples) rename(&tuple);
  }
  void rename_members(Rods* group) const { rename_each(&group->pairs); }
  void rename_members(Angles* group) const { rename_each(&group->triples); }
  void rename_members(Pulleys* group) const { rename_each(&group->pairs); }
  void rename_members(Linears* group) const { rename_each(&group->tuples); }
  void rename_members(Ropes* group) const { rename_each(&group->paths); }
  void rename_members(UserConstraints* group) const { rename_each(&group->tuples); }
  void rename_members(Springs* group) const { rename_each(&group->pairs); }
  void rename_members(Potential* group) const { rename_each(&group->points); }
  void rename_members(Bonds* group) const { rename_each(&group->pairs); }
  void rename_members(Bendings* group) const { rename_each(&group->triples); }
  void rename_members(Torsions* group) const { rename_each(&group->quadruples); }
  void rename_members(Gravity*) const {}
  template <class Group>
  void rename_members(Group* group) const {
    rename(&group->points);
  }

  std::vector<Index> name_;
};

RC_GTEST_PROP(Dynamics, RenamedPointsGetTheSameAnswerUnderTheirNewNames, ()) {
  const RandomSystem random = any_system();
  std::vector<Index> name(random.system.num_points());
  std::iota(name.begin(), name.end(), 0);
  std::shuffle(name.begin(), name.end(), std::mt19937(*rc::gen::arbitrary<std::uint32_t>().as("order")));
  const Renamed renamed(name);

  const Solved expected(random);
  const Solved solved({renamed(random.system), random.t, renamed(random.positions), renamed(random.velocities)});

  const VectorXd w = reference::vector(renamed(expected.accelerations));
  RC_ASSERT((reference::vector(solved.accelerations) - w).norm() <= expected.accuracy * expected.size);
  const VectorXd root = expected.dense.S().diagonal().cwiseSqrt();
  RC_ASSERT(root.cwiseProduct(solved.lambda - expected.lambda).norm() <=
            expected.accuracy * (expected.size + root.cwiseProduct(expected.lambda).norm()));
}

RC_GTEST_PROP(Dynamics, RowsFollowTheOrderOfTheGroups, ()) {
  // The groups are given in reverse order: the rows are the same, in another order.
  const RandomSystem random = any_system();
  RandomSystem reversed = random;
  std::reverse(reversed.system.constraints.begin(), reversed.system.constraints.end());

  const Solved expected(random), solved(reversed);

  std::size_t row = 0, from_end = expected.multipliers.size();
  for (const Constraint& constraint : random.system.constraints) {
    System single = random.system;
    single.constraints = {constraint};
    const std::size_t rows = num_equations(single);
    from_end -= rows;
    for (std::size_t k = 0; k < rows; ++k) {
      const double a = expected.multipliers[row + k], b = solved.multipliers[from_end + k];
      RC_ASSERT(std::abs(a - b) <= expected.accuracy * (1.0 + expected.lambda.norm() + expected.eta.norm()));
    }
    row += rows;
  }
}

}  // namespace
}  // namespace tanor
