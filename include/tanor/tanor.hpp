#pragma once

/// \file
/// tanor: motion and reactions of large systems of material points under constraints.
///
/// A trap for readers of the paper: its *inverse problem*, accelerations from forces, is everybody's *forward
/// dynamics* (`Dynamics`, `Simulation`); its *direct problem*, forces from a motion, is everybody's *inverse dynamics*
/// (`InverseDynamics`). Names here are those of the field.

#include <tanor/build_info.hpp>
#include <tanor/certificate.hpp>
#include <tanor/dynamics.hpp>
#include <tanor/enum_names.hpp>
#include <tanor/error.hpp>
#include <tanor/expression.hpp>
#include <tanor/forward.hpp>
#include <tanor/inverse_dynamics.hpp>
#include <tanor/jet.hpp>
#include <tanor/kernel.hpp>
#include <tanor/motion.hpp>
#include <tanor/system.hpp>
#include <tanor/time_function.hpp>
#include <tanor/user_kernel.hpp>
#include <tanor/version.hpp>
