/// The tests compare eta = K lambda, gathered point by point, with the dense product.

#include "assembly/reactions.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "linearised.hpp"
#include "random_numbers.hpp"

namespace tanor {
using namespace detail;
namespace {

RC_GTEST_PROP(ReactionGather, IsKTimesLambdaOnAllPoints, ()) {
  const RandomSystem random = any_system();
  const Linearised inner(random);
  const ReactionGather gather(inner.incidences, inner.numbering.num_points());
  const std::vector<double> lambda = normal_numbers(inner.constraints.num_rows(), 7);
  std::vector<double> eta(inner.r.size(), NAN);

  gather.reactions(Parallel(1), inner.blocks.data(), lambda.data(), eta.data());

  const Eigen::VectorXd expected = inner.K() * reference::vector(lambda);
  RC_ASSERT((reference::vector(eta) - expected).norm() <= 1e-14 * (1.0 + expected.norm()));
}

RC_GTEST_PROP(ReactionGather, ScaledByTheInverseMassesItMovesPointsAndLeavesSupportsAlone, ()) {
  const RandomSystem random = any_system();
  const Linearised inner(random);
  const ReactionGather gather(inner.incidences, inner.numbering.num_points());
  const std::vector<double> lambda = normal_numbers(inner.constraints.num_rows(), 7);
  std::vector<double> added = inner.v, written = inner.v;
  const std::size_t moving = inner.numbering.num_moving;

  gather.add_scaled(Parallel(1), inner.blocks.data(), lambda.data(), inner.inverse_masses.data(), moving, added.data());
  gather.write_scaled(Parallel(1), inner.blocks.data(), lambda.data(), inner.inverse_masses.data(), moving,
                      written.data());

  // Supports keep their numbers, since their inverse mass is 0.
  const Eigen::VectorXd change = inner.inverse_M().asDiagonal() * (inner.K() * reference::vector(lambda));
  const Eigen::VectorXd v = reference::vector(inner.v);
  const auto last = v.size() - static_cast<Eigen::Index>(3 * moving);
  RC_ASSERT((reference::vector(added) - v - change).norm() <= 1e-14 * (v.norm() + change.norm()));
  RC_ASSERT((reference::vector(written) - change).head(static_cast<Eigen::Index>(3 * moving)).norm() <=
            1e-14 * (1.0 + change.norm()));
  RC_ASSERT(reference::vector(written).tail(last) == v.tail(last));
}

TEST(ReactionGather, TwoThreadsGiveTheSameBits) {
  // Rods go from point to point and from each point to one of ten hubs, like a fan.
  constexpr Index n = 20000;
  std::vector<Incidence> incidences;
  Index row = 0;
  for (Index i = 0; i + 1 < n; ++i, ++row) {
    incidences.push_back({i, row, row, -1.0});
    incidences.push_back({i + 1, row, row, 1.0});
  }
  for (Index i = 10; i < n; ++i, ++row) {
    incidences.push_back({i, row, row, -1.0});
    incidences.push_back({i % 10, row, row, 1.0});
  }
  const ReactionGather gather(incidences, n);
  const auto d = static_cast<std::size_t>(row);
  const std::vector<double> blocks = normal_numbers(3 * d, 1), lambda = normal_numbers(d, 2),
                            masses = normal_numbers(n, 3);
  const auto evaluate = [&](int threads) {
    std::vector<double> eta(6 * n);
    gather.reactions(Parallel(threads), blocks.data(), lambda.data(), eta.data());
    gather.write_scaled(Parallel(threads), blocks.data(), lambda.data(), masses.data(), n, eta.data() + 3 * n);
    gather.add_scaled(Parallel(threads), blocks.data(), lambda.data(), masses.data(), n, eta.data() + 3 * n);
    return eta;
  };

  const std::vector<double> one = evaluate(1), two = evaluate(2);

  EXPECT_EQ(one, two);
}

}  // namespace
}  // namespace tanor
