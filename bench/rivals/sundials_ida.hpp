#pragma once

#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include "sundials_motion.hpp"

namespace rivals {

constexpr double loose_tolerance = 1.0;  // of IDA's multipliers, N/m and 1/s

inline int find_residual(realtype, N_Vector y, N_Vector slope, N_Vector out, void* user) {
  static_cast<StabilisedForm*>(user)->residual(N_VGetArrayPointer(y), N_VGetArrayPointer(slope),
                                               N_VGetArrayPointer(out));
  return 0;
}

inline int find_residual_of_car(realtype t, N_Vector y, N_Vector slope, N_Vector out, void*) {
  CarAxis::residual(t, N_VGetArrayPointer(y), N_VGetArrayPointer(slope), N_VGetArrayPointer(out));
  return 0;
}

inline int find_newton_matrix(realtype, realtype a, N_Vector y, N_Vector, N_Vector, SUNMatrix out, void* user, N_Vector,
                              N_Vector, N_Vector) {
  const auto& matrix = static_cast<StabilisedForm*>(user)->newton_matrix(N_VGetArrayPointer(y), a);
  std::copy_n(matrix.outerIndexPtr(), matrix.outerSize() + 1, SUNSparseMatrix_IndexPointers(out));
  std::copy_n(matrix.innerIndexPtr(), matrix.nonZeros(), SUNSparseMatrix_IndexValues(out));
  std::copy_n(matrix.valuePtr(), matrix.nonZeros(), SUNSparseMatrix_Data(out));
  return 0;
}

/// Takes steps with IDA from lambda and v' of the normal form at the start, and mu = 0. The multipliers are left out of
/// the error test; with the tolerance of the others Newton's iteration would stall on them, since they change by 1/h of
/// the change of positions. Newton's matrix is written by hand and solved by KLU; that of the car axis is dense, by
/// differences.
inline void step_with_ida(Motion& motion, const std::string& method, N_Vector state, SUNContext context, Run* run) {
  const int n = motion.size;
  const bool is_car = motion.problem.is_car_axis;
  StabilisedForm form(motion.problem);
  const int unknowns = is_car ? CarAxis::unknowns : form.unknowns();
  N_Vector y = N_VNew_Serial(unknowns, context), slope = N_VClone(y), differential = N_VClone(y),
           tolerances = N_VClone(y);
  for (N_Vector vector : {y, slope, differential}) N_VConst(0.0, vector);
  N_VConst(loose_tolerance, tolerances);
  std::fill_n(N_VGetArrayPointer(tolerances), 2 * n, motion.tolerance);
  double *values = N_VGetArrayPointer(y), *ends = N_VGetArrayPointer(state), *rates = N_VGetArrayPointer(slope);
  std::copy_n(ends, 2 * n, values);
  std::copy_n(values + n, n, rates);
  motion.accelerations(0.0, values, values + n, rates + n);
  if (is_car) {
    std::copy_n(motion.axis.multipliers().data(), 2, values + 2 * n);
  } else {
    std::copy_n(motion.form.multipliers().data(), motion.problem.equations(), values + 2 * n);
  }
  std::fill_n(N_VGetArrayPointer(differential), 2 * n, 1.0);

  void* memory = IDACreate(context);
  SUNMatrix matrix =
      is_car ? SUNDenseMatrix(unknowns, unknowns, context)
             : SUNSparseMatrix(unknowns, unknowns, form.newton_matrix(values, 1.0).nonZeros(), CSC_MAT, context);
  SUNLinearSolver solver = is_car ? SUNLinSol_Dense(y, matrix, context) : SUNLinSol_KLU(y, matrix, context);
  require(IDAInit(memory, is_car ? find_residual_of_car : find_residual, 0.0, y, slope));
  require(IDASetUserData(memory, &form));
  require(IDASVtolerances(memory, motion.tolerance, tolerances));
  require(IDASetId(memory, differential));
  require(IDASetSuppressAlg(memory, SUNTRUE));
  require(IDASetLinearSolver(memory, solver, matrix));
  if (!is_car) require(IDASetJacFn(memory, find_newton_matrix));
  if (method == "ida2") require(IDASetMaxOrd(memory, 2));
  require(IDASetMaxNumSteps(memory, most_steps));
  require(IDASetStopTime(memory, motion.problem.t_end));
  double t = 0.0;
  const double begin = processor_time();
  const int flag = IDASolve(memory, motion.problem.t_end, &t, y, slope, IDA_NORMAL);
  if (flag < 0) throw std::runtime_error("IDA: flag " + std::to_string(flag) + " at " + std::to_string(t) + " s");
  run->seconds = processor_time() - begin;
  require(IDAGetNumSteps(memory, &run->steps));
  require(IDAGetNumLinSolvSetups(memory, &run->factorizations));
  std::copy_n(values, 2 * n, ends);
  IDAFree(&memory);
  SUNLinSolFree(solver);
  SUNMatDestroy(matrix);
  for (N_Vector vector : {y, slope, differential, tolerances}) N_VDestroy(vector);
}

}  // namespace rivals
