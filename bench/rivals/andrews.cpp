// Runs Andrews' squeezing mechanism to t = 0.03 s by tanor and SUNDIALS IDA, in turn.
//
//   rival_andrews [TOLERANCE] [ROUNDS]      1e-8, 15
//
// IDA has the bodies' angles, the stabilised form of index 2 and a hand-written Newton matrix of 26 unknowns: sparse
// with
// KLU, to which all are compared, and dense. tanor has points. Errors are those of the joints at the end, against
// tanor's dop853 at 1e-13; that run's own error is the distance to the published angles. Times are the processor's,
// medians of the rounds.

#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "andrews.hpp"
#include "rivals/andrews_form.hpp"

namespace {

using rivals::AndrewsForm;
using tanor::andrews::Angles;

double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void require(int flag) {
  if (flag < 0) throw std::runtime_error("IDA: flag " + std::to_string(flag));
}

struct Run {
  double seconds = 0.0;
  long steps = 0;
  std::vector<double> joints;  // [crank, f, g, h][x, y]
};

std::vector<double> joints_of(const Angles& q) {
  const tanor::andrews::Joints at(q);
  return {at.crank.x, at.crank.y, at.f.x, at.f.y, at.g.x, at.g.y, at.h.x, at.h.y};
}

// ---- IDA ----

/// The pattern of Newton's matrix by columns: the entries that are not 0 at some state.
class Pattern {
 public:
  static constexpr std::size_t size = AndrewsForm::unknowns;

  Pattern() {
    AndrewsForm form;
    std::array<double, size> y{}, slope{};
    for (std::size_t i = 0; i < size; ++i) y[i] = std::sin(1.0 + 2.3 * static_cast<double>(i)), slope[i] = 1.0 + y[i];
    std::array<std::array<double, size>, size> dense{};
    form.newton_matrix(y.data(), slope.data(), 0.7,
                       [&](std::size_t i, std::size_t j) -> double& { return dense[j][i]; });
    for (std::size_t j = 0; j < size; ++j) {
      for (std::size_t i = 0; i < size; ++i) {
        slots_[j][i] = dense[j][i] != 0.0 ? static_cast<sunindextype>(rows_.size()) : none;
        if (dense[j][i] != 0.0) rows_.push_back(static_cast<sunindextype>(i));
      }
      start_[j + 1] = static_cast<sunindextype>(rows_.size());
    }
  }

  sunindextype entries() const { return start_[size]; }
  void write_to(SUNMatrix out) const {
    std::copy(start_.begin(), start_.end(), SUNSparseMatrix_IndexPointers(out));
    std::copy(rows_.begin(), rows_.end(), SUNSparseMatrix_IndexValues(out));
  }
  double& entry(double* values, std::size_t i, std::size_t j) {
    return slots_[j][i] == none ? zero_ : values[slots_[j][i]];
  }

 private:
  static constexpr sunindextype none = -1;

  std::array<std::array<sunindextype, size>, size> slots_{};
  std::array<sunindextype, size + 1> start_{};
  std::vector<sunindextype> rows_;
  double zero_ = 0.0;  // what is written where nothing ever is
};

struct IdaForm : AndrewsForm {
  Pattern pattern;
};

int find_residual(realtype, N_Vector y, N_Vector slope, N_Vector out, void* user) {
  static_cast<IdaForm*>(user)->residual(N_VGetArrayPointer(y), N_VGetArrayPointer(slope), N_VGetArrayPointer(out));
  return 0;
}

int find_sparse_matrix(realtype, realtype s, N_Vector y, N_Vector slope, N_Vector, SUNMatrix out, void* user, N_Vector,
                       N_Vector, N_Vector) {
  auto* const form = static_cast<IdaForm*>(user);
  double* const values = SUNSparseMatrix_Data(out);
  std::fill_n(values, form->pattern.entries(), 0.0);
  form->pattern.write_to(out);
  form->newton_matrix(N_VGetArrayPointer(y), N_VGetArrayPointer(slope), s,
                      [&](std::size_t i, std::size_t j) -> double& { return form->pattern.entry(values, i, j); });
  return 0;
}

int find_newton_matrix(realtype, realtype s, N_Vector y, N_Vector slope, N_Vector, SUNMatrix out, void* user, N_Vector,
                       N_Vector, N_Vector) {
  SUNMatZero(out);
  static_cast<IdaForm*>(user)->newton_matrix(
      N_VGetArrayPointer(y), N_VGetArrayPointer(slope), s,
      [out](std::size_t i, std::size_t j) -> double& { return SM_ELEMENT_D(out, i, j); });
  return 0;
}

/// Finds v' and lambda of the start from [M G'; G 0] (v', lambda) = (f, 0), since all rests.
void start(AndrewsForm* form, double* y, double* slope) {
  constexpr std::size_t n = AndrewsForm::n, m = AndrewsForm::m;
  std::copy(tanor::andrews::start.begin(), tanor::andrews::start.end(), y);
  form->evaluate(y, y + n);
  Eigen::Matrix<double, 13, 13> matrix = Eigen::Matrix<double, 13, 13>::Zero();
  Eigen::Matrix<double, 13, 1> right = Eigen::Matrix<double, 13, 1>::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    right(i) = form->force[i];
    for (std::size_t j = 0; j < n; ++j) matrix(i, j) = form->mass[i][j];
    for (std::size_t j = 0; j < m; ++j) matrix(i, n + j) = matrix(n + j, i) = form->slope[j][i];
  }
  const Eigen::Matrix<double, 13, 1> found = matrix.fullPivLu().solve(right);
  for (std::size_t i = 0; i < n; ++i) slope[n + i] = found(i);
  for (std::size_t j = 0; j < m; ++j) y[2 * n + j] = found(n + j);
}

enum class Solver { Klu, Dense };

Run run_ida(double tolerance, Solver choice) {
  constexpr std::size_t n = AndrewsForm::n, unknowns = AndrewsForm::unknowns;
  constexpr double loose = 1.0;  // of multipliers, which are left out of the error test
  IdaForm form;
  SUNContext context = nullptr;
  require(SUNContext_Create(nullptr, &context));
  N_Vector y = N_VNew_Serial(unknowns, context), slope = N_VClone(y), differential = N_VClone(y),
           tolerances = N_VClone(y);
  for (N_Vector vector : {y, slope, differential}) N_VConst(0.0, vector);
  N_VConst(loose, tolerances);
  std::fill_n(N_VGetArrayPointer(tolerances), 2 * n, tolerance);
  std::fill_n(N_VGetArrayPointer(differential), 2 * n, 1.0);
  start(&form, N_VGetArrayPointer(y), N_VGetArrayPointer(slope));
  void* memory = IDACreate(context);
  const bool is_sparse = choice == Solver::Klu;
  SUNMatrix matrix = is_sparse ? SUNSparseMatrix(unknowns, unknowns, form.pattern.entries(), CSC_MAT, context)
                               : SUNDenseMatrix(unknowns, unknowns, context);
  if (is_sparse) form.pattern.write_to(matrix);
  SUNLinearSolver solver = is_sparse ? SUNLinSol_KLU(y, matrix, context) : SUNLinSol_Dense(y, matrix, context);
  require(IDAInit(memory, find_residual, 0.0, y, slope));
  require(IDASetUserData(memory, &form));
  require(IDASVtolerances(memory, tolerance, tolerances));
  require(IDASetId(memory, differential));
  require(IDASetSuppressAlg(memory, SUNTRUE));
  require(IDASetLinearSolver(memory, solver, matrix));
  require(IDASetJacFn(memory, is_sparse ? find_sparse_matrix : find_newton_matrix));
  require(IDASetMaxNumSteps(memory, 1000000));
  require(IDASetStopTime(memory, tanor::andrews::end_time));
  Run run;
  double t = 0.0;
  const double begin = processor_time();
  require(IDASolve(memory, tanor::andrews::end_time, &t, y, slope, IDA_NORMAL));
  run.seconds = processor_time() - begin;
  require(IDAGetNumSteps(memory, &run.steps));
  Angles q;
  std::copy_n(N_VGetArrayPointer(y), n, q.begin());
  run.joints = joints_of(q);
  IDAFree(&memory);
  SUNLinSolFree(solver);
  SUNMatDestroy(matrix);
  for (N_Vector vector : {y, slope, differential, tolerances}) N_VDestroy(vector);
  SUNContext_Free(&context);
  return run;
}

// ---- tanor ----

Run run_tanor(const tanor::System& system, const std::vector<tanor::Index>& joints, tanor::Method method,
              double tolerance) {
  tanor::Simulation simulation(system, {.method = method, .rtol = tolerance, .atol = tolerance * 0.01});
  Run run;
  const double begin = processor_time();
  if (const tanor::Outcome outcome = simulation.advance_to(tanor::andrews::end_time); !outcome.ok())
    throw std::runtime_error("tanor: " + outcome.what);
  run.seconds = processor_time() - begin;
  run.steps = static_cast<long>(simulation.report().steps);
  for (const tanor::Index point : joints) {
    const double* const r = simulation.positions().data() + 3 * point;
    run.joints.insert(run.joints.end(), {r[0], r[1]});
  }
  return run;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst;
}

}  // namespace

int main(int argc, char** argv) {
  const double tolerance = argc > 1 ? std::atof(argv[1]) : 1e-8;
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 15;
  const tanor::System bodies = tanor::andrews::make_system(), joints = tanor::andrews::make_joint_system();
  const std::vector<tanor::Index> of_bodies{0, 2, 6, 10}, of_joints{0, 1, 2, 3};
  const std::vector<double> exact = run_tanor(bodies, of_bodies, tanor::Method::Dop853, 1e-13).joints;
  std::printf("dop853 at 1e-13 against the published angles: %.1e m\n",
              distance(exact, joints_of(tanor::andrews::end)));

  struct Row {
    const char* name;
    std::function<Run()> run;
    std::vector<double> seconds{};
    Run last{};
  };
  using tanor::Method;
  std::vector<Row> rows{{"IDA, KLU", [&] { return run_ida(tolerance, Solver::Klu); }},
                        {"taylor, 14 points", [&] { return run_tanor(bodies, of_bodies, Method::Taylor, tolerance); }},
                        {"radau5, 14 points", [&] { return run_tanor(bodies, of_bodies, Method::Radau5, tolerance); }},
                        {"taylor, 11 points", [&] { return run_tanor(joints, of_joints, Method::Taylor, tolerance); }},
                        {"radau5, 11 points", [&] { return run_tanor(joints, of_joints, Method::Radau5, tolerance); }},
                        {"dop853, 11 points", [&] { return run_tanor(joints, of_joints, Method::Dop853, tolerance); }},
                        {"IDA, dense LU", [&] { return run_ida(tolerance, Solver::Dense); }}};
  for (int round = 0; round < rounds; ++round) {
    for (Row& row : rows) {
      row.last = row.run();
      row.seconds.push_back(row.last.seconds);
    }
  }
  std::printf("%-20s %10s %8s %12s %14s\n", "tolerance", "ms", "steps", "error, m", "IDA, KLU/this");
  const auto median_of = [&](Row& row) {
    std::nth_element(row.seconds.begin(), row.seconds.begin() + rounds / 2, row.seconds.end());
    return row.seconds[static_cast<std::size_t>(rounds / 2)];
  };
  const double of_ida = median_of(rows[0]);
  for (Row& row : rows) {
    const double median = median_of(row);
    std::printf("%-20s %10.3f %8ld %12.1e %14.2f\n", row.name, 1e3 * median, row.last.steps,
                distance(row.last.joints, exact), of_ida / median);
  }
}
