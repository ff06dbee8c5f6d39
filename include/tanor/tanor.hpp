#pragma once

/// \file
/// tanor: motion and reactions of large systems of material points under constraints.
///
/// The equations are a differential-algebraic system of index 3 (DAE): M w = f + K lambda under xi(r, t) = 0, with the
/// constraint Jacobian J = K' = d xi/d r' and the Lagrange multipliers lambda. These solve S lambda = -(phi + K'M^-1 f)
/// with the Schur complement S = K'M^-1K (Delassus operator).
///
/// Readers of the paper should note its terms. Its *inverse problem*, accelerations from forces, is the *forward
/// dynamics* of the field (`Dynamics`, `Simulation`); its *direct problem*, forces from a motion, is *inverse dynamics*
/// (`InverseDynamics`). Names here are those of the field.
///
/// This header does not include <tanor/constrainer.hpp> and <tanor/velocity_verlet.hpp>, for programs with a time loop
/// of their own, <tanor/recorded.hpp> for their energies, <tanor/report_fields.hpp> for loops over the fields of
/// reports, <tanor.h> for C, and <tanor/direct_problem.hpp>, an old name.

#include <tanor/build_info.hpp>
#include <tanor/certificate.hpp>
#include <tanor/dynamics.hpp>
#include <tanor/enum_names.hpp>
#include <tanor/equilibrium.hpp>
#include <tanor/error.hpp>
#include <tanor/expression.hpp>
#include <tanor/forward.hpp>
#include <tanor/inverse_dynamics.hpp>
#include <tanor/jet.hpp>
#include <tanor/kernel.hpp>
#include <tanor/modes.hpp>
#include <tanor/motion.hpp>
#include <tanor/statics_names.hpp>
#include <tanor/system.hpp>
#include <tanor/time_function.hpp>
#include <tanor/user_kernel.hpp>
#include <tanor/version.hpp>
#include <tanor/warnings.hpp>
