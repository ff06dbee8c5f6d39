#include "contact/one_contact.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "contact/cone.hpp"

namespace tanor::detail {

namespace {

/// Returns W^-1 q.
Vec3 divide(const Block3& W, Vec3 q) {
  const auto row = [&](int i) { return Vec3{W(i, 0), W(i, 1), W(i, 2)}; };
  const Vec3 a = row(0), b = row(1), c = row(2), bc = cross(b, c);
  return (1.0 / dot(a, bc)) * (q.x * bc + q.y * cross(c, a) + q.z * cross(a, b));
}

/// A contact that slides where r_t = mu r_n d, d = (cos a, sin a):
///
///   r_n = -q_n/A,  A = W_nn + mu W_nt d,  A u_t = V = A q_t - q_n (W_tn + mu W_tt d),  d x V = 0,  -d.V > 0
class Sliding {
 public:
  Sliding(const Block3& W, Vec3 q, double mu) : W_(W), q_(q), mu_(mu) {}

  /// Returns d x V and its derivative, and whether r_n > 0 and u_t is against d.
  struct Value {
    double value, derivative;
    bool is_consistent;
  };
  Value at(double angle) const {
    const double c = std::cos(angle), s = std::sin(angle);
    const double A = W_(0, 0) + mu_ * (W_(0, 1) * c + W_(0, 2) * s), dA = mu_ * (W_(0, 2) * c - W_(0, 1) * s);
    const double ty = W_(1, 0) + mu_ * (W_(1, 1) * c + W_(1, 2) * s),
                 tz = W_(2, 0) + mu_ * (W_(2, 1) * c + W_(2, 2) * s);
    const double dty = mu_ * (W_(1, 2) * c - W_(1, 1) * s), dtz = mu_ * (W_(2, 2) * c - W_(2, 1) * s);
    const double vy = A * q_.y - q_.x * ty, vz = A * q_.z - q_.x * tz;
    const double dvy = dA * q_.y - q_.x * dty, dvz = dA * q_.z - q_.x * dtz;
    return {c * vz - s * vy, c * dvz - s * dvy - (s * vz + c * vy), A > 0.0 && -(c * vy + s * vz) > 0.0};
  }
  Vec3 force(double angle) const {
    const double c = std::cos(angle), s = std::sin(angle);
    const double normal = -q_.x / (W_(0, 0) + mu_ * (W_(0, 1) * c + W_(0, 2) * s));
    return {normal, mu_ * normal * c, mu_ * normal * s};
  }
  /// Returns the root that Newton's method finds from a guess.
  std::optional<double> search_from(double angle) const {
    constexpr double least = 1e-15, longest = 0.5;
    for (int k = 0; k < 12; ++k) {
      const auto [value, derivative, is_consistent] = at(angle);
      const double step = -value / derivative;
      if (!(std::abs(step) <= longest)) return {};
      angle += step;
      if (std::abs(step) <= least + 1e-15 * std::abs(angle)) break;
    }
    return at(angle).is_consistent ? std::optional(angle) : std::nullopt;
  }
  /// Returns the consistent root next to a guess, of those that change sign between 16 sectors of a turn.
  std::optional<double> search_around(double guess) const {
    constexpr int sectors = 16;
    constexpr double width = 2.0 * std::numbers::pi / sectors;
    std::optional<double> best;
    const auto distance = [&](double angle) { return std::abs(std::remainder(angle - guess, 2.0 * std::numbers::pi)); };
    for (int k = 0; k < sectors; ++k) {
      double low = guess + (k - sectors / 2) * width, high = low + width, value = at(low).value;
      if (value * at(high).value > 0.0) continue;
      for (int bisection = 0; bisection < 60; ++bisection) {
        const double middle = 0.5 * (low + high), there = at(middle).value;
        (value * there > 0.0 ? low : high) = middle;
        if (value * there > 0.0) value = there;
      }
      if (at(low).is_consistent && (!best || distance(low) < distance(*best))) best = low;
    }
    return best;
  }

 private:
  const Block3& W_;
  Vec3 q_;
  double mu_;
};

}  // namespace

Vec3 solve_one_contact(const Block3& W, Vec3 q, double mu, Vec3 guess) {
  if (q.x >= 0.0) return {};
  if (mu == 0.0) return {-q.x / W(0, 0), 0.0, 0.0};
  const Vec3 stuck = -divide(W, q);
  if (tangential(stuck) <= mu * stuck.x) return stuck;
  const Sliding sliding(W, q, mu);
  const Vec3& start = tangential(guess) > 0.0 ? guess : stuck;
  const double angle = std::atan2(start.z, start.y);
  if (const auto near = sliding.search_from(angle)) return sliding.force(*near);
  const auto around = sliding.search_around(angle);
  return around ? sliding.force(*around) : guess;
}

}  // namespace tanor::detail
