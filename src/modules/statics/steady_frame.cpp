#include "statics/steady_frame.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include <tanor/forward.hpp>
#include <tanor/user_kernel.hpp>

#include "base/dense.hpp"
#include "base/text.hpp"
#include "statics/carried_parts.hpp"
#include "statics/statics_input.hpp"
#include "statics/unsteady_part.hpp"
#include "system/members.hpp"
#include "system/neighbourhoods.hpp"

namespace tanor::detail {

using Eigen::MatrixXd, Eigen::VectorXd;

namespace {

/// Difference of accelerations, relative to the largest, that counts as rounding of the search.
constexpr double largest_misfit = 1e-9;
/// Instants, in units of the time in which things move, and in seconds where nothing is known to move.
constexpr std::array instants_of_motion{0.0, 0.29, 0.83, 1.7, 3.1};
constexpr std::array instants_of_search{0.0, 7.4e-4, 7.4e-3, 0.074, 0.74, 7.4, 74.0};
/// Part of the scene's size by which configurations are disturbed.
constexpr double disturbed = 0.1;
/// So many other ones determine a frame: one bead has one rate in each, and a frame nine numbers.
constexpr std::size_t num_configurations = 6;

/// The coefficients of R(s) = 1 + first Omega x + second Omega x Omega x, a turn for the time tau, and of its
/// integrals.
template <class T>
struct RotationTerms {
  T first, second, third, fourth;
};

/// Returns them at one time or at all times; the first terms of their series where the angle is small.
template <class T>
RotationTerms<T> rotation_terms(double spin, const T& tau, bool is_small) {
  using std::sin;
  if (is_small) return {tau, T(0.5) * tau * tau, tau * tau * tau / T(6.0), tau * tau * tau * tau / T(24.0)};
  const T square = spin * spin, half = sin(T(0.5 * spin) * tau), first = sin(T(spin) * tau) / T(spin),
          second = T(2.0) * half * half / square;
  return {first, second, (tau - first) / square, (T(0.5) * tau * tau - second) / square};
}
RotationTerms<ExponentialPolynomial> rotation_terms(double spin) {
  return rotation_terms(spin, ExponentialPolynomial::time(), spin == 0.0);
}

/// Returns a vector in numbers or in functions of time, which are told how large the terms were that it is made of.
template <class T>
TripleOf<T> triple(Vec3 a, double size) {
  if constexpr (std::is_same_v<T, double>)
    return {a.x, a.y, a.z};
  else
    return {T(a.x, size), T(a.y, size), T(a.z, size)};
}

/// Returns R(tau) (x - c) + the integral of R(tau - s) (w + a s), from c on.
template <class T>
TripleOf<T> carry_by(const SteadyFrame& frame, Vec3 x, const T& tau, const RotationTerms<T>& by) {
  const double spin = norm(frame.spin);
  const auto itself = [&](Vec3 v) { return triple<T>(v, norm(v)); };
  const auto once = [&](Vec3 v) { return triple<T>(cross(frame.spin, v), spin * norm(v)); };
  const auto twice = [&](Vec3 v) { return triple<T>(cross(frame.spin, cross(frame.spin, v)), spin * spin * norm(v)); };
  const Vec3 arm = x - frame.centre, w = frame.velocity, a = frame.acceleration;
  return itself(x) + by.first * once(arm) + by.second * twice(arm) + tau * itself(w) + by.second * once(w) +
         by.third * twice(w) + T(0.5) * tau * tau * itself(a) + by.third * once(a) + by.fourth * twice(a);
}

}  // namespace

Vec3 SteadyFrame::carry(Vec3 x, double tau) const {
  const double rate = norm(spin);
  const TripleOf<double> place = carry_by(*this, x, tau, rotation_terms(rate, tau, !(std::abs(rate * tau) > 1e-3)));
  return {place.x, place.y, place.z};
}

TripleOf<ExponentialPolynomial> SteadyFrame::carry(Vec3 x) const {
  return carry_by(*this, x, ExponentialPolynomial::time(), rotation_terms(norm(spin)));
}

TripleOf<ExponentialPolynomial> SteadyFrame::turn_back(const TripleOf<ExponentialPolynomial>& a) const {
  const auto by = rotation_terms(norm(spin));
  const auto axis = triple<ExponentialPolynomial>(spin, norm(spin)), once = cross(axis, a);
  return a - by.first * once + by.second * cross(axis, once);
}

std::string SteadyFrame::describe() const {
  const auto list = [](Vec3 a) {
    constexpr int digits = 9;
    const double largest = std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z), 1e-100});
    const double unit = std::pow(10.0, digits - std::ceil(std::log10(largest)));
    const auto rounded = [unit](double x) { return std::round(x * unit) / unit + 0.0; };
    return text(std::array{rounded(a.x), rounded(a.y), rounded(a.z)});
  };
  if (!turns()) {
    return "which moves with " + list(velocity) + " and accelerates by " + list(acceleration);
  }
  // Omega x (p - c) + w has no part across Omega.
  const Vec3 axis = centre + (1.0 / squared(spin)) * cross(spin, velocity);
  const Vec3 along = (dot(velocity, spin) / squared(spin)) * spin;
  return "which turns with " + list(spin) + " about " + list(axis) +
         (squared(along) > 0.0 ? " and moves along that axis with " + list(along) : "");
}

std::vector<std::string> list_what_depends_on_time(const System& system) {
  std::vector<std::string> result;
  for_each_part(system, [&](const std::string&, const std::string& name, const auto& part) {
    if (const std::string fields = name_moving_fields(part); !fields.empty())
      result.push_back(name + " (" + fields + ")");
  });
  return result;
}

namespace {

/// A system at one instant. Numbers have derivatives along the motion of the frame (0), its velocity and its spin along
/// each axis (1 to 3 and 4 to 6, in units of m/s at the ends of the scene), and a motion that is none of a frame (7).
class InstantView {
 public:
  using Number = Forward<8>;

  InstantView(const System& system, const SteadyFrame& frame, double size, double t, double tau, std::size_t number)
      : frame_(frame), size_(size), t_(t), tau_(tau) {
    for (const std::size_t k : {0, 1}) {
      places_[k] = disturb(system, 2 * number + k, disturbed * size);
      for (Vec3& place : places_[k]) place = frame.carry(place, tau);
      put_supports(system, t + tau, &places_[k]);
    }
  }

  Number time() const { return (*this)(Jet<2>::variable(t_ + tau_)); }
  Number operator()(const ScalarFunction& function) const { return (*this)(function(t_ + tau_)); }
  TripleOf<Number> operator()(const VectorFunction& function) const {
    return {(*this)(function.components[0]), (*this)(function.components[1]), (*this)(function.components[2])};
  }
  TripleOf<Number> carry(Index point, std::size_t start) const {
    const auto i = static_cast<std::size_t>(point);
    const Vec3 place = places_[start][i], arm = place - frame_.centre;
    TripleOf<Number> result{place.x, place.y, place.z};
    move(&result, 0, frame_.velocity_at(place, tau_));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      move(&result, 1 + axis, unit(axis));
      move(&result, 4 + axis, (1.0 / size_) * cross(unit(axis), arm));
    }
    move(&result, 7, {irregular(3 * i), irregular(3 * i + 1), irregular(3 * i + 2)});
    return result;
  }
  TripleOf<Number> turn_back(const TripleOf<Number>& a) const {
    TripleOf<Number> turn{0.0, 0.0, 0.0};
    move(&turn, 0, frame_.spin);
    for (std::size_t axis = 0; axis < 3; ++axis) move(&turn, 4 + axis, (1.0 / size_) * unit(axis));
    return a - cross(turn, a);
  }

 private:
  static Vec3 unit(std::size_t axis) { return {axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0}; }
  static void move(TripleOf<Number>* a, std::size_t k, Vec3 by) {
    a->x.d[k] = by.x, a->y.d[k] = by.y, a->z.d[k] = by.z;
  }
  Number operator()(const Jet<2>& now) const {
    Number result(now.value());
    result.d[0] = now.derivative(1);
    return result;
  }

  const SteadyFrame& frame_;
  double size_, t_, tau_;
  std::array<std::vector<Vec3>, 2> places_;
};

/// Returns true if a part takes part in the search. Forces that do not depend on time, and formulas, do not.
template <class Part>
bool tells_frame(const Part& part) {
  if constexpr (requires { part.kernel.expression; }) {
    if (!part.kernel.expression) return false;
  }
  if constexpr (std::is_constructible_v<Force, Part>)
    return !std::is_same_v<Part, FormulaForce> && !name_moving_fields(part).empty();
  else
    return true;
}

/// Finds the frame from the rates at which what it carries along leaves what is prescribed. They are linear in Omega, w
/// and a.
class FrameSearch {
 public:
  FrameSearch(const System& system, double t, double size, Vec3 centre)
      : system_(system), t_(t), size_(size), centre_(centre) {
    choose_instants();
  }

  /// Returns the frame that comes nearest to carrying all along, by the first unknowns: w, a and Omega. It is solved
  /// for twice: what moves away from where it was found says little, and what moves along is told to rounding.
  SteadyFrame solve(Eigen::Index unknowns) {
    constexpr double dependent = 1e-9;
    VectorXd x = VectorXd::Zero(9);
    for (int round = 0; round < 2; ++round) {
      gather_rates(make_frame(x));
      x.head(unknowns) += dense::solve_least_squares(rows_.leftCols(unknowns), -rows_.col(9), dependent);
      // A part of x that rounding alone has made is none.
      const double least = dependent * x.cwiseAbs().maxCoeff();
      for (double& each : x) each = std::abs(each) <= least ? 0.0 : each;
    }
    return make_frame(x);
  }

 private:
  using Rates = Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor>;

  /// Returns the derivatives of the rates of all numbers in w and Omega size, and the rates themselves, m/s: those of
  /// each member over what rigid motions and another one make of its numbers.
  Rates find_rates(const SteadyFrame& frame, double tau, std::size_t number) const {
    const InstantView view(system_, frame, size_, t_, tau, number);
    const CarriedParts<InstantView> parts(system_, view);
    std::vector<double> rates;
    const auto add = [&](std::span<const InstantView::Number> numbers) {
      double square = 0.0;
      for (const InstantView::Number& each : numbers) {
        for (std::size_t k = 1; k < 8; ++k) square += each.d[k] * each.d[k];
      }
      const double scale = std::sqrt(square / static_cast<double>(numbers.size()));
      for (const InstantView::Number& each : numbers) {
        for (const std::size_t k : {1, 2, 3, 4, 5, 6, 0})
          rates.push_back(std::isfinite(each.d[k] / scale) ? each.d[k] / scale : 0.0);
      }
    };
    for_each_part(system_, [&](const std::string&, const std::string&, const auto& part) {
      if (tells_frame(part)) parts.list(part, add);
    });
    return Eigen::Map<Rates>(rates.data(), static_cast<Eigen::Index>(rates.size() / 7), 7);
  }

  /// Chooses instants within the time in which things move as fast as their motion changes, or by the scene's size if
  /// it does not. Tables may end before them.
  void choose_instants() {
    const SteadyFrame at_rest{.centre = centre_};
    instants_.assign(instants_of_search.begin(), instants_of_search.end());
    std::vector<VectorXd> rates;
    std::erase_if(instants_, [this](double tau) { return !is_known_at(tau); });
    for (const double tau : instants_) {
      rates.push_back(find_rates(at_rest, tau, 0).col(6));
      speed_ = std::max(speed_, rates.back().size() > 0 ? rates.back().cwiseAbs().maxCoeff() : 0.0);
    }
    if (speed_ == 0.0) return;
    double change = 0.0;  // m/s^2
    for (std::size_t k = 1; k < rates.size(); ++k)
      change = std::max(change, (rates[k] - rates[k - 1]).cwiseAbs().maxCoeff() / (instants_[k] - instants_[k - 1]));
    constexpr double far = 1e3;  // of the scene's size; rounding of the places is small there
    unit_ = std::min(speed_ / std::max(change, std::numeric_limits<double>::min()), far * size_ / speed_);
    while (!is_known_at(instants_of_motion.back() * unit_)) unit_ *= 0.25;
    instants_.clear();
    for (const double each : instants_of_motion) instants_.push_back(each * unit_);
  }

  /// Returns false if a table ends before that instant.
  bool is_known_at(double tau) const try {
    (void)find_rates({}, tau, 1);
    return true;
  } catch (const InputError&) {
    return false;
  }

  /// Rows [A b] with A dx + b = 0 for changes of x = (w, a unit, Omega size), m/s, from those of a frame. Many rows are
  /// reduced by reflections.
  void gather_rates(const SteadyFrame& frame) {
    constexpr Eigen::Index most = 4096, columns = 10;
    rows_.resize(0, columns);
    for (const double tau : instants_) {
      for (std::size_t k = 0; k < num_configurations; ++k) {
        const Rates rates = find_rates(frame, tau, 2 + k);
        rows_.conservativeResize(rows_.rows() + rates.rows(), columns);
        rows_.bottomRows(rates.rows()) << rates.leftCols(3), tau / unit_ * rates.leftCols(3), rates.rightCols(4);
        if (rows_.rows() > most) rows_ = dense::find_thin_qr(rows_).R;
      }
    }
  }

  SteadyFrame make_frame(const VectorXd& x) const {
    const auto part = [&](Eigen::Index first, double scale) {
      return scale * Vec3{x[first], x[first + 1], x[first + 2]};
    };
    return {part(6, 1.0 / size_), part(0, 1.0), part(3, 1.0 / unit_), centre_};
  }

  const System& system_;
  double t_, size_;
  Vec3 centre_;
  std::vector<double> instants_;  // s, after that of the equilibrium
  double speed_ = 0.0;            // m/s, of what moves
  double unit_ = 1.0;             // s
  MatrixXd rows_;
};

[[noreturn]] void refuse(const System& system, const std::string& where, const std::string& what) {
  const std::string names = name_some(list_what_depends_on_time(system));
  throw InputError(where, what + (names.empty() ? "" : "; what depends on time: " + names) +
                              R"(; "time": "freeze" in /equilibrium takes it all as it is at that instant)");
}

/// Returns the frame that falls freely if its acceleration is that of gravity to the accuracy of the search: what is
/// left of the weight would be rounding.
SteadyFrame fall_freely(const System& system, SteadyFrame frame) {
  Vec3 weight{};
  for (const Force& force : system.forces) {
    if (const auto* const gravity = std::get_if<Gravity>(&force)) weight = weight + make_vec3(gravity->acceleration);
  }
  const Vec3 felt = weight - frame.acceleration - cross(frame.spin, frame.velocity);
  if (norm(felt) <= largest_misfit * norm(weight)) frame.acceleration = weight - cross(frame.spin, frame.velocity);
  return frame;
}

}  // namespace

SteadyFrame find_steady_frame(const System& system, double t) {
  if (list_what_depends_on_time(system).empty()) return {};
  if (const auto part = find_unknown_function(system)) refuse(system, part->where, part->what);
  const double size = scene_size(system);
  std::vector<Vec3> places = disturb(system, 0, 0.0);
  put_supports(system, t, &places);
  SteadyFrame frame;
  for (const Vec3 place : places) frame.centre = frame.centre + (1.0 / static_cast<double>(places.size())) * place;
  std::optional<UnsteadyPart> part = find_unsteady_part(system, frame, t, size);
  if (!part) return frame;
  FrameSearch search(system, t, size, frame.centre);
  for (const Eigen::Index unknowns : {6, 9}) {  // the first without a turn
    frame = search.solve(unknowns);
    part = find_unsteady_part(system, frame, t, size);
    if (!part) return fall_freely(system, frame);
  }
  refuse(system, part->where, part->what);
}

void add_inertia(const SteadyFrame& frame, System* system) {
  // U = m (A.(r - c) - |Omega x (r - c)|^2/2), A = a + Omega x w
  const Vec3 push = frame.acceleration + cross(frame.spin, frame.velocity);
  const auto energy = [frame, push]<class T>(const std::array<std::array<T, 3>, 1>& r, const std::array<T, 1>& mass,
                                             const T&) {
    const T x = r[0][0] - frame.centre.x, y = r[0][1] - frame.centre.y, z = r[0][2] - frame.centre.z;
    const T u = frame.spin.y * z - frame.spin.z * y, v = frame.spin.z * x - frame.spin.x * z,
            w = frame.spin.x * y - frame.spin.y * x;
    return mass[0] * (push.x * x + push.y * y + push.z * z - 0.5 * (u * u + v * v + w * w));
  };
  Potential inertia{.name = "inertia of the frame", .kernel = detail::make_energy_kernel<1, 1>(energy, true)};
  inertia.kernel.depends_on_time = false;
  inertia.constants.emplace_back();
  const std::vector<char> is_support = find_supports(*system);
  for (std::size_t i = 0; i < is_support.size(); ++i) {
    if (is_support[i] != 0) continue;
    inertia.points.push_back({static_cast<Index>(i)});
    inertia.constants[0].push_back(system->masses[i]);
  }
  if (!inertia.points.empty()) system->forces.push_back(std::move(inertia));
}

}  // namespace tanor::detail
