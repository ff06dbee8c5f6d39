#pragma once

#include <utility>
#include <vector>

#include <tanor/time_function.hpp>

#include "base/vec3.hpp"

namespace tanor::detail {

/// A vector with its first two derivatives in time.
struct MovingVec3 {
  Vec3 value, first, second;
};

inline MovingVec3 make_moving(const std::array<Jet<2>, 3>& a) {
  return {{a[0].value(), a[1].value(), a[2].value()},
          {a[0].derivative(1), a[1].derivative(1), a[2].derivative(1)},
          {a[0].derivative(2), a[1].derivative(2), a[2].derivative(2)}};
}

/// Scales a vector to unit length, with its derivatives.
struct ToUnit {
  MovingVec3 operator()(const std::array<Jet<2>, 3>& n) const {
    const Jet<2> length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    return make_moving({n[0] / length, n[1] / length, n[2] / length});
  }
};

/// A number with its first two derivatives in time.
struct MovingScalar {
  double value = 0.0, first = 0.0, second = 0.0;
};
inline MovingScalar make_moving(const Jet<2>& a) {
  return {a.value(), a.derivative(1), a.derivative(2)};
}
inline Jet<2> make_jet(const MovingScalar& a) {
  Jet<2> jet;
  jet.c = {a.value, a.first, 0.5 * a.second};
  return jet;
}

struct AsGiven {
  MovingVec3 operator()(const std::array<Jet<2>, 3>& a) const { return make_moving(a); }
  MovingScalar operator()(const Jet<2>& a) const { return make_moving(a); }
};

/// A plane's normal with its length, since the offset is measured along the given normal.
struct PlaneNormal {
  struct Value {
    MovingVec3 unit;
    MovingScalar inverse_length;
  };
  Value operator()(const std::array<Jet<2>, 3>& n) const {
    const Jet<2> inverse = 1.0 / sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    return {make_moving({n[0] * inverse, n[1] * inverse, n[2] * inverse}), make_moving(inverse)};
  }
};

/// Functions of time at one instant, passed through `Shape`. `set_time` touches only those that move, each once; before
/// its first call these are 0.
template <class Function, class Shape>
class MovingTable {
 public:
  using Value = decltype(Shape{}(std::declval<Function>()(0.0)));

  /// Adds a function; returns its slot.
  std::size_t add(const Function& function) {
    if (!function.is_constant()) moving_.emplace_back(now_.size(), function);
    now_.push_back(function.is_constant() ? Shape{}(function(0.0)) : Value{});
    return now_.size() - 1;
  }
  void set_time(double t) {
    for (const auto& [slot, function] : moving_) now_[slot] = Shape{}(function(t));
  }
  const Value& operator[](std::size_t slot) const { return now_[slot]; }
  bool is_constant() const { return moving_.empty(); }

 private:
  std::vector<Value> now_;
  std::vector<std::pair<std::size_t, Function>> moving_;
};

/// Vectors that may depend on time; `Shape` may scale them to unit length.
template <class Shape>
using VectorTable = MovingTable<VectorFunction, Shape>;

/// One number for each member of a family. It may depend on time, and members may share one.
class ScalarTable : private MovingTable<ScalarFunction, AsGiven> {
 public:
  using MovingTable::add, MovingTable::set_time, MovingTable::is_constant;

  /// Gives the number in `slot` to the next member.
  void append_member(std::size_t slot) { slot_.push_back(slot); }
  const MovingScalar& operator[](std::size_t member) const { return MovingTable::operator[](slot_[member]); }

 private:
  std::vector<std::size_t> slot_;
};

}  // namespace tanor::detail
