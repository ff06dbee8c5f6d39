// The lowest modes of a net of rods that hangs by two adjacent corners, by tanor and by SLEPc in turn:
//   OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 rival_slepc [--side K] [--count N] [--rounds R]
//   default: 100 x 100 points 0.1 m apart, 0.1 kg each, corners 9.9 m apart; 20 modes, 5 rounds
// Both get W, K and M of the same equilibrium, and find the lowest omega^2 to the same tolerance, with analysis and
// factorization. SLEPc does so twice: next to the shift at which ours begins, and next to the one where ours ends,
// which it gets for nothing. SLEPc: Krylov-Schur on the pencil ([W K; K' 0], [M 0; 0 0]), shift-invert by MUMPS (L D L'
// of the symmetric matrix). Ours proves besides that no mode is missing. Prints medians of processor time, and the
// largest relative difference of omega^2.

#include <slepceps.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <tanor/equilibrium.hpp>

#include "../hung_net.hpp"
#include "../timing.hpp"
#include "statics/given_equilibrium.hpp"
#include "statics/mode_finder.hpp"

namespace {

using namespace tanor;

constexpr double tolerance = 1e-8;

/// One symmetric matrix with all its entries, by rows.
class Matrix {
 public:
  explicit Matrix(std::size_t size) : rows_(size) {}
  Matrix(const Matrix&) = delete;
  Matrix& operator=(const Matrix&) = delete;
  ~Matrix() { MatDestroy(&matrix_); }

  void add(std::size_t i, std::size_t j, double value) { rows_[i].push_back({static_cast<PetscInt>(j), value}); }
  Mat get() {
    if (matrix_ != nullptr) return matrix_;
    const auto n = static_cast<PetscInt>(rows_.size());
    std::vector<PetscInt> counts;
    for (const auto& row : rows_) counts.push_back(static_cast<PetscInt>(std::max<std::size_t>(row.size(), 1)));
    MatCreateSeqAIJ(PETSC_COMM_SELF, n, n, 0, counts.data(), &matrix_);
    for (PetscInt i = 0; i < n; ++i) {
      for (const auto& [j, value] : rows_[static_cast<std::size_t>(i)]) MatSetValue(matrix_, i, j, value, ADD_VALUES);
    }
    MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY);
    MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY);
    MatSetOption(matrix_, MAT_SYMMETRIC, PETSC_TRUE);
    return matrix_;
  }

 private:
  std::vector<std::vector<std::pair<PetscInt, double>>> rows_;
  Mat matrix_ = nullptr;
};

/// ([W K; K' 0], [M 0; 0 0]).
void write_pencil(const EquilibriumEquations& equations, Matrix* left, Matrix* right) {
  const StiffnessMatrix& W = equations.stiffness();
  const Model& model = equations.model();
  for (std::size_t i = 0; i < W.num_points(); ++i) {
    for (auto k = static_cast<std::size_t>(W.start()[i]); k < static_cast<std::size_t>(W.start()[i + 1]); ++k) {
      for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t b = 0; b < 3; ++b)
          left->add(3 * i + a, 3 * static_cast<std::size_t>(W.columns()[k]) + b, W.blocks()[k].entries[3 * a + b]);
      }
    }
    for (std::size_t a = 0; a < 3; ++a) right->add(3 * i + a, 3 * i + a, model.mass[i]);
  }
  for (const Incidence& incidence : model.incidences) {
    const auto point = static_cast<std::size_t>(incidence.point), row = static_cast<std::size_t>(incidence.row);
    if (point >= W.num_points() || row >= equations.num_rows()) continue;
    for (std::size_t a = 0; a < 3; ++a) {
      const double value = incidence.sign * equations.gradients()[3 * static_cast<std::size_t>(incidence.block) + a];
      left->add(3 * point + a, equations.size() + row, value);
      left->add(equations.size() + row, 3 * point + a, value);
    }
  }
}

struct Answer {
  std::vector<double> omega2;
  double seconds = 0.0;  // of the processor
  int steps = 0;
};

Answer solve_by_slepc(Mat left, Mat right, double shift, int count) {
  const double begin = processor_seconds();
  EPS eps;
  EPSCreate(PETSC_COMM_SELF, &eps);
  EPSSetOperators(eps, left, right);
  EPSSetProblemType(eps, EPS_GHEP);
  EPSSetType(eps, EPSKRYLOVSCHUR);
  EPSSetDimensions(eps, count, PETSC_DEFAULT, PETSC_DEFAULT);
  EPSSetTolerances(eps, tolerance, 1000);
  EPSSetTarget(eps, -shift);
  EPSSetWhichEigenpairs(eps, EPS_TARGET_MAGNITUDE);
  ST st;
  KSP ksp;
  PC pc;
  EPSGetST(eps, &st);
  STSetType(st, STSINVERT);
  STGetKSP(st, &ksp);
  KSPSetType(ksp, KSPPREONLY);
  KSPGetPC(ksp, &pc);
  PCSetType(pc, PCCHOLESKY);
  PCFactorSetMatSolverType(pc, MATSOLVERMUMPS);
  PetscOptionsSetValue(nullptr, "-st_mat_mumps_icntl_14", "200");  // % of memory beyond what MUMPS predicts
  EPSSetFromOptions(eps);
  EPSSolve(eps);

  Answer answer;
  PetscInt converged = 0;
  EPSGetConverged(eps, &converged);
  for (PetscInt k = 0; k < std::min<PetscInt>(converged, count); ++k) {
    PetscScalar value;
    EPSGetEigenvalue(eps, k, &value, nullptr);
    answer.omega2.push_back(value);
  }
  EPSGetIterationNumber(eps, &answer.steps);
  answer.seconds = processor_seconds() - begin;
  EPSDestroy(&eps);
  std::ranges::sort(answer.omega2);
  return answer;
}

double largest_difference(const Eigen::VectorXd& ours, const std::vector<double>& theirs) {
  double worst = 0.0;
  for (std::size_t k = 0; k < theirs.size(); ++k)
    worst = std::max(worst, std::abs(ours[static_cast<Eigen::Index>(k)] / theirs[k] - 1.0));
  return worst;
}

int measure(int side, int count, int rounds) {
  System system = make_hung_net(side);
  const double begin = processor_seconds();
  const EquilibriumResult rest = find_equilibrium(system, {.solver = {.threads = 1}});
  if (!rest.outcome.ok()) return std::printf("%s\n", rest.outcome.what.c_str()), 1;
  std::printf("equilibrium: %d iterations, %.2f s, residual %.1e of the largest force\n", rest.iterations,
              processor_seconds() - begin, rest.residual_force / rest.largest_force);

  const auto state =
      GivenEquilibrium::stand_at(system, {rest.positions, rest.multipliers, 1e-6}, {.solver = {.threads = 1}});
  const EquilibriumEquations& equations = state->equations();
  Matrix left(equations.size() + equations.num_rows()), right(equations.size() + equations.num_rows());
  write_pencil(equations, &left, &right);
  std::printf("%zu unknowns, %zu rows, tolerance %.0e\n", equations.size(), equations.num_rows(), tolerance);

  std::vector<double> ours, theirs[2], ratios[2];
  for (int round = 0; round < rounds; ++round) {
    const double start = processor_seconds();
    KktSolver kkt(equations);
    ModeFinder finder(equations, kkt, equations.size() - equations.num_rows());
    const ModeSet found = finder.find_lowest(static_cast<std::size_t>(count), tolerance);
    ours.push_back(processor_seconds() - start);
    if (!found.outcome.ok()) return std::printf("%s\n", found.outcome.what.c_str()), 1;
    std::printf("tanor %.3f s (%zu solves, residual %.1e)", ours.back(), found.solves, found.residual);
    for (int k = 0; k < 2; ++k) {
      const double shift = k == 0 ? ModeFinder::least_shift * finder.scale() : finder.shift();
      const Answer other = solve_by_slepc(left.get(), right.get(), shift, count);
      theirs[k].push_back(other.seconds);
      ratios[k].push_back(other.seconds / ours.back());
      std::printf("  SLEPc next to %.4g: %.3f s (%d restarts, %zu modes, difference %.1e)", -shift, other.seconds,
                  other.steps, other.omega2.size(), largest_difference(found.omega2, other.omega2));
    }
    std::printf("\n");
    if (round == 0)
      std::printf("omega from %.6f to %.6f rad/s\n", std::sqrt(found.omega2[0]), std::sqrt(found.omega2[count - 1]));
  }
  for (int k = 0; k < 2; ++k)
    std::printf("medians: tanor %.3f s, SLEPc %s %.3f s, SLEPc/tanor %.2f\n", median(ours),
                k == 0 ? "next to our first shift" : "next to our last shift", median(theirs[k]), median(ratios[k]));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  int side = 100, count = 20, rounds = 5;
  for (int k = 1; k + 1 < argc; k += 2) {
    const std::string option = argv[k];
    (option == "--side" ? side : option == "--count" ? count : rounds) = std::atoi(argv[k + 1]);
  }
  SlepcInitializeNoArguments();
  const int code = measure(side, count, rounds);
  SlepcFinalize();
  return code;
}
