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
    if (batch.rate != nullptr) {
      const auto t = Jet<2>::variable(batch.t);
      for (std::size_t k = 0; k < batch.count; ++k) {
        const Jet<2> xi = function(detail::load_curve<size>(batch.r + size * k, batch.v + size * k), t);
        batch.xi[k] = xi.value();
        batch.rate[k] = xi.derivative(1);
        batch.phi[k] = xi.derivative(2);
      }
    }
    if (batch.gradient != nullptr || batch.rate == nullptr) {
      const Forward<3 * p> t(batch.t);
      for (std::size_t k = 0; k < batch.count; ++k) {
        const Forward<3 * p> xi = function(detail::load_variables<size>(batch.r + size * k), t);
        batch.xi[k] = xi.value();
        if (batch.gradient == nullptr) continue;
        for (std::size_t i = 0; i < size; ++i) batch.gradient[size * k + i] = xi.d[i];
      }
    }
  };
  return kernel;
}

/// Makes a kernel from `callable(const std::array<T, s>& q, const T& t) -> std::array<T, 3p>`, for `T = Jet<2>` and
/// `Forward<s>`. Adaptive steps may pass unseen over what changes in a narrow place only, as with forces.
template <int p, int s, class Callable>
CoordinateKernel make_coordinate_kernel(Callable&& callable, bool thread_safe = true) {
  static_assert(p >= 1 && s >= 1);
  using Function = std::decay_t<Callable>;
  constexpr std::size_t size = 3 * p;
  CoordinateKernel kernel{.num_points = p, .num_coordinates = s, .thread_safe = thread_safe};
  kernel.context = std::make_shared<const Function>(std::forward<Callable>(callable));
  kernel.evaluate = [](const void* context, const CoordinateBatch& batch) {
    const Function& function = *static_cast<const Function*>(context);
    if (batch.v != nullptr) {
      const auto t = Jet<2>::variable(batch.t);
      for (std::size_t k = 0; k < batch.count; ++k) {
        const std::array<Jet<2>, size> r = function(detail::load_curve<s>(batch.q + s * k, batch.q_dot + s * k), t);
        for (std::size_t i = 0; i < size; ++i) {
          batch.r[size * k + i] = r[i].value();
          batch.v[size * k + i] = r[i].derivative(1);
          batch.psi[size * k + i] = r[i].derivative(2);
        }
      }
    }
    if (batch.tangents != nullptr || batch.v == nullptr) {
      const Forward<s> t(batch.t);
      for (std::size_t k = 0; k < batch.count; ++k) {
        const std::array<Forward<s>, size> r = function(detail::load_variables<s>(batch.q + s * k), t);
        for (std::size_t i = 0; i < size; ++i) {
          batch.r[size * k + i] = r[i].value();
          if (batch.tangents == nullptr) continue;
          for (std::size_t j = 0; j < s; ++j) batch.tangents[(s * k + j) * size + i] = r[i].d[j];
        }
      }
    }
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

/// Makes a kernel from energy(r, constants, t) of p points with c constants each, on T = double, Forward, Curved and
/// Traced.
template <int p, int c, class Energy>
PotentialKernel make_energy_kernel(Energy&& given, bool thread_safe) {
  static_assert(1 <= p && p <= PotentialKernel::most_points);
  using Function = std::decay_t<Energy>;
  constexpr std::size_t size = 3 * p;
  PotentialKernel kernel{.num_points = p, .num_constants = c, .thread_safe = thread_safe};
  kernel.expression = record_expression(3 * p + c + 1, [&](const std::vector<Traced>& x) {
    const EnergyArguments<Traced, p, c> at([&](std::size_t i) { return x[i]; });
    return std::vector<Traced>{given(at.r, at.constants, x.back())};
  });
  kernel.context = std::make_shared<const Function>(std::forward<Energy>(given));
  kernel.evaluate = [](const void* context, const PotentialBatch& batch) {
    const Function& energy = *static_cast<const Function*>(context);
    const auto run = [&]<class T>(std::size_t k, const T& t, const auto& variable) {
      const EnergyArguments<T, p, c> at([&](std::size_t i) {
        return i < size ? T(variable(batch.r[size * k + i], i)) : T(batch.constants[c * k + i - size]);
      });
      return T(energy(at.r, at.constants, t));
    };
    for (std::size_t k = 0; k < batch.count; ++k) {
      if (batch.hessian != nullptr) {
        using T = Curved<static_cast<int>(size)>;
        const T u = run(k, T(batch.t), [](double x, std::size_t i) { return T::variable(x, static_cast<int>(i)); });
        for (std::size_t i = 0; i < size * size; ++i) batch.hessian[size * size * k + i] = u.second(i / size, i % size);
      }
      batch.energy[k] = run(k, batch.t, [](double x, std::size_t) { return x; });
      if (batch.gradient != nullptr) {
        using T = Forward<static_cast<int>(size)>;
        const T u = run(k, T(batch.t), [](double x, std::size_t i) { return T::variable(x, static_cast<int>(i)); });
        std::copy_n(u.d.begin(), size, batch.gradient + size * k);
      }
      if (batch.rate != nullptr)
        batch.rate[k] =
            run(k, Forward<1>::variable(batch.t, 0), [](double x, std::size_t) { return Forward<1>(x); }).d[0];
    }
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
