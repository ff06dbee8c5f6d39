#pragma once

#include "python/values.hpp"

/// \file
/// Functions that users write in Python: functions of time, and the kernels of their own forces, constraints and
/// friction.
namespace tanor::python {

/// Reads a text, a Formula, a Table or a callable t -> (value, first derivative, second derivative).
ScalarFunction function_of_time(const Given& given);
/// Reads a Table with three columns, or a callable t -> the same three, float [3] each.
VectorFunction vector_function_of_time(const Given& given);

/// Reads three texts, or a callable (t, r [k, 3], v [k, 3]) -> f [k, 3], N. For tuples of `num_points` > 0 points it
/// reads three texts for each of them, or a callable (t, r [k, p, 3], v [k, p, 3]) -> f [k, p, 3].
void read(const Given& given, int num_points, ForceKernel* kernel);
/// Reads a text in x1, y1, z1, x2, …, or a callable (t, r [k, p, 3], v [k, p, 3]) -> (xi [k], gradient [k, p, 3], rate
/// [k], phi [k]). `num_points` is p.
void read(const Given& given, int num_points, ConstraintKernel* kernel);
/// Reads a text in x1, y1, z1, x2, …, t and the names for which each tuple has a number of its own, a Definition, or a
/// callable r [k, p, 3] -> (energy [k], gradient [k, p, 3], hessian [k, 3p, 3p]), whose hessian may be None if no
/// method asks for it. `num_points` is p.
void read(const Given& given, int num_points, const std::vector<std::string>& own_constants, PotentialKernel* kernel);
/// Reads a callable (t, r [k, 3], v [k, 3], multipliers [k, p]) -> (tau [k, 3], derivative [k, 3, p]).
/// `num_multipliers` is p.
void read(const Given& given, int num_multipliers, FrictionKernel* kernel);
/// Reads texts x, y, z of each point, in the names of the coordinates.
void read(const Given& given, const std::vector<std::string>& names, CoordinateKernel* kernel);

}  // namespace tanor::python
