#pragma once

/// \file
/// Kernels of users' own constraints, coordinate maps, forces, energies and laws of friction: one plain function for a
/// batch of members.
///
/// The templates of user_kernel.hpp make a kernel from a generic callable, and the formula factories make one from
/// text. A batch is evaluated in one call, so nothing is called through a pointer member by member. All arrays are row
/// by row; the number of members in a call is the caller's choice. A kernel that is thread_safe may be called from
/// several threads at once; an exception that it throws is rethrown to the caller of the evaluation.

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <tanor/export.hpp>
#include <tanor/expression.hpp>
#include <tanor/time_function.hpp>

namespace tanor {

/// Members of a constraint xi(r, t) = 0 on p points, at one time.
struct ConstraintBatch {
  std::size_t count;
  double t;          ///< s
  const double* r;   ///< [count][3p] positions, m
  const double* v;   ///< [count][3p] velocities, m/s
  double* xi;        ///< [count]
  double* rate;      ///< [count] K'v + xi_t; if null, rate and phi are not wanted and v is not read
  double* phi;       ///< [count] d2 xi/de2 along (r + e v, t + e): K'w = -phi
  double* gradient;  ///< [count][3p] d xi/dr; null if not wanted
};

struct ConstraintKernel {
  int num_points = 0;  ///< p, 1 to 256
  bool thread_safe = true;
  std::shared_ptr<const void> context{};  ///< constants, a callable or a program, passed to `evaluate`
  void (*evaluate)(const void* context, const ConstraintBatch& batch) = nullptr;
  bool depends_on_time = true;  ///< if false, xi does not depend on t: no xi_t, no work through the constraint
  /// The same function of the 3p coordinates and t, for series in time; null if only `evaluate` knows it.
  std::shared_ptr<const Expression> expression{};

  static constexpr int most_points = 256;
};

/// Members of a map r(q, t) from s coordinates to p points, at one time.
struct CoordinateBatch {
  std::size_t count;
  double t;             ///< s
  const double* q;      ///< [count][s]
  const double* q_dot;  ///< [count][s]
  double* r;            ///< [count][3p] m
  double* v;            ///< [count][3p] A q_dot + r_t, m/s; if null, v and psi are not wanted and q_dot is not read
  double* psi;          ///< [count][3p] d2 r/de2 along (q + e q_dot, t + e), m/s^2: w = A q_ddot + psi
  double* tangents;     ///< [count][s][3p] d r/dq_j; null if not wanted
};

struct CoordinateKernel {
  int num_points = 0, num_coordinates = 0;  ///< p, s
  bool thread_safe = true;
  std::shared_ptr<const void> context{};
  void (*evaluate)(const void* context, const CoordinateBatch& batch) = nullptr;
  bool depends_on_time = true;  ///< if false, r_t = 0
  /// The same 3p functions of the s coordinates and t; null if only `evaluate` knows them.
  std::shared_ptr<const Expression> expression{};
};

/// Forces f(r, v, t) on the p points of a tuple, at one time.
struct ForceBatch {
  std::size_t count;
  double t;                      ///< s
  const double* r;               ///< [count][3p] m
  const double* v;               ///< [count][3p] m/s
  double* f;                     ///< [count][3p] N
  double* derivative = nullptr;  ///< [count][3p][6p] of f in r, then in v; null if not wanted
};

struct ForceKernel {
  int num_points = 1;  ///< p, 1 to 8
  bool thread_safe = true;
  std::shared_ptr<const void> context{};
  void (*evaluate)(const void* context, const ForceBatch& batch) = nullptr;
  bool depends_on_velocity = true;
  bool depends_on_time = true;  ///< if false, f does not depend on t: it is there at rest
  /// If false, `derivative` is never asked for, and implicit methods do not see how stiff f is.
  bool knows_derivatives = false;
  /// The same 3p functions of r, v and t, for series in time; null if only `evaluate` knows them.
  std::shared_ptr<const Expression> expression{};

  static constexpr int most_points = 8;
};

/// Members of an energy U(r_1 … r_p, t) of p points, at one time.
struct PotentialBatch {
  std::size_t count;
  double t;                    ///< s
  const double* r;             ///< [count][3p] m
  const double* constants;     ///< [count][c], each member's own
  double* energy;              ///< [count] J
  double* gradient = nullptr;  ///< [count][3p] dU/dr, N; null if not wanted
  double* hessian = nullptr;   ///< [count][3p][3p] d2U/dr dr', N/m; null if not wanted
  double* rate = nullptr;      ///< [count] the explicit dU/dt, W; null if not wanted
};

struct PotentialKernel {
  int num_points = 0;     ///< p, 1 to 8
  int num_constants = 0;  ///< c
  bool thread_safe = true;
  std::shared_ptr<const void> context{};
  void (*evaluate)(const void* context, const PotentialBatch& batch) = nullptr;
  bool depends_on_time = true;  ///< if false, U does not depend on t: no work_of_potentials
  /// U as a function of the 3p coordinates, the c constants and t, from which derivatives of any order follow; null if
  /// only `evaluate` knows U.
  std::shared_ptr<const Expression> expression{};

  static constexpr int most_points = 8;
};

/// Friction at single points that slide along their guides, at one time.
struct FrictionBatch {
  std::size_t count;
  double t;              ///< s
  const double* r;       ///< [count][3] m
  const double* v;       ///< [count][3] velocity along the guide, relative to it, m/s
  const double* lambda;  ///< [count][p] multipliers of the guides' equations at the point, in the order of `at`
  double* tau;           ///< [count][3] N
  double* derivative;    ///< [count][3][p] d tau/d lambda; null if not wanted
};

struct FrictionKernel {
  int num_multipliers = 0;  ///< p, at each point: 1 on a surface, 2 on a wire
  bool thread_safe = true;
  std::shared_ptr<const void> context{};
  void (*evaluate)(const void* context, const FrictionBatch& batch) = nullptr;
};

/// Makes a kernel from xi as text in x1, y1, z1, x2, …, t, pi and the constants, e.g. "sqrt((x2-x1)^2 + (y2-y1)^2) -
/// 1". Throws InputError naming the position inside the text.
TANOR_API ConstraintKernel formula_constraint(std::string_view equation, int num_points,
                                              const Constants& constants = {});

/// Makes a kernel from x, y, z of each point (3p texts) in the coordinates' names, t, pi and the constants. Throws
/// InputError whose where() is "/<number of the component>", or empty if a name is wrong.
TANOR_API CoordinateKernel formula_coordinates(std::span<const std::string> names,
                                               std::span<const std::string> components,
                                               const Constants& constants = {});

/// Makes a kernel from an energy, J, as text in x1, y1, z1, x2, …, t, pi, the constants and the names of the constants
/// that each tuple has of its own. Throws InputError naming the position inside the text.
TANOR_API PotentialKernel formula_potential(std::string_view energy, int num_points, const Constants& constants = {},
                                            std::span<const std::string> own_constants = {});

/// Makes a kernel from the three components of a force, N, in x, y, z, vx, vy, vz, t, pi and the constants. Throws
/// InputError whose where() is "/x", "/y" or "/z".
TANOR_API ForceKernel formula_force(const std::array<std::string, 3>& components, const Constants& constants = {});

/// Makes a kernel from the forces on the points of a tuple, N: 3p texts in x1, y1, z1, …, vx1, vy1, vz1, …, t, pi and
/// the constants. Throws InputError whose where() is "/x1" and so on.
TANOR_API ForceKernel formula_tuple_force(std::span<const std::string> components, const Constants& constants = {});

}  // namespace tanor
