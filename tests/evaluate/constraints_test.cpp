/// The tests compare every kind of constraint with its definition over jets, in xi, K'v + xi_t, phi and the blocks of
/// K.

#include "evaluate/constraints.hpp"

#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <tanor/user_kernel.hpp>

#include "base/parallel.hpp"
#include "evaluate/constraint_scenes.hpp"
#include "evaluate/definitions.hpp"
#include "reference.hpp"
#include "system/members.hpp"
#include "system/neighbourhoods.hpp"

namespace tanor::constraint_scenes {
using namespace detail;
namespace {

void expect_close(const Eigen::VectorXd& computed, const Eigen::VectorXd& expected, double scale = 1.0) {
  ASSERT_EQ(computed.size(), expected.size());
  for (Eigen::Index a = 0; a < expected.size(); ++a) {
    EXPECT_NEAR(computed[a], expected[a], 1e-12 * std::max(scale, std::abs(expected[a]))) << "row " << a;
  }
}

class ConstraintKind : public testing::TestWithParam<Kind> {
 protected:
  /// Checks random scenes without short distances, where derivatives and with them rounding would grow.
  template <class Check>
  void for_random_scenes(const Check& check) const {
    int scenes = 0;
    for (unsigned seed = 0; scenes < 50; ++seed) {
      const Scene scene = make_scene(GetParam(), seed);
      const auto expected = reference::evaluate_constraints(scene.system, t, scene.r, scene.v);
      if (expected.phi.cwiseAbs().maxCoeff() > 100.0) continue;
      ++scenes;
      SCOPED_TRACE("seed " + std::to_string(seed));
      check(scene, expected);
    }
  }
};

TEST_P(ConstraintKind, ValueIsItsDefinition) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    expect_close(Evaluated(scene).xi(), expected.xi);
  });
}

TEST_P(ConstraintKind, RateIsTheFirstDerivativeAlongTheMotion) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    expect_close(Evaluated(scene).rate(), expected.rate);
  });
}

TEST_P(ConstraintKind, GradientsAreTheDerivativesInEachCoordinate) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    Evaluated evaluated(scene);

    (void)evaluated.right_side();

    EXPECT_LE((evaluated.K() - expected.K).cwiseAbs().maxCoeff(), 1e-13 * std::max(1.0, expected.K.norm()));
    EXPECT_EQ(evaluated.gradients(), evaluated.blocks);
  });
}

TEST_P(ConstraintKind, RightSideIsTheSecondDerivativeAlongTheMotionPlusKTransposedW) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    const Eigen::VectorXd Kw = expected.K.transpose() * reference::vector(scene.w);
    // The largest of the terms in phi is |v|^2/distance.
    const double terms = std::max(10.0, expected.phi.cwiseAbs().maxCoeff());
    Evaluated evaluated(scene);

    const Eigen::VectorXd with_blocks = evaluated.right_side(), without = evaluated.right_side_alone();

    expect_close(with_blocks, expected.phi + Kw, terms);
    EXPECT_EQ(with_blocks, without);
  });
}

TEST_P(ConstraintKind, StoredBlocksGiveKTransposedTimesAVector) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    Evaluated evaluated(scene);
    (void)evaluated.right_side();

    const Eigen::VectorXd y = evaluated.transposed_times_w(0.25);

    expect_close(y, (expected.K.transpose() * reference::vector(scene.w)).array() + 0.25, 10.0);
  });
}

TEST_P(ConstraintKind, SquaredNormsOfTheBlocksAreKnownWhereTheyNeverChange) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers&) {
    Evaluated evaluated(scene);

    const std::vector<double> squares = evaluated.squared_norms();

    const std::vector<double> blocks = evaluated.gradients();
    for (std::size_t k = 0; k < squares.size(); ++k) {
      EXPECT_NEAR(reference::point(blocks, static_cast<Index>(k)).squaredNorm(), squares[k], 1e-14 * squares[k]);
    }
    const Constraint& constraint = scene.system.constraints[0];
    const bool changes = std::holds_alternative<Angles>(constraint) || std::holds_alternative<Ellipsoids>(constraint) ||
                         std::holds_alternative<Helices>(constraint) ||
                         std::holds_alternative<UserConstraints>(constraint);
    EXPECT_EQ(squares.size(), changes ? 0 : blocks.size() / 3);
  });
}

TEST_P(ConstraintKind, IndependentDefinitionAgrees) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    const auto d = static_cast<std::size_t>(expected.xi.size());
    const double terms = std::max(10.0, expected.phi.cwiseAbs().maxCoeff());
    const Definitions definitions(scene.system, 0.0);
    Evaluated evaluated(scene);
    const Eigen::VectorXd second = evaluated.right_side();
    std::vector<double> xi(d), rate(d), curvature(d), y(d), lambda(d), eta(18);
    for (std::size_t a = 0; a < d; ++a) lambda[a] = std::sin(1.0 + 2.0 * static_cast<double>(a));

    definitions.taylor(Parallel(1), t, scene.r, scene.v, scene.w, xi, rate, curvature);
    definitions.transposed(Parallel(1), t, scene.r, scene.w, y);
    definitions.reactions(t, scene.r, lambda, eta);

    ASSERT_EQ(definitions.num_rows(), d);
    expect_close(evaluated.xi(), reference::vector(xi));
    expect_close(evaluated.rate(), reference::vector(rate));
    expect_close(second, reference::vector(curvature), terms);
    expect_close(evaluated.transposed_times_w(0.0), reference::vector(y), 10.0);
    expect_close(evaluated.K() * reference::vector(lambda), reference::vector(eta), 10.0);
  });
}

/// Returns the length by which the violation of a row is measured. It is the rod length, the radius, or else the length
/// of the neighbourhood. The gradient is that of the largest block.
double length_of(const Scene& scene, Eigen::Index row) {
  const Constraint& constraint = scene.system.constraints[0];
  const reference::Configuration now = reference::standing(scene.r, t);
  const reference::Configuration start = reference::standing(scene.system.positions, 0.0);
  const reference::Xi xi{now, start};
  const auto k = static_cast<std::size_t>(row);
  // The parameter is the measure minus xi.
  const auto parameter = [&]<class Group>(Group group, Parameter Group::*member, std::size_t index) {
    const double value = xi(group, index).back().value();
    group.*member = 0.0;
    return xi(group, index).back().value() - value;
  };
  if (const auto* rods = std::get_if<Rods>(&constraint)) return parameter(*rods, &Rods::length, k);
  if (const auto* spheres = std::get_if<Spheres>(&constraint)) return parameter(*spheres, &Spheres::radius, k);
  if (const auto* circles = std::get_if<Circles>(&constraint)) return parameter(*circles, &Circles::radius, k / 2);
  // Otherwise it is the length of the neighbourhood of the row's first moving point.
  const Neighbourhoods around = find_neighbourhoods(scene.system, 0.0);
  std::size_t next = 0;
  double length = scene_size(scene.system);
  for_each_member(scene.system, [&](std::span<const Index> points, int rows) {
    for (int own_row = 0; own_row < rows; ++own_row, ++next) {
      for (std::size_t p = points.size(); next == k && p-- > 0;) {
        const Index own = around.of_point[static_cast<std::size_t>(points[p])];
        if (own >= 0) length = around.length[static_cast<std::size_t>(own)];
      }
    }
  });
  return length;
}

double largest_block(const Eigen::MatrixXd& K, Eigen::Index row) {
  double result = 0.0;
  for (Eigen::Index i = 0; i < K.rows(); i += 3) result = std::max(result, K.block<3, 1>(i, row).norm());
  return result;
}

TEST_P(ConstraintKind, ViolationIsTheValueOverGradientAndLength) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    Eigen::VectorXd position = expected.xi.cwiseAbs(), velocity = expected.rate.cwiseAbs();
    for (Eigen::Index a = 0; a < position.size(); ++a) {
      position[a] /= largest_block(expected.K, a) * length_of(scene, a);
      velocity[a] /= largest_block(expected.K, a);
    }
    Evaluated evaluated(scene);

    const auto [position_measure, velocity_measure] = evaluated.measures();

    expect_close(position_measure, position);
    expect_close(velocity_measure, velocity);
    (void)evaluated.xi();
    EXPECT_NEAR(evaluated.worst, position.maxCoeff(), 1e-12 * std::max(1.0, position.maxCoeff()));
    (void)evaluated.rate();
    EXPECT_NEAR(evaluated.worst, velocity.maxCoeff(), 1e-12 * std::max(1.0, velocity.maxCoeff()));
  });
}

TEST_P(ConstraintKind, ResidualsAreReportedOverTheGradient) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    const auto worst_of = [&](const Eigen::VectorXd& rows) {
      double worst = 0.0;
      for (Eigen::Index a = 0; a < rows.size(); ++a) {
        worst = larger(worst, std::abs(rows[a]) / largest_block(expected.K, a));
      }
      return worst;
    };
    Evaluated evaluated(scene);

    const double right_side = worst_of(evaluated.right_side());
    const double right_side_reported = evaluated.worst;
    const double residual = worst_of(evaluated.transposed_times_w(-0.5));

    EXPECT_NEAR(right_side_reported, right_side, 1e-12 * right_side);
    EXPECT_NEAR(evaluated.worst, residual, 1e-12 * std::max(1.0, residual));
  });
}

INSTANTIATE_TEST_SUITE_P(Evaluate, ConstraintKind, testing::ValuesIn(kinds),
                         [](const auto& kind) { return std::string(kind.param.name); });

// ---- what the whole knows about itself ---------------------------------------------------------------------------

class Knowledge : public testing::Test {
 protected:
  static Constraints constraints_of(const char* kind) {
    for (const Kind& candidate : kinds) {
      if (std::string(candidate.name) != kind) continue;
      const Scene scene = make_scene(candidate, 1);
      return {scene.system, number(scene.system)};
    }
    throw std::logic_error(kind);
  }
};

TEST_F(Knowledge, DependenceOnTimeIsFound) {
  for (const char* kind : {"RodMovingLength", "RodWithOffsetAndMovingLength", "PlaneMovingOffset", "PlaneMovingNormal",
                           "SphereMovingCenterAndRadius", "LineMovingOrigin", "LineMovingDirection",
                           "CircleMovingCenter", "CircleMovingNormal", "AngleMovingCosine", "PulleyMovingLength",
                           "LinearMovingValue", "FormulaMovingSurface", "UserThreePoints"}) {
    EXPECT_TRUE(constraints_of(kind).depends_on_time()) << kind;
  }
  for (const char* kind : {"RodInitial", "RodWithOffset", "Plane", "Sphere", "Line", "Circle", "Angle", "Pulley",
                           "LinearOnePoint", "FormulaRod"}) {
    EXPECT_FALSE(constraints_of(kind).depends_on_time()) << kind;
  }
}

TEST_F(Knowledge, GradientsAreConstantOnPlanesLinesAndLinearConstraintsThatDoNotTurn) {
  for (const char* kind : {"Plane", "PlaneMovingOffset", "Line", "LineMovingOrigin", "LinearMovingValue"}) {
    EXPECT_TRUE(constraints_of(kind).gradients_are_constant()) << kind;
  }
  for (const char* kind : {"RodInitial", "PlaneMovingNormal", "Sphere", "LineMovingDirection", "Circle", "Angle",
                           "Pulley", "FormulaRod"}) {
    EXPECT_FALSE(constraints_of(kind).gradients_are_constant()) << kind;
  }
}

TEST_F(Knowledge, GradientNormsChangeWithAnglesUsersFunctionsAndKindsWithoutAKernel) {
  for (const Kind& kind : kinds) {
    const std::string name = kind.name;
    const bool changes = name.starts_with("Angle") || name.starts_with("Formula") || name.starts_with("User") ||
                         name.starts_with("Ellipsoid") || name.starts_with("Helix");
    EXPECT_EQ(constraints_of(kind.name).gradient_norms_are_constant(), !changes) << kind.name;
  }
}

// ---- time and threads --------------------------------------------------------------------------------------------

TEST(Constraints, GoingBackInTimeGivesTheSameBits) {
  const Scene scene = make_scene({"",
                                  [](Random& any) {
                                    return Spheres{"", {0}, any.moving_vector(), any.length()};
                                  }},
                                 5);
  const Numbering numbering = number(scene.system);
  Constraints constraints(scene.system, numbering);
  const auto xi_at = [&](double time) {
    double xi = NAN;
    constraints.set_time(time);
    (void)constraints.evaluate_values(Parallel(1), scene.r.data(), &xi);
    return xi;
  };

  const double first = xi_at(0.3), other = xi_at(1.9), again = xi_at(0.3);

  EXPECT_NE(first, other);
  EXPECT_EQ(first, again);
}

TEST(Constraints, TwoThreadsGiveTheSameBits) {
  // There are enough members for each thread to get a range, in a chain of 10,000 rods, angles along it, planes, and
  // sums of three points.
  constexpr Index n = 10001;
  Random any(8);
  System system;
  for (Index i = 0; i < n; ++i) {
    system.positions.insert(system.positions.end(), {0.1 * i + any.number(), any.number(), any.number()});
  }
  system.masses.assign(n, 1.0);
  Rods rods{"", {}, 0.1, {}};
  Angles angles{"", {}, 0.2};
  Planes planes{"", {}, Vector3{0.1, 0.2, 0.9}, 0.3};
  Linears sums{"", {}, {any.vector(), any.vector(), any.vector()}, 0.1};
  for (Index i = 0; i + 2 < n; ++i) {
    rods.pairs.push_back({i, i + 1});
    angles.triples.push_back({i, i + 1, i + 2});
    planes.points.push_back(i);
    sums.tuples.push_back({i + 1, i, i + 2});
  }
  system.constraints = {rods, angles, planes, sums};
  const Numbering numbering = number(system);
  Constraints constraints(system, numbering);
  const std::vector<double> r = any.numbers(3 * n), v = any.numbers(3 * n), w = any.numbers(3 * n);
  struct Result {
    std::vector<double> xi, rate, phi, blocks, y;
    double worst[4];
    bool operator==(const Result&) const = default;
  };
  const auto evaluate = [&](int threads) {
    const Parallel parallel(threads);
    const std::size_t d = constraints.num_rows();
    Result result{std::vector<double>(d), std::vector<double>(d),
                  std::vector<double>(d), std::vector<double>(3 * constraints.num_blocks()),
                  std::vector<double>(d), {}};
    result.worst[0] = constraints.evaluate_values(parallel, r.data(), result.xi.data());
    result.worst[1] = constraints.evaluate_rates(parallel, r.data(), v.data(), result.rate.data());
    result.worst[2] = constraints.evaluate_right_side(parallel, r.data(), v.data(), w.data(), result.phi.data(),
                                                      result.blocks.data());
    result.worst[3] = constraints.apply_transposed(parallel, result.blocks.data(), w.data(), nullptr, result.y.data());
    return result;
  };

  const Result one = evaluate(1);

  for (const int threads : {2, 3, 5}) EXPECT_TRUE(one == evaluate(threads)) << threads;
}

}  // namespace
}  // namespace tanor::constraint_scenes
