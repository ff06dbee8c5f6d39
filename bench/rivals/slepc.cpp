// Finds the lowest modes of a net of rods that hangs by two adjacent corners, by tanor and by SLEPc in turn:
//   OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 rival_slepc [--side K] [--count N] [--rounds R] [--unequal 1]
//   default: 100 x 100 points 0.1 m apart, 0.1 kg each, corners 9.9 m apart; 20 modes, 5 rounds
//   --unequal 1: masses of 0.05 to 0.15 kg, so that no two modes are equal
// Both get W, K and M of the same equilibrium, and find the lowest omega^2 to the same tolerance, with analysis and
// factorization. SLEPc does so twice: next to the shift at which ours begins, and next to the one where ours ends,
// which
// it gets for nothing. SLEPc: Krylov-Schur on the pencil ([W K; K' 0], [M 0; 0 0]), shift-invert by MUMPS (L D L' of
// the
// symmetric matrix). Ours also proves that no mode is missing. The program prints medians of processor time, the
// largest
// relative difference of omega^2, and the part of SLEPc's shapes outside of the space that ours span, in the norm of M.
// With equal masses each column of the net swings by itself, so that every omega^2 is that of a column which hangs
// alone:
// each of SLEPc's is compared with the nearest of these, which tanor's dense solver finds.

#include <slepceps.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>

#include "../timing.hpp"
#include "scenes.hpp"
#include "statics/given_equilibrium.hpp"
#include "statics/mode_finder.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;

constexpr double tolerance = 1e-8;

/// A symmetric matrix with all its entries, by rows.
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

/// Writes the pencil ([W K; K' 0], [M 0; 0 0]).
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
  std::vector<double> omega2;  // increasing
  Eigen::MatrixXd shapes;      // [3 moving points x modes], x'Mx = 1, in SLEPc's order
  double seconds = 0.0;        // of the processor
  int steps = 0;
};

Answer solve_by_slepc(Mat left, Mat right, const Eigen::VectorXd& mass, double shift, int count) {
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
  EPSGetIterationNumber(eps, &answer.steps);
  answer.seconds = processor_seconds() - begin;
  converged = std::min<PetscInt>(converged, count);
  answer.shapes.resize(mass.size(), converged);
  Vec vector;
  MatCreateVecs(left, &vector, nullptr);
  for (PetscInt k = 0; k < converged; ++k) {
    PetscScalar value;
    EPSGetEigenpair(eps, k, &value, nullptr, vector, nullptr);
    answer.omega2.push_back(value);
    const PetscScalar* entries = nullptr;
    VecGetArrayRead(vector, &entries);
    const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(entries, mass.size());
    VecRestoreArrayRead(vector, &entries);
    answer.shapes.col(k) = x / std::sqrt(x.dot(mass.cwiseProduct(x)));
  }
  VecDestroy(&vector);
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

/// Returns all omega^2 of one column of the net by itself.
std::vector<double> modes_of_a_column(int side) {
  System chain;
  Rods rods{.name = "rods"};
  for (Index i = 0; i < side; ++i) {
    chain.positions.insert(chain.positions.end(), {0.0, 0.0, -0.1 * i});
    chain.masses.push_back(0.1);
    if (i > 0) rods.pairs.push_back({i - 1, i});
  }
  chain.supports = {Support{"", {0}}};
  chain.constraints = {rods};
  chain.add_gravity({0.0, 0.0, -9.81});
  std::vector<double> squares = modes(chain, chain.positions, {.count = ModesOptions::all}).omega;
  for (double& omega : squares) omega *= omega;
  return squares;
}

/// Returns the largest relative distance from one of theirs to the nearest of ours.
double distance_to_nearest(const std::vector<double>& ours, const std::vector<double>& theirs) {
  double worst = 0.0;
  for (const double value : theirs) {
    double nearest = HUGE_VAL;
    for (const double own : ours) nearest = std::min(nearest, std::abs(own / value - 1.0));
    worst = std::max(worst, nearest);
  }
  return worst;
}

/// Returns the largest |x - X X'Mx| of their shapes x and ours X, which are M-orthonormal.
double largest_part_outside(const Eigen::MatrixXd& ours, const Eigen::MatrixXd& theirs, const Eigen::VectorXd& mass) {
  const Eigen::MatrixXd outside = theirs - ours * (ours.transpose() * mass.asDiagonal() * theirs);
  return std::sqrt((outside.array().square().colwise() * mass.array()).colwise().sum().maxCoeff());
}

struct Options {
  int side = 100, count = 20, rounds = 5, is_unequal = 0;
};

int measure(const Options& options) {
  const int count = options.count;
  // The net rests in the same shape whatever the masses: each column hangs straight, and the rows carry nothing.
  const System system = scenes::make_hung_net(options.side, options.is_unequal != 0);
  const double begin = processor_seconds();
  const EquilibriumResult rest = find_equilibrium(scenes::make_hung_net(options.side), {.solver = {.threads = 1}});
  if (!rest.outcome.ok()) return std::printf("%s\n", rest.outcome.what.c_str()), 1;
  std::printf("equilibrium: %d iterations, %.2f s, residual %.1e of the largest force\n", rest.search.iterations,
              processor_seconds() - begin, rest.residual_force / rest.largest_force);

  const auto state = GivenEquilibrium::stand_at(system, {rest.positions, {}, 1e-6}, {.solver = {.threads = 1}});
  const EquilibriumEquations& equations = state->equations();
  Matrix left(equations.size() + equations.num_rows()), right(equations.size() + equations.num_rows());
  write_pencil(equations, &left, &right);
  std::printf("%zu unknowns, %zu rows, tolerance %.0e\n", equations.size(), equations.num_rows(), tolerance);

  Eigen::VectorXd mass(static_cast<Eigen::Index>(equations.size()));
  for (std::size_t i = 0; i < equations.size(); ++i) mass[static_cast<Eigen::Index>(i)] = equations.model().mass[i / 3];
  const std::vector<double> of_a_column = modes_of_a_column(options.side);
  std::vector<double> ours, theirs[2], ratios[2];
  for (int round = 0; round < options.rounds; ++round) {
    const double start = processor_seconds();
    KktSolver kkt(equations);
    ModeFinder finder(equations, kkt, equations.size() - equations.num_rows());
    const ModeSet found = finder.find_lowest(static_cast<std::size_t>(count), tolerance);
    ours.push_back(processor_seconds() - start);
    if (!found.outcome.ok()) return std::printf("%s\n", found.outcome.what.c_str()), 1;
    std::printf("tanor %.3f s (residual %.1e)", ours.back(), found.residual);
    for (int k = 0; k < 2; ++k) {
      const double shift = k == 0 ? ModeFinder::least_shift * finder.scale() : finder.shift();
      const Answer other = solve_by_slepc(left.get(), right.get(), mass, shift, count);
      theirs[k].push_back(other.seconds);
      ratios[k].push_back(other.seconds / ours.back());
      std::printf("\n  SLEPc next to %.4g: %.3f s, %d restarts, %zu modes", -shift, other.seconds, other.steps,
                  other.omega2.size());
      if (options.is_unequal != 0)
        std::printf(", difference %.1e, outside %.1e", largest_difference(found.omega2, other.omega2),
                    largest_part_outside(found.shapes, other.shapes, mass));
      else
        std::printf(", to the nearest of a column's %.1e", distance_to_nearest(of_a_column, other.omega2));
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
  Options options;
  for (int k = 1; k + 1 < argc; k += 2) {
    const std::string option = argv[k];
    int& value = option == "--side"      ? options.side
                 : option == "--count"   ? options.count
                 : option == "--unequal" ? options.is_unequal
                                         : options.rounds;
    value = std::atoi(argv[k + 1]);
  }
  SlepcInitializeNoArguments();
  const int code = measure(options);
  SlepcFinalize();
  return code;
}
