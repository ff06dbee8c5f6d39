/// SUNDIALS on r'' = w(r, v), with the normal form and its projections written by hand.
///
///     rival_sundials PROBLEM SIZE METHOD TOLERANCE FILE
///
/// METHOD: erk5, erk8 (ARKODE, Dormand & Prince 5(4), Fehlberg 8(7); projected after each step), adams (CVODE, which
/// offers no projection with it), bdf (CVODE with projection), ida (IDA on the stabilised form of index 2).

#include <arkode/arkode_arkstep.h>
#include <cvode/cvode.h>
#include <cvode/cvode_proj.h>
#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "normal_form.hpp"
#include "stabilised_form.hpp"

namespace rivals {
namespace {

/// What the callbacks need.
struct Motion {
  const Problem& problem;
  NormalForm form;
  double tolerance;
};

constexpr double projection_share = 0.01;  // of the tolerance
constexpr double loose_tolerance = 1.0;    // of IDA's multipliers, N/m and 1/s
constexpr long most_steps = 10'000'000;

void require(int flag) {
  if (flag < 0) throw std::runtime_error("SUNDIALS: flag " + std::to_string(flag));
}

/// y = (r, v); y' = (v, w)
int find_slope(realtype, N_Vector y, N_Vector slope, void* user) {
  auto& motion = *static_cast<Motion*>(user);
  const int n = 3 * motion.problem.size();
  const double* state = N_VGetArrayPointer(y);
  double* out = N_VGetArrayPointer(slope);
  std::copy_n(state + n, n, out);
  motion.form.accelerations(state, state + n, out + n);
  return 0;
}

Motion* current = nullptr;  // ARKODE's post-processing gets another pointer in some versions

int project_state(realtype, N_Vector y, void*) {
  double* state = N_VGetArrayPointer(y);
  current->form.project(state, state + 3 * current->problem.size(), projection_share * current->tolerance);
  return 0;
}

/// CVODE wants the correction, and the error without its normal part.
int find_correction(realtype, N_Vector y, N_Vector correction, realtype, N_Vector error, void* user) {
  auto& motion = *static_cast<Motion*>(user);
  const int n = 3 * motion.problem.size();
  const double* state = N_VGetArrayPointer(y);
  double* change = N_VGetArrayPointer(correction);
  std::copy_n(state, 2 * n, change);
  motion.form.project(change, change + n, projection_share * motion.tolerance);
  for (int i = 0; i < 2 * n; ++i) change[i] -= state[i];
  if (error) {
    motion.form.remove_normal_part(N_VGetArrayPointer(error));
    motion.form.remove_normal_part(N_VGetArrayPointer(error) + n);
  }
  return 0;
}

void step_with_arkode(const Motion& motion, const std::string& method, N_Vector y, SUNContext context, Run* run) {
  void* memory = ARKStepCreate(find_slope, nullptr, 0.0, y, context);
  require(ARKStepSetUserData(memory, current));
  require(ARKStepSStolerances(memory, motion.tolerance, motion.tolerance));
  require(ARKStepSetTableNum(memory, ARKODE_DIRK_NONE,
                             method == "erk8" ? ARKODE_FEHLBERG_13_7_8 : ARKODE_DORMAND_PRINCE_7_4_5));
  require(ARKStepSetPostprocessStepFn(memory, project_state));
  require(ARKStepSetMaxNumSteps(memory, most_steps));
  require(ARKStepSetStopTime(memory, motion.problem.t_end));
  double t = 0.0;
  const double begin = processor_time();
  require(ARKStepEvolve(memory, motion.problem.t_end, y, &t, ARK_NORMAL));
  run->seconds = processor_time() - begin;
  require(ARKStepGetNumSteps(memory, &run->steps));
  ARKStepFree(&memory);
}

void step_with_cvode(const Motion& motion, const std::string& method, N_Vector y, SUNContext context, Run* run) {
  void* memory = CVodeCreate(method == "adams" ? CV_ADAMS : CV_BDF, context);
  SUNNonlinearSolver iteration = SUNNonlinSol_FixedPoint(y, 0, context);
  require(CVodeInit(memory, find_slope, 0.0, y));
  require(CVodeSetUserData(memory, current));
  require(CVodeSStolerances(memory, motion.tolerance, motion.tolerance));
  require(CVodeSetNonlinearSolver(memory, iteration));
  if (method == "bdf") require(CVodeSetProjFn(memory, find_correction));
  require(CVodeSetMaxNumSteps(memory, most_steps));
  require(CVodeSetStopTime(memory, motion.problem.t_end));
  double t = 0.0;
  const double begin = processor_time();
  require(CVode(memory, motion.problem.t_end, y, &t, CV_NORMAL));
  run->seconds = processor_time() - begin;
  require(CVodeGetNumSteps(memory, &run->steps));
  CVodeFree(&memory);
  SUNNonlinSolFree(iteration);
}

int find_residual(realtype, N_Vector y, N_Vector slope, N_Vector out, void* user) {
  static_cast<StabilisedForm*>(user)->residual(N_VGetArrayPointer(y), N_VGetArrayPointer(slope),
                                               N_VGetArrayPointer(out));
  return 0;
}

int find_newton_matrix(realtype, realtype a, N_Vector y, N_Vector, N_Vector, SUNMatrix out, void* user, N_Vector,
                       N_Vector, N_Vector) {
  const auto& matrix = static_cast<StabilisedForm*>(user)->newton_matrix(N_VGetArrayPointer(y), a);
  std::copy_n(matrix.outerIndexPtr(), matrix.outerSize() + 1, SUNSparseMatrix_IndexPointers(out));
  std::copy_n(matrix.innerIndexPtr(), matrix.nonZeros(), SUNSparseMatrix_IndexValues(out));
  std::copy_n(matrix.valuePtr(), matrix.nonZeros(), SUNSparseMatrix_Data(out));
  return 0;
}

/// lambda and v' at the start from the normal form; mu = 0. The multipliers are left out of the error test, and with
/// the tolerance of the others Newton's iteration would stall on them: they change by 1/h of what places do.
void step_with_ida(const Motion& motion, const std::string&, N_Vector state, SUNContext context, Run* run) {
  const int n = 3 * motion.problem.size();
  StabilisedForm form(motion.problem);
  N_Vector y = N_VNew_Serial(form.unknowns(), context), slope = N_VClone(y), differential = N_VClone(y),
           tolerances = N_VClone(y);
  for (N_Vector vector : {y, slope, differential}) N_VConst(0.0, vector);
  N_VConst(loose_tolerance, tolerances);
  std::fill_n(N_VGetArrayPointer(tolerances), 2 * n, motion.tolerance);
  double *values = N_VGetArrayPointer(y), *places = N_VGetArrayPointer(state);
  std::copy_n(places, 2 * n, values);
  current->form.accelerations(values, values + n, N_VGetArrayPointer(slope) + n);
  const Eigen::VectorXd& lambda = motion.form.multipliers();
  std::copy_n(lambda.data(), lambda.size(), values + 2 * n);
  std::fill_n(N_VGetArrayPointer(differential), 2 * n, 1.0);

  void* memory = IDACreate(context);
  SUNMatrix matrix =
      SUNSparseMatrix(form.unknowns(), form.unknowns(), form.newton_matrix(values, 1.0).nonZeros(), CSC_MAT, context);
  SUNLinearSolver solver = SUNLinSol_KLU(y, matrix, context);
  require(IDAInit(memory, find_residual, 0.0, y, slope));
  require(IDASetUserData(memory, &form));
  require(IDASVtolerances(memory, motion.tolerance, tolerances));
  require(IDASetId(memory, differential));
  require(IDASetSuppressAlg(memory, SUNTRUE));
  require(IDASetLinearSolver(memory, solver, matrix));
  require(IDASetJacFn(memory, find_newton_matrix));
  require(IDASetMaxNumSteps(memory, most_steps));
  require(IDASetStopTime(memory, motion.problem.t_end));
  double t = 0.0;
  const double begin = processor_time();
  const int flag = IDASolve(memory, motion.problem.t_end, &t, y, slope, IDA_NORMAL);
  if (flag < 0) throw std::runtime_error("IDA: flag " + std::to_string(flag) + " at " + std::to_string(t) + " s");
  run->seconds = processor_time() - begin;
  require(IDAGetNumSteps(memory, &run->steps));
  require(IDAGetNumLinSolvSetups(memory, &run->factorizations));
  std::copy_n(values, 2 * n, places);
  IDAFree(&memory);
  SUNLinSolFree(solver);
  SUNMatDestroy(matrix);
  for (N_Vector vector : {y, slope, differential, tolerances}) N_VDestroy(vector);
}

Run make_run(const Problem& problem, const std::string& method, double tolerance) {
  Motion motion{problem, NormalForm(problem), tolerance};
  current = &motion;
  SUNContext context;
  require(SUNContext_Create(nullptr, &context));
  const int n = 3 * problem.size();
  N_Vector y = N_VNew_Serial(2 * n, context);
  N_VConst(0.0, y);
  std::copy_n(problem.places.data(), n, N_VGetArrayPointer(y));
  Run run;
  const auto step = method == "ida" ? step_with_ida : method.starts_with("erk") ? step_with_arkode : step_with_cvode;
  step(motion, method, y, context, &run);
  run.factorizations += motion.form.factorizations();
  run.places.assign(N_VGetArrayPointer(y), N_VGetArrayPointer(y) + n);
  N_VDestroy(y);
  SUNContext_Free(&context);
  return run;
}

}  // namespace
}  // namespace rivals

int main(int count, char** words) {
  return rivals::drive(count, words, rivals::make_run);
}
