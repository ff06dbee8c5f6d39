/// A selection of members of all kinds has the rows and blocks of the whole, and leaves the others untouched.

#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <tanor/user_kernel.hpp>

#include "linearised.hpp"
#include "system/members.hpp"

namespace tanor {
using namespace detail;
namespace {

/// Draws a random system and two groups of a user's constraints.
RandomSystem any_system_and_user_constraints() {
  RandomSystem random = any_system();
  const auto num_points = static_cast<Index>(random.system.num_points());
  const auto on_ball = [](const auto& x, const auto& t) { return x[0] * x[0] + x[1] * x[2] - 1.0 - 0.1 * t; };
  for (const bool thread_safe : {true, false}) {
    UserConstraints group{"", {}, make_constraint_kernel<1>(on_ball, thread_safe)};
    for (Index i = 0; i < num_points; i += 2) group.tuples.push_back({i});
    random.system.constraints.emplace_back(group);
  }
  return random;
}

RC_GTEST_PROP(Selection, GivesItsOwnRowsAndBlocksAndLeavesOthersAlone, ()) {
  constexpr double untouched = -7.25;
  const RandomSystem random = any_system_and_user_constraints();
  std::mt19937 generator(*rc::gen::arbitrary<std::uint32_t>());
  Linearised inner(random);
  Constraints& constraints = inner.constraints;
  const std::size_t d = constraints.num_rows(), num_numbers = inner.blocks.size();
  std::vector<char> takes_part(d, 0), has_block(num_numbers / 3, 0);
  std::size_t member = 0;
  for_each_member(random.system, [&](std::span<const Index>, int rows) {
    const char takes = std::bernoulli_distribution(0.5)(generator) ? 1 : 0;
    for (int k = 0; k < rows; ++k) takes_part[static_cast<std::size_t>(inner.numbering.member_row[member] + k)] = takes;
    ++member;
  });
  for (const Incidence& incidence : inner.incidences)
    has_block[static_cast<std::size_t>(incidence.block)] = takes_part[static_cast<std::size_t>(incidence.row)];
  const Constraints::Selection some = constraints.select(takes_part);
  const Parallel parallel(2);
  const double *const r = inner.r.data(), *const v = inner.v.data();
  const auto expect_rows = [&](const std::vector<double>& of_some, const std::vector<double>& of_all) {
    for (std::size_t a = 0; a < d; ++a) RC_ASSERT(of_some[a] == (takes_part[a] != 0 ? of_all[a] : untouched));
  };
  const auto expect_blocks = [&](const std::vector<double>& of_some, const std::vector<double>& of_all) {
    for (std::size_t k = 0; k < num_numbers; ++k)
      RC_ASSERT(of_some[k] == (has_block[k / 3] != 0 ? of_all[k] : untouched));
  };
  std::vector<double> all(d), all_blocks(num_numbers);
  std::vector<double> rows(d, untouched), blocks(num_numbers, untouched);
  double largest = 0.0;

  (void)constraints.evaluate_values(parallel, r, all.data());
  (void)constraints.evaluate_values(parallel, some, r, rows.data());
  expect_rows(rows, all);

  (void)constraints.evaluate_rates(parallel, r, v, all.data());
  (void)constraints.evaluate_rates(parallel, some, r, v, rows.data());
  expect_rows(rows, all);

  constraints.evaluate_gradients(parallel, r, all_blocks.data());
  constraints.evaluate_gradients(parallel, some, r, blocks.data());
  expect_blocks(blocks, all_blocks);

  (void)constraints.evaluate_right_side(parallel, r, v, v, all.data(), all_blocks.data());
  std::fill(blocks.begin(), blocks.end(), untouched);
  largest = constraints.evaluate_right_side(parallel, some, r, v, v, rows.data(), blocks.data());
  expect_rows(rows, all);
  expect_blocks(blocks, all_blocks);
  RC_ASSERT(largest <= constraints.evaluate_right_side(parallel, r, v, v, all.data(), nullptr));

  const std::vector<double> shift = all;
  largest = constraints.apply_transposed(parallel, all_blocks.data(), v, shift.data(), all.data());
  RC_ASSERT(constraints.apply_transposed(parallel, some, all_blocks.data(), v, shift.data(), rows.data()) <= largest);
  expect_rows(rows, all);
}

}  // namespace
}  // namespace tanor
