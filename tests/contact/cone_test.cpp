/// The projection onto the friction cone, and one contact exactly.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <vector>

#include "contact/cone.hpp"
#include "contact/one_contact.hpp"
#include "random_numbers.hpp"

namespace tanor::detail {
namespace {

bool is_in_cone(Vec3 r, double mu) {
  return tangential(r) <= mu * r.x + 1e-14 * norm(r);
}

/// The projection p is in the cone, y - p is in the polar one, -(y - p) in K_(1/mu), and the two are orthogonal.
TEST(Cone, ProjectionsAreTheNearestForces) {
  const std::vector<double> numbers = uniform_numbers(3000, 3);
  for (std::size_t k = 0; k < 1000; ++k) {
    const Vec3 y = load(numbers.data(), k);
    const double mu = k % 10 == 0 ? 0.0 : 0.003 * static_cast<double>(k);
    const Vec3 p = project_onto_cone(y, mu), rest = p - y;
    EXPECT_TRUE(is_in_cone(p, mu)) << k;
    EXPECT_GE(rest.x, mu * tangential(rest) - 1e-14) << k;
    EXPECT_NEAR(dot(p, rest), 0.0, 1e-14) << k;
  }
}

TEST(Cone, DerivativesAreThoseOfProjections) {
  const std::vector<double> numbers = uniform_numbers(3000, 4), directions = uniform_numbers(3000, 5);
  constexpr double h = 1e-6;
  for (std::size_t k = 0; k < 1000; ++k) {
    const Vec3 y = load(numbers.data(), k), d = load(directions.data(), k);
    const double mu = 0.002 * static_cast<double>(k), t = tangential(y);
    if (std::abs(t - mu * y.x) < 1e-4 || std::abs(y.x + mu * t) < 1e-4) continue;  // a kink
    const Vec3 difference = (0.5 / h) * (project_onto_cone(y + h * d, mu) - project_onto_cone(y - h * d, mu));
    EXPECT_LT(norm(derive_projection(y, mu) * d - difference), 1e-7) << k;
  }
}

/// Solutions of 60 digits, with residuals below 1e-27.
TEST(OneContact, ForcesAreThoseOfPublishedDigits) {
  struct Case {
    Block3 W;
    Vec3 q;
    double mu;
    Vec3 r;
  };
  const Case cases[] = {
      {{{1.3356, 0.5002, -0.5484, 0.5002, 1.4593, -0.6044, -0.5484, -0.6044, 1.4749}}, {0.16, 0.666667, 3.3}, 0.1, {}},
      {{{1.5866, -0.5652, -0.46, -0.5652, 0.5998, 0.3404, -0.46, 0.3404, 0.34}},
       {-1.72, 1.56667, -1.2},
       0.1,
       {1.09261403411439732394, -0.0535524475449461075, 0.09523754321370942213}},
      {{{1.0205, 0.0353, 0.3076, 0.0353, 1.3502, 1.2439, 0.3076, 1.2439, 1.3197}}, {0.06, -2.7, -2.13333}, 0.7, {}},
      {{{0.8666, 0.1286, 0.162, 0.1286, 2.4261, -0.2453, 0.162, -0.2453, 1.4353}},
       {-1.56, -1.9, -0.833333},
       0.3,
       {1.68976120025490982198, 0.45015291543142161275, 0.23310666009021190656}},
      {{{0.9898, -0.8744, -0.5758, -0.8744, 0.9239, 0.7053, -0.5758, 0.7053, 0.8831}},
       {-1.22, -3.13333, -0.233333},
       0.3,
       {1.74369196062975047967, 0.51376581534508044603, 0.09841867609167885161}},
      {{{0.8617, 0.6365, -0.3129, 0.6365, 0.8098, -0.3152, -0.3129, -0.3152, 1.5927}},
       {-0.46, 2.46667, 2.73333},
       0.3,
       {0.59045671751023009565, -0.1337548459098663384, -0.1161342471814146733}},
      {{{0.787, 0.0552, 0.2401, 0.0552, 0.7758, 0.1047, 0.2401, 0.1047, 0.4141}},
       {-0.78, 2.7, -1.8},
       0.1,
       {0.98210795675830034524, -0.0850832542821472907, 0.04905303485044630878}},
      {{{1.8956, -0.8844, -0.2698, -0.8844, 0.9605, 0.0274, -0.2698, 0.0274, 0.2281}},
       {-1.02, 1.63333, -3.23333},
       0.3,
       {0.53608212764955390846, -0.0508453387182332354, 0.15257560687509215096}},
      {{{1.7777, -0.5641, -1.2313, -0.5641, 1.1262, 0.6142, -1.2313, 0.6142, 1.1066}},
       {-1.1, 1.06667, -0.3},
       0.7,
       {0.90460361397121965543, -0.3075064854990570575, 0.55354361490023168003}},
  };
  for (const auto& [W, q, mu, r] : cases) EXPECT_LT(norm(solve_one_contact(W, q, mu, {}) - r), 1e-14);
}

/// A ball without constraints: W = diag(n, t, t), so that r_n = -q_n/n, and friction stops what it can.
TEST(OneContact, ABallSlidesOrSticks) {
  const Block3 W{{2.0, 0, 0, 0, 7.0, 0, 0, 0, 7.0}};
  EXPECT_LT(norm(solve_one_contact(W, {-4.0, 3.0, -4.0}, 0.3, {}) - Vec3{2.0, -0.36, 0.48}), 1e-14);
  EXPECT_LT(norm(solve_one_contact(W, {-4.0, 3.0, -4.0}, 0.5, {}) - Vec3{2.0, -3.0 / 7.0, 4.0 / 7.0}), 1e-14);
  EXPECT_LT(norm(solve_one_contact(W, {-4.0, 3.0, -4.0}, 0.0, {}) - Vec3{2.0, 0.0, 0.0}), 1e-14);
  const Block3 without_tangents{{2.0, 0, 0, 0, 0, 0, 0, 0, 0}};
  EXPECT_LT(norm(solve_one_contact(without_tangents, {-4.0, 0.0, 0.0}, 0.0, {}) - Vec3{2.0, 0.0, 0.0}), 1e-14);
  EXPECT_EQ(norm(solve_one_contact(W, {4.0, 3.0, -4.0}, 0.3, {1.0, 0.2, 0.0})), 0.0);
}

/// For any W = GG' + I/10 the laws hold: u_n = 0, and r_t = -mu r_n u_t/|u_t| or u_t = 0, from whatever guess.
RC_GTEST_PROP(OneContact, LawsHold, ()) {
  const auto seed = *rc::gen::arbitrary<unsigned>();
  const std::vector<double> numbers = uniform_numbers(16, seed);
  Block3 W;
  W.add_identity(0.1);
  for (std::size_t k = 0; k < 3; ++k) W.add_product(1.0, load(numbers.data(), k), load(numbers.data(), k));
  const Vec3 q = load(numbers.data(), 3), guess = load(numbers.data(), 4);
  const double coupling = std::hypot(W(0, 1), W(0, 2));
  const double mu = std::abs(numbers[15]) * 0.45 * W(0, 0) / coupling;  // below W_nn/|W_nt|: one solution
  const Vec3 r = solve_one_contact(W, q, mu, guess), u = W * r + q;
  if (q.x >= 0.0) {
    RC_ASSERT(norm(r) == 0.0);
    return;
  }
  constexpr double little = 1e-11;
  const double size = norm(r) * (W(0, 0) + W(1, 1) + W(2, 2)) + norm(q);
  RC_ASSERT(is_in_cone(r, mu));
  RC_ASSERT(std::abs(u.x) <= little * size);
  RC_ASSERT(std::abs(r.y * u.y + r.z * u.z + mu * r.x * tangential(u)) <= little * size * norm(r));
}

}  // namespace
}  // namespace tanor::detail
