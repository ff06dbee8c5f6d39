#include "dynamics/equations_of_motion.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <tanor/error.hpp>

#include "dynamics/corner_functions.hpp"

namespace tanor::detail {

void EquationsOfMotion::join(Ranks& ranks) {
  const bool has_work = has_work_here();
  Mechanics::join(ranks);
  all_.has_work = any(has_work);
  all_.rank_here = rank_here();
  all_.rank = static_cast<std::size_t>(sum(static_cast<double>(all_.rank_here)));
  all_.reciprocal_condition = 1.0;
  share_roles();
}

void EquationsOfMotion::share_roles() {
  Roles& roles = all_.roles;
  roles = roles_here();
  (void)together([&] {
    if (roles.corners != nullptr && roles.corners->num_terms() > 0)
      throw InputError("", "guides with corners move on one rank alone; one is " + roles.corners->name_term(0));
    return Outcome{};
  });
  roles.corners = nullptr;
  const auto or_none = [&]<class Role>(Role*& role, Role& none) {
    if (any(role != nullptr) && role == nullptr) role = &none;
  };
  const auto if_all = [&](auto*& role) {
    if (!all(role != nullptr)) role = nullptr;
  };
  or_none(roles.rank_monitor, none_.monitor);
  or_none(roles.unseen_forces, none_.unseen);
  or_none(roles.drives, none_.drives);
  or_none(roles.events, none_.events);
  if_all(roles.step_projector);
  if_all(roles.rounding_groups);  // friction on any process rules out the measurement of rounding
  if_all(roles.implicit_formulation);
}

SeriesExpansion* EquationsOfMotion::series(std::string* why_not) {
  if (is_alone()) return series_here(why_not);
  if (!all_.why_no_series) {
    std::string why_not_here;
    (void)together([&] {
      (void)series_here(&why_not_here);
      return Outcome{};
    });
    all_.why_no_series = first_text(why_not_here);
  }
  if (why_not != nullptr) *why_not = *all_.why_no_series;
  return all_.why_no_series->empty() ? series_here(nullptr) : nullptr;
}

/// Work that is collective itself begins on all processes or on none, so that they agree on an earlier failure first.
Outcome EquationsOfMotion::agree(const std::function<Outcome()>& work, std::span<double> numbers) {
  const auto settle = [&] {
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    return Outcome{};
  };
  if (is_prescribed_together()) (void)Mechanics::agree(settle, {});
  std::vector<double> all(numbers.size() + 2);
  double &condition = all[numbers.size()], &has_new_rank = all[numbers.size() + 1];
  Outcome outcome = Mechanics::agree(
      [&] {
        (void)settle();
        Outcome own = work();
        std::ranges::copy(numbers, all.begin());
        condition = -reciprocal_condition_here();
        has_new_rank = rank_here() != all_.rank_here ? 1.0 : 0.0;
        return own;
      },
      all);
  std::copy_n(all.begin(), numbers.size(), numbers.begin());
  all_.reciprocal_condition = std::max(0.0, -condition);
  if (has_new_rank > 0.0) {
    all_.rank_here = rank_here();
    all_.rank = static_cast<std::size_t>(sum(static_cast<double>(all_.rank_here)));
  }
  return outcome;
}

StartReport EquationsOfMotion::start_together(const std::function<StartReport()>& start) {
  if (is_alone()) return start();
  StartReport report;
  std::array<double, 3> numbers{};
  report.outcome = together(
      [&] {
        StartReport own = start();
        numbers = {own.position_correction, own.velocity_correction, own.relative};
        return own.outcome;
      },
      numbers);
  report.position_correction = numbers[0];
  report.velocity_correction = numbers[1];
  report.relative = numbers[2];
  return report;
}

ErrorRatios EquationsOfMotion::largest_of_all(const ErrorRatios& own) {
  std::array<double, 2> largest{own.x, own.v};
  take_largest(largest);
  return {largest[0], largest[1]};
}

Energy EquationsOfMotion::sum_of_all(const Energy& own) {
  std::array<double, 2> all{own.kinetic, own.potential};
  add(all);
  return {all[0], all[1]};
}

}  // namespace tanor::detail
