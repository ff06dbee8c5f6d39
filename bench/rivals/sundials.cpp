/// Runs SUNDIALS on r'' = w(r, v), with the normal form and its projections written by hand.
///
///     rival_sundials PROBLEM SIZE METHOD TOLERANCE FILE
///
/// METHOD: erk5, erk8 (ARKODE, Dormand & Prince 5(4), Fehlberg 8(7); projected after each step), sdirk (likewise,
/// Kvaerno 5(4), implicit), adams (CVODE, which offers no projection with it), bdf (CVODE with projection), ida (IDA on
/// the stabilised form of index 2); bdf2, ida2: up to order 2, which damps no swing and is stable on all.
/// Implicit steps use fixed-point iteration where nothing is stiff, otherwise Newton's method with LinearSolver.

#include "sundials_ida.hpp"

#include <arkode/arkode_arkstep.h>
#include <cvode/cvode.h>
#include <cvode/cvode_proj.h>
#include <sunlinsol/sunlinsol_band.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunmatrix/sunmatrix_band.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

namespace rivals {
namespace {

/// Computes y' = (v, w) for y = (r, v), or bead by bead.
int find_slope(realtype t, N_Vector y, N_Vector slope, void* user) {
  auto& motion = *static_cast<Motion*>(user);
  double* out = N_VGetArrayPointer(slope);
  const double* state = motion.read(N_VGetArrayPointer(y));
  std::vector<double>& rates = motion.rates;
  std::copy_n(state + motion.size, motion.size, rates.data());
  motion.accelerations(t, state, state + motion.size, rates.data() + motion.size);
  motion.write(rates.data(), out);
  return 0;
}

Motion* current = nullptr;  // ARKODE's post-processing gets another pointer in some versions

int project_state(realtype t, N_Vector y, void*) {
  double* state = current->read(N_VGetArrayPointer(y));
  current->project(t, state, projection_share * current->tolerance);
  current->write(state, N_VGetArrayPointer(y));
  return 0;
}

/// Computes the correction for CVODE, and removes the normal part of the error.
int find_correction(realtype t, N_Vector y, N_Vector correction, realtype, N_Vector error, void* user) {
  auto& motion = *static_cast<Motion*>(user);
  const double* old = N_VGetArrayPointer(y);
  double *change = N_VGetArrayPointer(correction), *state = motion.read(old);
  motion.project(t, state, projection_share * motion.tolerance);
  motion.write(state, change);
  for (int i = 0; i < 2 * motion.size; ++i) change[i] -= old[i];
  if (error) {
    std::copy_n(state, motion.size, motion.rates.data());
    double* parts = motion.read(N_VGetArrayPointer(error));
    for (double* u : {parts, parts + motion.size}) motion.remove_normal_part(t, motion.rates.data(), u);
    motion.write(parts, N_VGetArrayPointer(error));
  }
  return 0;
}

/// The linear solver of Newton's matrix, which is made by differences. The car axis is small and dense. With springs w
/// of
/// a bead depends on those up to two links away, so that the matrix is a band in the order bead by bead. In honey GMRES
/// meets nearly one eigenvalue.
struct LinearSolver {
  SUNMatrix matrix = nullptr;
  SUNLinearSolver solver = nullptr;

  LinearSolver(const Motion& motion, N_Vector y, SUNContext context) {
    constexpr int half_band = 17;
    if (motion.problem.is_car_axis) {
      matrix = SUNDenseMatrix(2 * motion.size, 2 * motion.size, context);
      solver = SUNLinSol_Dense(y, matrix, context);
    } else if (motion.is_bead_by_bead) {
      matrix = SUNBandMatrix(2 * motion.size, half_band, half_band, context);
      solver = SUNLinSol_Band(y, matrix, context);
    } else {
      solver = SUNLinSol_SPGMR(y, SUN_PREC_NONE, 20, context);
    }
  }
  LinearSolver(const LinearSolver&) = delete;
  LinearSolver& operator=(const LinearSolver&) = delete;
  ~LinearSolver() {
    SUNLinSolFree(solver);
    if (matrix) SUNMatDestroy(matrix);
  }
};

void step_with_arkode(Motion& motion, const std::string& method, N_Vector y, SUNContext context, Run* run) {
  const bool is_implicit = method == "sdirk";
  void* memory = is_implicit ? ARKStepCreate(nullptr, find_slope, 0.0, y, context)
                             : ARKStepCreate(find_slope, nullptr, 0.0, y, context);
  const LinearSolver linear(motion, y, context);
  require(ARKStepSetUserData(memory, &motion));
  require(ARKStepSStolerances(memory, motion.tolerance, motion.tolerance));
  if (is_implicit) {
    require(ARKStepSetTableNum(memory, ARKODE_KVAERNO_7_4_5, ARKODE_ERK_NONE));
    require(ARKStepSetLinearSolver(memory, linear.solver, linear.matrix));
  } else {
    require(ARKStepSetTableNum(memory, ARKODE_DIRK_NONE,
                               method == "erk8" ? ARKODE_FEHLBERG_13_7_8 : ARKODE_DORMAND_PRINCE_7_4_5));
  }
  require(ARKStepSetPostprocessStepFn(memory, project_state));
  require(ARKStepSetMaxNumSteps(memory, most_steps));
  require(ARKStepSetStopTime(memory, motion.problem.t_end));
  double t = 0.0;
  const double begin = processor_time();
  require(ARKStepEvolve(memory, motion.problem.t_end, y, &t, ARK_NORMAL));
  run->seconds = processor_time() - begin;
  require(ARKStepGetNumSteps(memory, &run->steps));
  if (is_implicit) require(ARKStepGetNumLinSolvSetups(memory, &run->factorizations));
  ARKStepFree(&memory);
}

void step_with_cvode(Motion& motion, const std::string& method, N_Vector y, SUNContext context, Run* run) {
  void* memory = CVodeCreate(method == "adams" ? CV_ADAMS : CV_BDF, context);
  const LinearSolver linear(motion, y, context);
  SUNNonlinearSolver iteration = nullptr;
  require(CVodeInit(memory, find_slope, 0.0, y));
  require(CVodeSetUserData(memory, &motion));
  require(CVodeSStolerances(memory, motion.tolerance, motion.tolerance));
  if (motion.is_stiff) {
    require(CVodeSetLinearSolver(memory, linear.solver, linear.matrix));
  } else {
    iteration = SUNNonlinSol_FixedPoint(y, 0, context);
    require(CVodeSetNonlinearSolver(memory, iteration));
  }
  if (method != "adams") require(CVodeSetProjFn(memory, find_correction));
  if (method == "bdf2") require(CVodeSetMaxOrd(memory, 2));
  require(CVodeSetMaxNumSteps(memory, most_steps));
  require(CVodeSetStopTime(memory, motion.problem.t_end));
  double t = 0.0;
  const double begin = processor_time();
  require(CVode(memory, motion.problem.t_end, y, &t, CV_NORMAL));
  run->seconds = processor_time() - begin;
  require(CVodeGetNumSteps(memory, &run->steps));
  if (motion.is_stiff) require(CVodeGetNumLinSolvSetups(memory, &run->factorizations));
  CVodeFree(&memory);
  if (iteration) SUNNonlinSolFree(iteration);
}

Run make_run(const Problem& problem, const std::string& method, double tolerance) {
  Motion motion(problem, method, tolerance);
  current = &motion;
  SUNContext context;
  require(SUNContext_Create(nullptr, &context));
  N_Vector y = N_VNew_Serial(2 * motion.size, context);
  motion.write(motion.start().data(), N_VGetArrayPointer(y));
  Run run;
  const auto step = method.starts_with("ida")                                  ? step_with_ida
                    : method.starts_with("erk") || method.starts_with("sdirk") ? step_with_arkode
                                                                               : step_with_cvode;
  step(motion, method, y, context, &run);
  if (!problem.is_car_axis && !motion.is_stiff) run.factorizations += motion.form.factorizations();
  run.places = motion.places(motion.read(N_VGetArrayPointer(y)));
  N_VDestroy(y);
  SUNContext_Free(&context);
  return run;
}

}  // namespace
}  // namespace rivals

int main(int count, char** words) {
  return rivals::drive(count, words, rivals::make_run);
}
