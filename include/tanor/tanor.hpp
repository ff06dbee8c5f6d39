#pragma once

/// \file
/// tanor: motion and reactions of large systems of material points under constraints.

#include <tanor/certificate.hpp>
#include <tanor/direct_problem.hpp>
#include <tanor/dynamics.hpp>
#include <tanor/error.hpp>
#include <tanor/expression.hpp>
#include <tanor/forward.hpp>
#include <tanor/jet.hpp>
#include <tanor/kernel.hpp>
#include <tanor/motion.hpp>
#include <tanor/system.hpp>
#include <tanor/time_function.hpp>
#include <tanor/user_kernel.hpp>
#include <tanor/version.hpp>
