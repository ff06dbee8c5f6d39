#pragma once

#include <memory>
#include <string>
#include <vector>

#include <tanor/expression.hpp>

#include "python/values.hpp"

/// \file
/// Functions of Python over a scalar type. They are called once, with numbers that record what is done to them.
namespace tanor::python {

/// Records what function(r1, …, rp, t, **constants) does to the places r [3] of p points, the time and named constants,
/// as an expression in the 3p coordinates, the constants and t. Throws InputError if it returns no number, and whatever
/// the function raises.
std::shared_ptr<const Expression> record_energy(const Given& definition, int num_points,
                                                const std::vector<std::string>& constants);

}  // namespace tanor::python
