#pragma once

/// \file
/// A user's own constraint or coordinates, written once as a generic callable:
///
///     // a bead on a paraboloid that breathes
///     tanor::make_constraint_kernel<1>([](const auto& x, const auto& t) {
///       return x[2] - (1.0 + 0.1 * sin(t)) * (x[0] * x[0] + x[1] * x[1]);
///     });
///
/// The callable runs on Jet<2>, which yields xi, its rate and phi (r, v and psi) together, and on Forward, which yields
/// the gradient (the tangents). On Traced it is recorded for series of any order. It is instantiated here, on the
/// user's side; the library gets a plain function that loops over a batch. A callable that is thread_safe is called
/// from several threads.

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <tanor/curved.hpp>
#include <tanor/expression.hpp>
#include <tanor/forward.hpp>
#include <tanor/jet.hpp>
#include <tanor/kernel.hpp>

namespace tanor {

namespace detail {

/// The points x + e x_dot of a curve, one jet for each number.
template <std::size_t size>
std::array<Jet<2>, size> load_curve(const double* x, const double* x_dot) {
  std::array<Jet<2>, size> curve;
  for (std::size_t i = 0; i < size; ++i) curve[i] = Jet<2>::variable(x[i], x_dot[i]);
  return curve;
}

template <std::size_t size>
std::array<Forward<static_cast<int>(size)>, size> load_variables(const double* x) {
  std::array<Forward<static_cast<int>(size)>, size> variables;
  for (std::size_t i = 0; i < size; ++i) {
    variables[i] = Forward<static_cast<int>(size)>::variable(x[i], static_cast<int>(i));
  }
  return variables;
}

/// Members of a map from `from` numbers to `to` numbers, at one time.
struct MapBatch {
  std::size_t count;
  double t;
  const double *x, *x_dot;         ///< [count][from]
  double *value, *first, *second;  ///< [count][to] along (x + e x_dot, t + e); if `first` is null, the value alone
  double* partials;                ///< [count][from][to]; may be null
};

/// Evaluates map(x, t) -> std::array<T, to> on Jet<2> for derivatives along the curve, on Forward for partial ones.
template <std::size_t from, std::size_t to, class Map>
void evaluate_map(const Map& map, const MapBatch& batch) {
  if (batch.first != nullptr) {
    const auto t = Jet<2>::variable(batch.t);
    for (std::size_t k = 0; k < batch.count; ++k) {
      const std::array<Jet<2>, to> r = map(load_curve<from>(batch.x + from * k, batch.x_dot + from * k), t);
      for (std::size_t i = 0; i < to; ++i) {
        batch.value[to * k + i] = r[i].value();
        batch.first[to * k + i] = r[i].derivative(1);
        batch.second[to * k + i] = r[i].derivative(2);
      }
    }
  }
  if (batch.partials == nullptr && batch.first != nullptr) return;
  const Forward<static_cast<int>(from)> t(batch.t);
  for (std::size_t k = 0; k < batch.count; ++k) {
    const std::array<Forward<static_cast<int>(from)>, to> r = map(load_variables<from>(batch.x + from * k), t);
    for (std::size_t i = 0; i < to; ++i) {
      batch.value[to * k + i] = r[i].value();
      for (std::size_t j = 0; j < from && batch.partials != nullptr; ++j)
        batch.partials[(from * k + j) * to + i] = r[i].d[j];
    }
  }
}

}  // namespace detail

/// Makes a kernel from callable(const std::array<T, 3p>& x, const T& t) -> T with x = {x1, y1, z1, x2, …}, for T =
/// Jet<2>, Forward<3p> and Traced. A callable that compares its arguments does not run on Traced; adaptive steps may
/// then pass unseen over what changes in a narrow place only, as with forces.
template <int p, class Callable>
ConstraintKernel make_constraint_kernel(Callable&& callable, bool thread_safe = true) {
  static_assert(1 <= p && p <= ConstraintKernel::most_points);
  using Function = std::decay_t<Callable>;
  constexpr std::size_t size = 3 * p;
  ConstraintKernel kernel{.num_points = p, .thread_safe = thread_safe};
  kernel.expression = record_expression(3 * p + 1, [&](const std::vector<Traced>& variables) {
    std::array<Traced, size> x;
    std::copy_n(variables.begin(), size, x.begin());
    return std::vector<Traced>{callable(std::as_const(x), variables[size])};
  });
  kernel.context = std::make_shared<const Function>(std::forward<Callable>(callable));
  kernel.evaluate = [](const void* context, const ConstraintBatch& batch) {
    const Function& function = *static_cast<const Function*>(context);
    detail::evaluate_map<size, 1>(
        [&]<class T>(const std::array<T, size>& x, const T& t) { return std::array<T, 1>{function(x, t)}; },
        {batch.count, batch.t, batch.r, batch.v, batch.xi, batch.rate, batch.phi, batch.gradient});
  };
  return kernel;
}

/// Makes a kernel from `callable(const std::array<T, s>& q, const T& t) -> std::array<T, 3p>`, for `T = Jet<2>` and
/// `Forward<s>`. Adaptive steps may pass unseen over what changes in a narrow place only, as with forces.
template <int p, int s, class Callable>
CoordinateKernel make_coordinate_kernel(Callable&& callable, bool thread_safe = true) {
  static_assert(p >= 1 && s >= 1);
  using Function = std::decay_t<Callable>;
  CoordinateKernel kernel{.num_points = p, .num_coordinates = s, .thread_safe = thread_safe};
  kernel.context = std::make_shared<const Function>(std::forward<Callable>(callable));
  kernel.evaluate = [](const void* context, const CoordinateBatch& batch) {
    detail::evaluate_map<s, 3 * p>(
        *static_cast<const Function*>(context),
        {batch.count, batch.t, batch.q, batch.q_dot, batch.r, batch.v, batch.psi, batch.tangents});
  };
  return kernel;
}

namespace detail {

/// The points and constants of an energy; x(i) is the i-th of all their numbers.
template <class T, int p, int c>
struct EnergyArguments {
  std::array<std::array<T, 3>, p> r;
  std::array<T, c> constants;

  template <class Number>
  explicit EnergyArguments(const Number& x) {
    for (std::size_t i = 0; i < 3 * p; ++i) r[i / 3][i % 3] = x(i);
    for (std::size_t i = 0; i < c; ++i) constants[i] = x(3 * p + i);
  }
};

/// Evaluates the energies of a batch, of p points with c constants each. energy<T>(x) is U on T = double, Forward and
/// Curved, where x(i) is the i-th of the 3p coordinates, the constants and t. Derivatives take a pass for each point,
/// and second ones a pass for each pair of points.
template <class Energy>
void evaluate_energies(const PotentialBatch& batch, std::size_t p, std::size_t c, const Energy& energy) {
  const std::size_t size = 3 * p;
  for (std::size_t k = 0; k < batch.count; ++k) {
    const auto number = [&](std::size_t i) {
      return i < size ? batch.r[size * k + i] : i < size + c ? batch.constants[c * k + i - size] : batch.t;
    };
    // Makes number i the variable number_of(i), or a constant if that is negative.
    const auto run = [&]<class T>(const T*, const auto& number_of) {
      return energy.template operator()<T>([&](std::size_t i) {
        const int variable = number_of(i);
        return variable < 0 ? T(number(i)) : T::variable(number(i), variable);
      });
    };
    const auto place = [](std::size_t i, std::size_t a) { return i / 3 == a ? static_cast<int>(i % 3) : -1; };
    batch.energy[k] = energy.template operator()<double>(number);
    for (std::size_t a = 0; a < p && batch.gradient != nullptr; ++a) {
      const Forward<3> u = run(static_cast<Forward<3>*>(nullptr), [&](std::size_t i) { return place(i, a); });
      std::copy_n(u.d.begin(), 3, batch.gradient + size * k + 3 * a);
    }
    for (std::size_t ab = 0; ab < p * p && batch.hessian != nullptr; ++ab) {
      const std::size_t a = ab / p, b = ab % p, second = a == b ? 0 : 3;
      if (b < a) continue;
      const Curved<6> u = run(static_cast<Curved<6>*>(nullptr), [&](std::size_t i) {
        return i / 3 == b ? static_cast<int>(second + i % 3) : place(i, a);
      });
      double* const hessian = batch.hessian + size * size * k;
      for (std::size_t entry = 0; entry < 9; ++entry) {
        const std::size_t row = 3 * a + entry / 3, column = 3 * b + entry % 3;
        hessian[row * size + column] = hessian[column * size + row] = u.second(entry / 3, second + entry % 3);
      }
    }
    if (batch.rate == nullptr) continue;
    const auto is_time = [&](std::size_t i) { return i == size + c ? 0 : -1; };
    batch.rate[k] = run(static_cast<Forward<1>*>(nullptr), is_time).d[0];
  }
}

/// Makes a kernel from energy(r, constants, t) of p points with c constants each, on T = double, Forward, Curved and
/// Traced.
template <int p, int c, class Energy>
PotentialKernel make_energy_kernel(Energy&& given, bool thread_safe) {
  static_assert(1 <= p && p <= PotentialKernel::most_points);
  using Function = std::decay_t<Energy>;
  PotentialKernel kernel{.num_points = p, .num_constants = c, .thread_safe = thread_safe};
  kernel.expression = record_expression(3 * p + c + 1, [&](const std::vector<Traced>& x) {
    const EnergyArguments<Traced, p, c> at([&](std::size_t i) { return x[i]; });
    return std::vector<Traced>{given(at.r, at.constants, x.back())};
  });
  kernel.context = std::make_shared<const Function>(std::forward<Energy>(given));
  kernel.evaluate = [](const void* context, const PotentialBatch& batch) {
    const Function& energy = *static_cast<const Function*>(context);
    evaluate_energies(batch, p, c, [&]<class T>(const auto& x) {
      const EnergyArguments<T, p, c> at(x);
      return T(energy(at.r, at.constants, T(x(3 * p + c))));
    });
  };
  return kernel;
}

}  // namespace detail

/// Makes a kernel from callable(const std::array<T, 3>& r1, …, const std::array<T, 3>& rp, const T& t) -> T, the energy
/// of p points, J, for T = double, Forward, Curved and Traced. A callable that compares its arguments does not run on
/// Traced; the method `taylor` then has no series of it.
template <int p, class Callable>
PotentialKernel make_potential_kernel(Callable&& callable, bool thread_safe = true) {
  return detail::make_energy_kernel<p, 0>(
      [function = std::forward<Callable>(callable)](const auto& r, const auto&, const auto& t) {
        return std::apply([&](const auto&... each) { return function(each..., t); }, r);
      },
      thread_safe);
}

/// Makes a kernel from callable(const std::array<T, 3>& r, const std::array<T, 3>& v, double t) -> std::array<T, 3>, N,
/// for T = double and Forward<6>: a force on a point at r with velocity v. Nothing else is known about it. If it acts
/// for a short time or in a narrow place only, adaptive steps may pass over it unseen; MotionOptions::max_step should
/// then be the time of its passage.
template <class Callable>
ForceKernel make_force_kernel(Callable&& callable, bool thread_safe = true) {
  using Function = std::decay_t<Callable>;
  ForceKernel kernel{.thread_safe = thread_safe, .knows_derivatives = true};
  kernel.context = std::make_shared<const Function>(std::forward<Callable>(callable));
  kernel.evaluate = [](const void* context, const ForceBatch& batch) {
    const Function& function = *static_cast<const Function*>(context);
    for (std::size_t k = 0; k < batch.count; ++k) {
      std::array<double, 3> r, v;
      std::array<Forward<6>, 3> r_variable, v_variable;
      for (std::size_t i = 0; i < 3; ++i) {
        r[i] = batch.r[3 * k + i];
        v[i] = batch.v[3 * k + i];
        r_variable[i] = Forward<6>::variable(r[i], static_cast<int>(i));
        v_variable[i] = Forward<6>::variable(v[i], static_cast<int>(i + 3));
      }
      if (batch.derivative == nullptr) {
        const std::array<double, 3> f = function(r, v, batch.t);
        for (std::size_t i = 0; i < 3; ++i) batch.f[3 * k + i] = f[i];
        continue;
      }
      const std::array<Forward<6>, 3> f = function(r_variable, v_variable, batch.t);
      for (std::size_t i = 0; i < 3; ++i) {
        batch.f[3 * k + i] = f[i].value();
        for (std::size_t j = 0; j < 6; ++j) batch.derivative[6 * (3 * k + i) + j] = f[i].d[j];
      }
    }
  };
  return kernel;
}

/// Makes a kernel from callable(const Vector3& r, const Vector3& v, double t, const std::array<T, p>& lambda) ->
/// std::array<T, 3>, N, for T = double and Forward<p>: the friction on a point at r that slides with v along its
/// guides, whose p equations have the multipliers lambda. As with forces, steps may pass unseen over short changes.
template <int p, class Callable>
FrictionKernel make_friction_kernel(Callable&& callable, bool thread_safe = true) {
  static_assert(p >= 1);
  using Function = std::decay_t<Callable>;
  FrictionKernel kernel{.num_multipliers = p, .thread_safe = thread_safe};
  kernel.context = std::make_shared<const Function>(std::forward<Callable>(callable));
  kernel.evaluate = [](const void* context, const FrictionBatch& batch) {
    const Function& function = *static_cast<const Function*>(context);
    for (std::size_t k = 0; k < batch.count; ++k) {
      const auto vector = [&](const double* x) { return std::array{x[3 * k], x[3 * k + 1], x[3 * k + 2]}; };
      if (batch.derivative == nullptr) {
        std::array<double, p> lambda;
        for (std::size_t a = 0; a < p; ++a) lambda[a] = batch.lambda[p * k + a];
        const std::array<double, 3> tau = function(vector(batch.r), vector(batch.v), batch.t, lambda);
        for (std::size_t i = 0; i < 3; ++i) batch.tau[3 * k + i] = tau[i];
        continue;
      }
      const std::array<Forward<p>, 3> tau =
          function(vector(batch.r), vector(batch.v), batch.t, detail::load_variables<p>(batch.lambda + p * k));
      for (std::size_t i = 0; i < 3; ++i) {
        batch.tau[3 * k + i] = tau[i].value();
        for (std::size_t a = 0; a < p; ++a) batch.derivative[p * (3 * k + i) + a] = tau[i].d[a];
      }
    }
  };
  return kernel;
}

}  // namespace tanor
