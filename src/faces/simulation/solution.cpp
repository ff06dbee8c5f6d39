#include "simulation/solution.hpp"

#include <algorithm>
#include <limits>

#include <tanor/enum_names.hpp>

#include "base/text.hpp"
#include "dynamics/self_stress.hpp"
#include "system/members.hpp"

namespace tanor {
using namespace detail;

Solution detail::make_solution(const System& system, std::size_t num_coordinates) {
  Solution solution;
  for (std::vector<double>* array : {&solution.positions, &solution.velocities, &solution.accelerations,
                                     &solution.reactions, &solution.support_forces})
    array->resize(3 * system.num_points());
  for (std::vector<double>* array : {&solution.coordinates, &solution.coordinate_rates}) array->resize(num_coordinates);
  std::size_t row = 0;
  for (const Constraint& constraint : system.constraints) {
    const auto [members, rows] = shape_of(constraint);
    solution.first_row.push_back(row);
    solution.row_counts.push_back(rows);
    row += members * rows;
  }
  solution.multipliers.resize(row);
  return solution;
}

void detail::forget_equations(const System& system, std::span<const std::size_t> equations,
                              std::vector<double>* multipliers, std::initializer_list<std::vector<double>*> forces) {
  if (equations.empty()) return;
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  std::size_t row = 0;
  for_each_member(system, [&](std::span<const Index> joined, std::size_t rows) {
    if (std::ranges::binary_search(equations, row)) {
      (*multipliers)[row] = none;
      for (const Index point : joined)
        for (std::vector<double>* const force : forces) std::fill_n(force->begin() + 3 * point, 3, none);
    }
    row += rows;
  });
}

std::vector<double> detail::find_self_stress(const Forms& forms) {
  if (forms.normal == nullptr || !forms.work.team().is_alone()) return {};  // one rank does not know them all
  const std::vector<double> stress =
      find_self_stress(forms.normal->linearization().dependences(), forms.model.numbering);
  std::vector<double> result(stress.empty() ? 0 : forms.model.numbering.num_user_rows);
  if (!stress.empty()) forms.model.numbering.scatter_rows(stress, result);
  return result;
}

double Solution::multiplier(const Member& member, std::size_t k) const {
  const auto refuse = [](const std::string& what) { throw InputError("", what); };
  if (member.group >= first_row.size()) refuse("there is no group " + text(member.group) + " of constraints");
  const std::size_t end = member.group + 1 < first_row.size() ? first_row[member.group + 1] : multipliers.size();
  const std::size_t row = first_row[member.group] + member.number * row_counts[member.group] + k;
  if (k >= row_counts[member.group] || row >= end)
    refuse("constraints[" + text(member.group) + "] have no equation " + text(k) + " of a member " +
           text(member.number));
  return multipliers[row];
}

Vector3 Solution::vector_of(const std::vector<double>& array, Point point) {
  const auto first = 3 * static_cast<std::size_t>(point.index);
  if (point.index < 0 || first + 3 > array.size())
    throw InputError("", "there is no point " + text(point.index) + " among " + text(array.size() / 3));
  return {array[first], array[first + 1], array[first + 2]};
}

std::string PlanSummary::linear_solver() const {
  return names_of(linear_solvers);
}

std::string PlanSummary::ordering() const {
  return orderings.empty() ? "none" : names_of(orderings);
}

std::string PlanSummary::factorization() const {
  if (linear_solvers != std::vector{LinearSolver::General}) return linear_solver();
  return factorizations.empty() ? "none" : names_of(factorizations);
}

}  // namespace tanor
