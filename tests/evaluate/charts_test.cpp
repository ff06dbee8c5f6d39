/// Families of coordinates agree with the definitions in the files of their kinds, and a kind may have only a
/// definition.

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "dense.hpp"
#include "evaluate/coordinate_families.hpp"
#include "random_coordinates.hpp"

namespace tanor {
using namespace detail;

/// Points of a bowl z = s (x^2 + y^2)/2 around a place, by x and y. The library does not know these coordinates.
struct Bowls {
  std::vector<Index> points{};
  VectorFunction origin{};
  Parameter steepness{};  ///< s, 1/m
};

template <>
struct KindOf<Bowls> {
  static constexpr std::string_view name = "bowl";
  static constexpr auto members = &Bowls::points;
  static constexpr std::tuple fields{FieldOf("origin", &Bowls::origin), FieldOf("steepness", &Bowls::steepness)};
  static constexpr int coordinates = 2;
  static constexpr auto parameter = &Bowls::steepness;

  template <class T>
  struct Definition {
    TripleOf<T> origin;

    template <class Now>
    Definition(const Bowls& given, const Now& now) : origin(now(given.origin)) {}

    template <class Points>
    T measure(const Points& r, std::size_t) const {
      const TripleOf<T> a = r[0] - origin;
      return 2.0 * a.z / (a.x * a.x + a.y * a.y);
    }
    TripleOf<T> place(const std::array<T, 2>& q, const T& steepness, NoChart) const {
      return origin + TripleOf<T>{q[0], q[1], 0.5 * (steepness * (q[0] * q[0] + q[1] * q[1]))};
    }
    std::array<T, 2> locate(const TripleOf<T>& r, const T&, NoChart) const { return {r.x - origin.x, r.y - origin.y}; }
  };
};

/// A free point by its distance from the z axis, its angle and its height.
struct Cylindrical {
  std::vector<Index> points{};
};

template <>
struct KindOf<Cylindrical> {
  static constexpr std::string_view name = "cylindrical";
  static constexpr auto members = &Cylindrical::points;
  static constexpr std::tuple<> fields{};
  static constexpr int coordinates = 3;

  template <class T>
  struct Definition {
    template <class Now>
    Definition(const Cylindrical&, const Now&) {}

    TripleOf<T> place(const std::array<T, 3>& q, const T&, NoChart) const {
      using std::cos, std::sin;
      return {q[0] * cos(q[1]), q[0] * sin(q[1]), q[2]};
    }
    std::array<T, 3> locate(const TripleOf<T>& r, const T&, NoChart) const {
      using std::atan2, std::sqrt;
      return {sqrt(r.x * r.x + r.y * r.y), atan2(r.y, r.x), r.z};
    }
  };
};

static_assert(HasPlace<Bowls> && HasPlace<Cylindrical>);

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A family of coordinates at an instant, with everything in the inner order.
template <class Family>
struct Filled {
  Family family;
  Parallel parallel{1};
  std::size_t num_points;
  VectorXd q, q_dot;

  struct Value {
    VectorXd r, v, psi, blocks;
  };
  Value at() const {
    const auto n = static_cast<Eigen::Index>(3 * num_points);
    Value value{VectorXd::Zero(n), VectorXd::Zero(n), VectorXd::Zero(n), VectorXd(3 * family.num_blocks())};
    family.evaluate(parallel, q.data(), q_dot.data(), value.r.data(), value.v.data(), value.psi.data(),
                    value.blocks.data());
    return value;
  }
  MatrixXd A() const {
    const Value value = at();
    MatrixXd result = MatrixXd::Zero(value.r.size(), q.size());
    for (Eigen::Index j = 0; j < q.size(); ++j)
      family.apply(parallel, value.blocks.data(), VectorXd::Unit(q.size(), j).eval().data(), result.col(j).data());
    return result;
  }
  void set_numbers(std::uint32_t seed) {
    std::srand(seed);
    q += 0.2 * VectorXd::Random(q.size());
    q_dot = VectorXd::Random(q.size());
  }
};

/// Fills a family with the entries of a system that it takes, with its points at `places`.
template <class Family>
Filled<Family> fill(const System& system, const Numbering& numbering, double t, const VectorXd& places) {
  Filled<Family> filled{{}, Parallel(1), system.num_points(), {}, {}};
  for (const Coordinates& entry : system.coordinates) {
    const auto* group = std::get_if<typename Family::Group>(&entry);
    if (group != nullptr && Family::takes(*group)) filled.family.add(*group, {system, numbering, 0.0});
  }
  filled.family.set_time(t);
  filled.q = VectorXd::Zero(filled.family.points.empty() ? 0 : filled.family.num_coordinates());
  filled.q_dot = filled.q;
  filled.family.locate(places.data(), filled.q.data());
  return filled;
}

VectorXd places_at(const RandomCoordinates& random, const Numbering& numbering, double t) {
  VectorXd inner(static_cast<Eigen::Index>(3 * random.system.num_points()));
  numbering.gather_points(random.derivative(t, 0), {inner.data(), static_cast<std::size_t>(inner.size())});
  return inner;
}

/// Expects the same motion by hand and by the definition, in places, velocities and accelerations by a force. The
/// charts may differ, so that q and q_dot are found from the motion.
template <class Hand>
void expect_the_same_motion(int kind) {
  using Generic = PointCoordinates<JetChart<typename Hand::Group>>;
  int tried = 0;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    const RandomCoordinates random = RandomCoordinatesMaker(seed).make({kind, kind});
    const Numbering numbering = number(random.system);
    constexpr double t = 0.6;
    const VectorXd places = places_at(random, numbering, t);
    auto hand = fill<Hand>(random.system, numbering, t, places);
    if (hand.q.size() == 0) continue;
    ++tried;
    hand.set_numbers(seed);
    const auto expected = hand.at();

    auto generic = fill<Generic>(random.system, numbering, t, expected.r);
    const VectorXd carried = generic.at().v;          // velocity where q rests
    if (generic.q.size() != hand.q.size()) continue;  // another family by hand has the rest
    generic.q_dot = reference::solve_least_squares(generic.A(), expected.v - carried);
    const auto found = generic.at();
    EXPECT_LE((found.r - expected.r).norm(), 1e-13 * (1.0 + expected.r.norm())) << "seed " << seed;
    EXPECT_LE((found.v - expected.v).norm(), 1e-13 * (1.0 + expected.v.norm())) << "seed " << seed;

    const VectorXd w0 = VectorXd::Random(expected.r.size());
    VectorXd x(hand.q.size()), w = VectorXd::Zero(w0.size()), w_expected = w;
    (void)hand.family.accelerate(hand.parallel, hand.q.data(), hand.q_dot.data(), w0.data(), nullptr, x.data(),
                                 w_expected.data());
    EXPECT_LT(generic.family.accelerate(generic.parallel, generic.q.data(), generic.q_dot.data(), w0.data(), nullptr,
                                        x.data(), w.data()),
              1e3);
    EXPECT_LE((w - w_expected).norm(), 1e-12 * (1.0 + w_expected.norm())) << "seed " << seed;
  }
  EXPECT_GT(tried, 3);
}

TEST(ChartsByHand, MoveTheirPointsAsTheDefinitionsOfTheirKindsSay) {
  expect_the_same_motion<PointCoordinates<FreeKernel>>(0);
  expect_the_same_motion<PointCoordinates<LineChartKernel>>(1);
  expect_the_same_motion<PointCoordinates<PlaneChartKernel>>(2);
  expect_the_same_motion<PointCoordinates<CircleChartKernel>>(3);
  expect_the_same_motion<PointCoordinates<SphereChartKernel>>(4);
}

TEST(ChartsByHand, FixedCirclesAreThoseOfTheDefinition) {
  System system;
  system.positions = {1.0, 2.0, 0.5, -0.3, 0.4, 1.0};
  system.masses = {1.0, 1.0};
  const CircleCoordinates circles{"", {0, 1}, Vector3{0.1, 0.2, 0.3}, Vector3{1.0, -2.0, 0.5}, {}};
  system.coordinates = {circles};
  const Numbering numbering = number(system);
  VectorXd places(6);
  numbering.gather_points(system.positions, {places.data(), 6});
  auto hand = fill<PointCoordinates<FixedCircleKernel>>(system, numbering, 0.0, places);
  ASSERT_EQ(hand.q.size(), 2);
  auto generic = fill<PointCoordinates<JetChart<CircleCoordinates>>>(system, numbering, 0.0, places);
  hand.q_dot = generic.q_dot = Eigen::Vector2d(0.7, -1.1);

  const auto expected = generic.at();
  const auto found = hand.at();

  EXPECT_LE((hand.q - generic.q).norm(), 1e-14);
  EXPECT_LE((found.v - expected.v).norm(), 1e-14 * expected.v.norm());
  EXPECT_LE((found.psi - expected.psi).norm(), 1e-14 * expected.psi.norm());
}

/// Charts that move leave the motion of the generic kernel unchanged.
TEST(JetChart, RecentringKeepsTheMotion) {
  int moved = 0;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    const RandomCoordinates random = RandomCoordinatesMaker(seed).make({4, 4});
    const Numbering numbering = number(random.system);
    auto filled = fill<PointCoordinates<JetChart<SphereCoordinates>>>(random.system, numbering, 0.6,
                                                                      places_at(random, numbering, 0.6));
    filled.set_numbers(seed);
    VectorXd q_ddot = VectorXd::Random(filled.q.size());
    const auto before = filled.at();
    const VectorXd w = filled.A() * q_ddot + before.psi;
    moved += filled.q.norm() > 0.1;

    filled.family.recentre(0.6, filled.q.data(), filled.q_dot.data(), q_ddot.data());

    const auto after = filled.at();
    EXPECT_LE(filled.q.norm(), 1e-14);
    EXPECT_LE((after.r - before.r).norm(), 1e-14 * (1.0 + before.r.norm())) << "seed " << seed;
    EXPECT_LE((after.v - before.v).norm(), 1e-14 * (1.0 + before.v.norm())) << "seed " << seed;
    EXPECT_LE((filled.A() * q_ddot + after.psi - w).norm(), 1e-13 * (1.0 + w.norm())) << "seed " << seed;
  }
  EXPECT_GT(moved, 10);
}

TEST(JetChart, AKindOfCoordinatesNeedsOneFileAlone) {
  using Family = FamiliesOfCoordinates<Bowls>;
  static_assert(std::is_same_v<Family, std::tuple<PointCoordinates<JetChart<Bowls>>>>);
  System system;
  system.positions = {0.6, 0.3, 0.9, 1.0, 2.0, 3.0};
  system.masses = {1.0, 2.0};
  const Numbering numbering = number(system);
  const VectorFunction origin(ScalarFunction::formula("0.2*t^2"), 0.0, 0.0);
  std::tuple_element_t<0, Family> family;
  family.add(Bowls{{0}, origin, ScalarFunction::formula("2 + t^2")}, {system, numbering, 0.0});
  family.add(Bowls{{1}, {}, {}}, {system, numbering, 0.0});  // its steepness is as drawn, 2 3/(1 + 4)
  ASSERT_EQ(family.num_coordinates(), 4);
  EXPECT_TRUE(family.depends_on_time());
  EXPECT_FALSE(family.has_charts());

  constexpr double t = 0.5, s = 2.0 + t * t;
  family.set_time(t);
  const double q[] = {0.6, 0.3, 1.0, 2.0}, q_dot[] = {0.4, -0.7, 0.0, 1.0};
  std::vector<double> r(6), v(6), psi(6), blocks(12);
  family.evaluate(Parallel(1), q, q_dot, r.data(), v.data(), psi.data(), blocks.data());

  // The surface is z = s (x^2 + y^2)/2, with s' = 2 t and s'' = 2.
  const double square = 0.45, along = 0.6 * 0.4 - 0.3 * 0.7, speed = 0.4 * 0.4 + 0.7 * 0.7;
  const auto first = static_cast<std::size_t>(3 * numbering.inner_point[0]);
  const auto second = static_cast<std::size_t>(3 * numbering.inner_point[1]);
  EXPECT_DOUBLE_EQ(r[first], 0.6 + 0.2 * t * t);
  EXPECT_DOUBLE_EQ(r[first + 2], 0.5 * s * square);
  EXPECT_DOUBLE_EQ(v[first], 0.4 + 0.4 * t);
  EXPECT_DOUBLE_EQ(v[first + 2], t * square + s * along);
  EXPECT_DOUBLE_EQ(psi[first], 0.4);
  EXPECT_DOUBLE_EQ(psi[first + 2], square + 4.0 * t * along + s * speed);
  EXPECT_DOUBLE_EQ(r[second + 2], 3.0);
  EXPECT_DOUBLE_EQ(blocks[2], s * 0.6);
  EXPECT_DOUBLE_EQ(blocks[5], s * 0.3);

  double found[4];
  family.locate(r.data(), found);
  for (std::size_t j = 0; j < 4; ++j) EXPECT_NEAR(found[j], q[j], 1e-15);
}

/// A free point moves by its force in any coordinates.
TEST(JetChart, ThreeCoordinatesOfAPointLeaveItFree) {
  System system;
  system.positions = {0.6, 0.8, 0.9};
  system.masses = {1.0};
  const Numbering numbering = number(system);
  PointCoordinates<JetChart<Cylindrical>> family;
  family.add(Cylindrical{{0}}, {system, numbering, 0.0});
  family.set_time(0.0);
  const double q[] = {1.3, 0.7, -0.2}, q_dot[] = {0.4, -2.0, 1.0};
  const Vec3 w0{0.3, -0.2, -9.81};
  double q_ddot[3], w[3];

  const double condition = family.accelerate(Parallel(1), q, q_dot, nullptr, &w0, q_ddot, w);

  for (const auto& [found, wanted] : {std::pair{w[0], w0.x}, {w[1], w0.y}, {w[2], w0.z}})
    EXPECT_NEAR(found, wanted, 1e-14);
  // rho'' = w.e_rho + rho angle'^2
  EXPECT_NEAR(q_ddot[0], w0.x * std::cos(0.7) + w0.y * std::sin(0.7) + 1.3 * 4.0, 1e-13);
  EXPECT_LT(condition, 10.0);
  const double on_the_axis[] = {0.0, 0.7, 0.0};
  EXPECT_FALSE(std::isfinite(family.accelerate(Parallel(1), on_the_axis, q_dot, nullptr, &w0, q_ddot, w)));
}

/// Chains and bodies tie points to one another. Their families are by hand, and put points where their definitions say.
TEST(ChartsByHand, LinksOfChainsEndWhereTheDefinitionSays) {
  for (const int kind : {5, 6}) {
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
      const RandomCoordinates random = RandomCoordinatesMaker(seed).make({kind});
      const Numbering numbering = number(random.system);
      const VectorXd places = places_at(random, numbering, 0.6);
      auto filled = fill<ChainCoordinates>(random.system, numbering, 0.6, places);
      filled.set_numbers(seed);
      VectorXd r = places;
      filled.family.evaluate(filled.parallel, filled.q.data(), filled.q_dot.data(), r.data(), nullptr, nullptr,
                             nullptr);

      const auto& chain = std::get<ChainAngles>(random.system.coordinates[0]);
      const KindOf<ChainAngles>::Definition<double> now(chain, ClockOf<double>{0.6});
      const auto place = [&](const VectorXd& at, Index point) {
        const Vec3 a = load(at.data(), numbering.inner_point[static_cast<std::size_t>(point)]);
        return TripleOf<double>{a.x, a.y, a.z};
      };
      TripleOf<double> before = place(places, chain.anchor), end = before;
      const std::size_t per_link = kind == 5 ? 2 : 1;
      for (std::size_t k = 0; k < chain.points.size(); ++k) {
        const TripleOf<double> way = place(places, chain.points[k]) - before, unit = way / norm(way);
        end = now.place(end, chain.length.functions[k](0.6).value(), filled.q.data() + per_link * k,
                        {unit.x, unit.y, unit.z});
        EXPECT_LE(norm(end - place(r, chain.points[k])), 1e-13) << "seed " << seed << ", link " << k;
        before = place(places, chain.points[k]);
      }
    }
  }
}

TEST(ChartsByHand, PointsOfBodiesAreWhereTheDefinitionSays) {
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    const RandomCoordinates random = RandomCoordinatesMaker(seed).make({7});
    const Numbering numbering = number(random.system);
    auto filled = fill<BodyCoordinates>(random.system, numbering, 0.0, places_at(random, numbering, 0.0));
    const KindOf<RigidBody>::Definition<double> now(std::get<RigidBody>(random.system.coordinates[0]),
                                                    ClockOf<double>{0.0});
    // The charts lie around the rotation at the start, which is the identity, and around another one.
    std::array<double, 4> centre{1.0, 0.0, 0.0, 0.0};
    for (int turn = 0; turn < 2; ++turn) {
      filled.set_numbers(seed);
      const VectorXd r = filled.at().r;
      std::array<double, 6> q;
      std::copy_n(filled.q.data(), 6, q.begin());
      for (std::size_t p = 0; p < filled.family.points.size(); ++p) {
        const Vec3 arm = filled.family.rho[p], place = load(r.data(), filled.family.points[p]);
        const TripleOf<double> wanted = now.place(q, {arm.x, arm.y, arm.z}, centre);
        EXPECT_LE(norm(wanted - TripleOf<double>{place.x, place.y, place.z}), 1e-13) << "seed " << seed;
      }
      VectorXd q_ddot = VectorXd::Zero(6);
      filled.family.recentre(0.0, filled.q.data(), filled.q_dot.data(), q_ddot.data());
      const double size = std::sqrt(1.0 + 0.25 * (q[3] * q[3] + q[4] * q[4] + q[5] * q[5]));
      centre = {1.0 / size, 0.5 * q[3] / size, 0.5 * q[4] / size, 0.5 * q[5] / size};
    }
  }
}

}  // namespace
}  // namespace tanor
