#include "evaluate/circle_kernels.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace tanor;
using namespace tanor::detail;

/// Points on circles of radius 2 about the origin, each in its own plane.
struct Beads {
  std::vector<double> ax, ay, az, bx, by, bz, q, q_dot, q_ddot;
  std::vector<Vec3> center, w;

  explicit Beads(std::size_t count) : q_ddot(count), center(count), w(count) {
    for (std::size_t k = 0; k < count; ++k) {
      const double tilt = 0.1 * static_cast<double>(k), s = 2.0 * std::sin(tilt), c = 2.0 * std::cos(tilt);
      for (auto [list, number] : {std::pair(&ax, 2.0), {&ay, 0.0}, {&az, 0.0}, {&bx, 0.0}, {&by, c}, {&bz, s}})
        list->push_back(number);
      q.push_back(std::sin(3.0 * tilt));
      q_dot.push_back(std::cos(5.0 * tilt));
    }
  }
  double accelerate(Vec3 w0) {
    return circles::accelerate({ax.data(), ay.data(), az.data(), bx.data(), by.data(), bz.data(), center.data()},
                               q.size(), q.data(), q_dot.data(), w0, q_ddot.data(), w.data());
  }
};

constexpr Vec3 gravity{0.3, -0.2, -9.81};

TEST(CircleKernels, AcceleratesAsTheFormulaSaysHoweverFarItHasTurned) {
  constexpr double rounding = 1e-13;
  for (const std::size_t count : {1, 7, 8, 9, 64}) {
    for (const double turned : {0.0, 5e5, 3e7, 1e17}) {
      Beads beads(count);
      beads.q[count / 2] += turned;
      EXPECT_EQ(beads.accelerate(gravity), 0.0);
      for (std::size_t k = 0; k < count; ++k) {
        // With r = a cos q + b sin q, r'' = q'' t - q'^2 r and t.(r'' - w0) = 0.
        const Vec3 a{beads.ax[k], beads.ay[k], beads.az[k]}, b{beads.bx[k], beads.by[k], beads.bz[k]};
        const Vec3 r = std::cos(beads.q[k]) * a + std::sin(beads.q[k]) * b;
        const Vec3 t = std::cos(beads.q[k]) * b - std::sin(beads.q[k]) * a;
        const double along = dot(t, gravity) / dot(t, t);
        EXPECT_NEAR(beads.q_ddot[k], along, rounding * norm(gravity));
        const Vec3 w = along * t - beads.q_dot[k] * beads.q_dot[k] * r;
        EXPECT_LE(norm(beads.w[k] - w), rounding * norm(gravity)) << k << " of " << count << ", turned by " << turned;
      }
    }
  }
}

TEST(CircleKernels, ANanIsToldWhereverItIs) {
  for (const std::size_t count : {1, 8, 13, 64}) {
    for (const std::size_t bead : {std::size_t{0}, count / 2, count - 1}) {
      for (const double number : {std::nan(""), std::numeric_limits<double>::infinity()}) {
        Beads of_angle(count), of_rate(count);
        of_angle.q[bead] = number;
        of_rate.q_dot[bead] = number;
        EXPECT_TRUE(std::isnan(of_angle.accelerate(gravity))) << bead << " of " << count;
        EXPECT_TRUE(std::isnan(of_rate.accelerate(gravity))) << bead << " of " << count;
      }
    }
  }
}

}  // namespace
