#include <gtest/gtest.h>

#include "motion/scheme.hpp"

namespace tanor {
using namespace detail;
namespace {

/// Makes a state all of whose members hold `number`.
State make_state(double number) {
  State state{.t = number,
              .x = {number},
              .v = {number, number},
              .a = {number, number, number},
              .power = {number, number, number, number},
              .work = {2.0 * number, number, number, number},
              .report = {},
              .reactions = {}};
  state.report.residual = number;
  state.reactions.lambda = {number};
  state.reactions.friction = {number, number};
  state.reactions.refinements = static_cast<int>(number);
  state.reactions.w = {2.0 * number};
  state.reactions.w0 = {3.0 * number};
  state.reactions.knows_w0 = number > 1.0;
  return state;
}

void expect_all_are(double number, const State& state) {
  const State wanted = make_state(number);
  EXPECT_EQ(state.t, wanted.t);
  EXPECT_EQ(state.x, wanted.x);
  EXPECT_EQ(state.v, wanted.v);
  EXPECT_EQ(state.a, wanted.a);
  EXPECT_EQ(state.power.friction, wanted.power.friction);
  EXPECT_EQ(state.work.supports, wanted.work.supports);
  EXPECT_EQ(state.report.residual, wanted.report.residual);
  EXPECT_EQ(state.reactions.lambda, wanted.reactions.lambda);
  EXPECT_EQ(state.reactions.friction, wanted.reactions.friction);
  EXPECT_EQ(state.reactions.refinements, wanted.reactions.refinements);
  EXPECT_EQ(state.reactions.w, wanted.reactions.w);
  EXPECT_EQ(state.reactions.w0, wanted.reactions.w0);
  EXPECT_EQ(state.reactions.knows_w0, wanted.reactions.knows_w0);
}

TEST(State, ExchangesAllOfItsMembers) {
  // A new member is exchanged where `swap` names it.
  static_assert(sizeof(State) == sizeof(double) + 3 * sizeof(std::vector<double>) + 2 * sizeof(Power) +
                                     sizeof(SolveReport) + sizeof(Reactions));
  State one = make_state(1.0), two = make_state(2.0);

  swap(one, two);

  expect_all_are(2.0, one);
  expect_all_are(1.0, two);
}

}  // namespace
}  // namespace tanor
