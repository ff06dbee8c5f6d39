#include "base/root_isolation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace tanor {
using namespace detail;
namespace {

using std::numbers::pi;

struct Found {
  std::vector<double> roots;
  std::size_t samples = 0;
  bool is_certain = false;
};

/// Finds the roots of g between samples that are not 0.
Found find_roots(const RootIsolation::Function& g) {
  std::vector<double> values;
  for (const double s : RootIsolation::places) values.push_back(g(s));
  RootIsolation isolation;
  isolation.isolate(values, g, {0.0, 4e-16});

  Found found{{}, isolation.samples().size(), std::isnan(isolation.doubtful_place())};
  for (std::size_t i = 0; i + 1 < isolation.samples().size(); ++i) {
    if (isolation.samples()[i].value * isolation.samples()[i + 1].value < 0.0)
      found.roots.push_back(isolation.find_root(i, g));
  }
  return found;
}

void expect_roots(const RootIsolation::Function& g, std::vector<double> roots, double error = 1e-9) {
  std::erase_if(roots, [](double s) { return !(s > 0.0 && s < 1.0); });
  std::sort(roots.begin(), roots.end());
  const Found found = find_roots(g);
  ASSERT_EQ(found.roots.size(), roots.size());
  for (std::size_t k = 0; k < roots.size(); ++k) EXPECT_NEAR(found.roots[k], roots[k], error);
}

/// c + sin(w s + p) turns up to 16 times.
TEST(RootIsolation, FindsAllRootsOfSines) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  for (int draw = 0; draw < 500; ++draw) {
    const double w = 0.1 + 100.0 * part(random), p = 2.0 * pi * part(random), c = 1.9 * part(random) - 0.95;
    std::vector<double> roots;
    for (int turn = -1; turn < 20; ++turn)
      for (const double angle : {std::asin(-c), pi - std::asin(-c)}) roots.push_back((angle + 2.0 * pi * turn - p) / w);
    SCOPED_TRACE(testing::Message() << c << " + sin(" << w << " s + " << p << ")");
    expect_roots([=](double s) { return c + std::sin(w * s + p); }, roots);
  }
}

TEST(RootIsolation, FindsAllRootsOfPolynomials) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(-1.0, 2.0);
  for (int draw = 0; draw < 500; ++draw) {
    std::vector<double> roots(1 + random() % 7);
    for (double& root : roots) root = place(random);
    expect_roots(
        [&](double s) {
          double product = 1.0;
          for (const double root : roots) product *= s - root;
          return product;
        },
        roots, 1e-7);
  }
}

/// 1 - cos(w (s - s0)) - depth passes 0 twice near each of its minima, and not at all if the depth is negative.
TEST(RootIsolation, FindsBothRootsOfDipsDownTo1EMinus12) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  for (int draw = 0; draw < 500; ++draw) {
    const double w = 0.3 + 6.0 * part(random), s0 = part(random), depth = std::pow(10.0, -2.0 - 10.0 * part(random));
    for (const double sign : {1.0, -1.0}) {
      std::vector<double> roots;
      const double half = 2.0 * std::asin(std::sqrt(0.5 * depth));
      for (int turn = -2; turn <= 2 && sign > 0.0; ++turn)
        for (const double angle : {-half, half}) roots.push_back(s0 + (2.0 * pi * turn + angle) / w);
      expect_roots(
          [=](double s) {
            const double sine = std::sin(0.5 * w * (s - s0));
            return 2.0 * sine * sine - sign * depth;
          },
          roots);
    }
  }
}

TEST(RootIsolation, FindsKinksAndJumps) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> part(0.05, 0.95);
  for (int draw = 0; draw < 200; ++draw) {
    const double place = part(random), depth = std::pow(10.0, -8.0 * part(random));
    expect_roots([=](double s) { return std::abs(s - place) - depth; }, {place - depth, place + depth});
    expect_roots([=](double s) { return s < place ? -depth : 1.0; }, {place});
    expect_roots([=](double s) { return s < place ? depth : 1.0; }, {});
  }
}

/// No sample beyond the end shows the other side of the kink.
TEST(RootIsolation, FindsKinksRightBesideTheEnds) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  for (int draw = 0; draw < 500; ++draw) {
    const double from_end = std::pow(10.0, -3.0 - 5.0 * part(random)), depth = from_end * (0.1 + 0.8 * part(random));
    const double place = draw % 2 == 0 ? from_end : 1.0 - from_end;
    expect_roots([=](double s) { return std::abs(s - place) - depth; }, {place - depth, place + depth}, 1e-12);
  }
}

/// Near its roots the function is smaller than the rounding of its largest values.
TEST(RootIsolation, FindsTheRootsOfFunctionsThatGrowByManyOrders) {
  for (int k = 0; k < 100; ++k) {
    const double c = 0.05 + 0.009 * k, apart = std::pow(10.0, -2.0 - 0.02 * k);
    expect_roots([=](double s) { return std::expm1(200.0 * (s - c)) * (s - c - apart); }, {c, c + apart});
  }
}

/// The first samples see nothing of a bump between two of them, but a probe does, and more may lie between others.
TEST(RootIsolation, IsInDoubtWhereOnlyAProbeSeesABump) {
  for (const std::size_t k : RootIsolation::probes) {
    const double place = RootIsolation::places[k];
    for (const double width : {1e-2, 1e-3}) {
      const auto box = [=](double s) { return std::abs(s - place) < width ? -1.0 : 1.0; };
      expect_roots(box, {place - width, place + width});
      EXPECT_FALSE(find_roots(box).is_certain);
    }
  }
}

TEST(RootIsolation, TakesTheFirstSamplesAloneWhereTheFunctionIsSmoothAndFarFrom0) {
  for (const double slope : {0.0, 0.5, 2.0}) {
    const Found found = find_roots([=](double s) { return 1.5 + std::sin(slope * s); });

    EXPECT_EQ(found.samples, RootIsolation::places.size() - RootIsolation::probes.size());
    EXPECT_TRUE(found.is_certain);
  }
}

TEST(RootIsolation, IsInDoubtWhereTheFunctionTouches0) {
  const Found touches = find_roots([](double s) { return (s - 0.3) * (s - 0.3); });
  const Found flat = find_roots([](double s) { return std::pow(s - 0.3, 4); });
  const Found passes = find_roots([](double s) { return std::pow(s - 0.3, 3); });

  for (const Found& found : {touches, flat}) {
    EXPECT_TRUE(found.roots.empty());
    EXPECT_FALSE(found.is_certain);
    EXPECT_LT(found.samples, 100U);
  }
  EXPECT_EQ(passes.roots.size(), 1U);
  EXPECT_TRUE(passes.is_certain);
}

/// A function that is 0 at an end of the step says nothing about more roots.
TEST(RootIsolation, IsCertainAboutFunctionsThatAre0AtAnEndOrEverywhere) {
  for (const RootIsolation::Function& g : std::vector<RootIsolation::Function>{
           [](double) { return 0.0; }, [](double s) { return s; }, [](double s) { return s * s; },
           [](double s) { return (s - 1.0) * (s - 1.0); }, [](double s) { return std::sin(pi * s); }}) {
    const Found found = find_roots(g);

    EXPECT_TRUE(found.roots.empty());
    EXPECT_TRUE(found.is_certain);
  }
}

TEST(RootIsolation, IsInDoubtAboutNoise) {
  const Found found = find_roots([](double s) { return std::sin(1e12 * s * s); });

  EXPECT_GT(found.samples, RootIsolation::most_samples);
  EXPECT_FALSE(found.is_certain);
}

}  // namespace
}  // namespace tanor
