#pragma once

/// \file Functions that steps must not jump over, with their integrals in closed form: pulses, windows, waves.

#include <cmath>
#include <functional>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include <tanor/tanor.hpp>

namespace tanor {

/// A function of time with its derivative and its first two integrals from 0.
class Unseen {
 public:
  enum class Shape { Pulse, Triangle, Window, Wave };

  /// Places the function around `center`, as wide as `width`; a wave has that period and lasts all the time.
  Unseen(Shape shape, double height, double center, double width)
      : shape_(shape), height_(height), center_(center), width_(width) {}

  /// Returns the function as a formula in t.
  std::string text() const {
    std::ostringstream out;
    out.precision(17);
    const auto ramp = [&](double begin, double length) {
      out << "min(1, max(0, (t - (" << begin << "))/" << length << "))";
    };
    out << height_ << "*(";
    switch (shape_) {
      case Shape::Pulse:
        out << "exp(-((t - (" << center_ << "))/" << width_ << ")^2)";
        break;
      case Shape::Triangle:
        out << "max(0, 1 - abs(t - (" << center_ << "))/" << 0.5 * width_ << ")";
        break;
      case Shape::Window:
        ramp(center_ - 0.5 * width_, 0.1 * width_);
        out << " - ";
        ramp(center_ + 0.4 * width_, 0.1 * width_);
        break;
      case Shape::Wave:
        out << "sin(" << 2.0 * std::numbers::pi / width_ << "*t)";
        break;
    }
    out << ")";
    return out.str();
  }

  double value(double t) const {
    switch (shape_) {
      case Shape::Pulse:
        return height_ * std::exp(-square(u(t)));
      case Shape::Wave:
        return height_ * std::sin(rate() * t);
      default:
        return height_ * ramps(t, [](double x) { return std::max(0.0, x); });
    }
  }
  double slope(double t) const {
    switch (shape_) {
      case Shape::Pulse:
        return -2.0 * u(t) / width_ * value(t);
      case Shape::Wave:
        return height_ * rate() * std::cos(rate() * t);
      default:
        return height_ * ramps(t, [](double x) { return x > 0.0 ? 1.0 : 0.0; });
    }
  }
  double integral(double t) const { return first(t) - first(0.0); }
  double second_integral(double t) const { return second(t) - second(0.0) - t * first(0.0); }

  double center() const { return center_; }
  double width() const { return width_; }
  /// Returns where the function is not smooth.
  std::vector<double> corners() const {
    if (shape_ == Shape::Triangle) return {center_ - 0.5 * width_, center_, center_ + 0.5 * width_};
    if (shape_ == Shape::Window)
      return {center_ - 0.5 * width_, center_ - 0.4 * width_, center_ + 0.4 * width_, center_ + 0.5 * width_};
    return {};
  }

 private:
  static double square(double x) { return x * x; }
  double u(double t) const { return (t - center_) / width_; }
  double rate() const { return 2.0 * std::numbers::pi / width_; }

  /// Returns the sum of slope jumps times f(t - corner).
  template <class Function>
  double ramps(double t, const Function& f) const {
    if (shape_ == Shape::Triangle) {
      const double s = 2.0 / width_;
      return s * (f(t - center_ + 0.5 * width_) - 2.0 * f(t - center_) + f(t - center_ - 0.5 * width_));
    }
    const double s = 10.0 / width_;
    return s * (f(t - center_ + 0.5 * width_) - f(t - center_ + 0.4 * width_) - f(t - center_ - 0.4 * width_) +
                f(t - center_ - 0.5 * width_));
  }
  double first(double t) const {
    switch (shape_) {
      case Shape::Pulse:
        return 0.5 * std::sqrt(std::numbers::pi) * height_ * width_ * std::erf(u(t));
      case Shape::Wave:
        return -height_ / rate() * std::cos(rate() * t);
      default:
        return height_ * ramps(t, [](double x) { return x > 0.0 ? 0.5 * x * x : 0.0; });
    }
  }
  double second(double t) const {
    switch (shape_) {
      case Shape::Pulse:
        // The second integral of a pulse is w^2 h/2 (sqrt(pi) u erf(u) + exp(-u^2)).
        return 0.5 * height_ * width_ * width_ *
               (std::sqrt(std::numbers::pi) * u(t) * std::erf(u(t)) + std::exp(-square(u(t))));
      case Shape::Wave:
        return -height_ / square(rate()) * std::sin(rate() * t);
      default:
        return height_ * ramps(t, [](double x) { return x > 0.0 ? x * x * x / 6.0 : 0.0; });
    }
  }

  Shape shape_;
  double height_, center_, width_;
};

/// Integrates f over [0, end] by Gauss & Legendre (10 points) on pieces that are cut at the corners of g and fine
/// around its center.
inline double integrate(const std::function<double(double)>& f, double end, const Unseen& g) {
  static constexpr std::array<double, 5> x{0.1488743389816312, 0.4333953941292472, 0.6794095682990244,
                                           0.8650633666889845, 0.9739065285171717};
  static constexpr std::array<double, 5> w{0.2955242247147529, 0.2692667193099963, 0.2190863625159821,
                                           0.1494513491505806, 0.0666713443086881};
  std::vector<double> cuts{0.0, end};
  for (int k = -40; k <= 40; ++k) cuts.push_back(g.center() + 0.25 * k * g.width());
  for (int k = 1; k < 400; ++k) cuts.push_back(end * k / 400);
  for (const double corner : g.corners()) cuts.push_back(corner);
  std::erase_if(cuts, [&](double t) { return t < 0.0 || t > end; });
  std::sort(cuts.begin(), cuts.end());
  long double sum = 0.0L;
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    const double middle = 0.5 * (cuts[i - 1] + cuts[i]), half = 0.5 * (cuts[i] - cuts[i - 1]);
    for (std::size_t k = 0; k < x.size(); ++k)
      sum += static_cast<long double>(half * w[k]) * (f(middle - half * x[k]) + f(middle + half * x[k]));
  }
  return static_cast<double>(sum);
}

/// A block of 1 kg on a line with |N| = load, drawn by f(t) over a belt that moves with u(t). It sticks and slips in
/// closed form between instants that bisection finds.
class RoughBlock {
 public:
  RoughBlock(const Unseen* force, const Unseen* belt, double friction) : f_(force), u_(belt), limit_(friction) {}

  double x = 0.0, v = 0.0;

  void advance(double end, double finest) {
    double t = 0.0;
    int mode = slide_of(0.0);
    double begin = 0.0, x0 = x, v0 = v;   // of the present mode
    const auto leaves = [&](double at) {  // goes on while > 0
      if (mode == 0) return limit_ - std::abs(pull(at));
      const double speed = v0 + work(begin, at) - mode * limit_ * (at - begin);
      return mode * (speed - belt(at));
    };
    const auto move_to = [&](double at) {
      if (mode == 0) {
        x = x0 + (u_ != nullptr ? u_->integral(at) - u_->integral(begin) : 0.0);
        v = belt(at);
      } else {
        const double h = at - begin;
        x = x0 + v0 * h - 0.5 * mode * limit_ * h * h;
        if (f_ != nullptr) x += f_->second_integral(at) - f_->second_integral(begin) - h * f_->integral(begin);
        v = v0 + work(begin, at) - mode * limit_ * h;
      }
    };
    bool has_risen = false;
    while (t < end) {
      const double next = std::min(end, t + finest);
      const double after = leaves(next);
      if (after > 0.0) has_risen = true;
      if (after < 0.0) {
        double low = t, high = next;
        // A difference that begins at 0 rises first.
        for (int k = 0; k < 60 && has_risen; ++k) {
          const double middle = 0.5 * (low + high);
          (leaves(middle) > 0.0 ? low : high) = middle;
        }
        const double at = has_risen ? high : t;
        move_to(at);
        begin = t = at;
        x0 = x;
        const int before = mode;
        if (before != 0) v = belt(at);
        v0 = v;
        mode = before == 0 ? (pull(at) > 0.0 ? 1 : -1) : std::abs(pull(at)) <= limit_ ? 0 : (pull(at) > 0.0 ? 1 : -1);
        has_risen = false;
        if (++switches > 100000) return;
        continue;
      }
      t = next;
    }
    move_to(end);
  }
  int switches = 0;

 private:
  double belt(double t) const { return u_ != nullptr ? u_->value(t) : 0.0; }
  /// Returns the force that friction has to hold.
  double pull(double t) const { return (f_ != nullptr ? f_->value(t) : 0.0) - (u_ != nullptr ? u_->slope(t) : 0.0); }
  double work(double a, double b) const { return f_ != nullptr ? f_->integral(b) - f_->integral(a) : 0.0; }
  int slide_of(double t) const {
    const double relative = v - belt(t);
    if (relative != 0.0) return relative > 0.0 ? 1 : -1;
    return std::abs(pull(t)) <= limit_ ? 0 : pull(t) > 0.0 ? 1 : -1;
  }

  const Unseen *f_, *u_;
  double limit_;
};

}  // namespace tanor
