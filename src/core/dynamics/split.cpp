#include "dynamics/split.hpp"

#include <algorithm>

#include "base/stopwatch.hpp"
#include "base/text.hpp"
#include "schur/refinement.hpp"

namespace tanor::detail {

namespace {

constexpr double suspicion = 1e-11;  // reciprocal condition below which a QR decides which rows depend
constexpr int passes = 3;            // of refinement, the first solve included

std::vector<double> unit_masses(const Model& model) {
  std::vector<double> result(model.num_points(), 0.0);
  std::fill_n(result.begin(), model.num_moving(), 1.0);
  return result;
}

}  // namespace

bool has_one_mass(const Model& model) {
  const auto end = model.mass.begin() + static_cast<std::ptrdiff_t>(model.num_moving());
  return model.num_moving() > 0 && std::all_of(model.mass.begin(), end, [&](double m) { return m == model.mass[0]; });
}

// ---- N ----

NormalSpace::NormalSpace(Workspace& work, Linearization* one_mass)
    : work_(work),
      model_(work.model()),
      one_mass_(one_mass),
      unit_(unit_masses(model_)),
      dependences_(work, unit_),
      c_(model_.num_rows()),
      rows_(model_.num_rows()),
      points_(3 * model_.num_points(), 0.0) {
  if (one_mass_ != nullptr || model_.num_rows() == 0) return;
  solver_ = std::make_unique<GramSolver>(model_.incidences, unit_, model_.numbering, Ordering::Auto,
                                         work.constraints.squared_gradient_norms(), model_.places());
  solver_->allow_zero_rows(model_.numbering);
}

Outcome NormalSpace::factorize(double t, const double* r, const double* blocks) {
  blocks_ = blocks;
  if (!solver_) return {};
  const Stopwatch watch(&work_.times.factor);
  ++work_.counters.split_factorizations;
  solver_->assemble(model_.parallel, blocks);
  GramSolver::Quality quality = solver_->factorize(model_.parallel);
  if (!quality.positive_definite || quality.reciprocal_condition <= suspicion) {
    for (const Dependences::Rows& rows : solver_->weak_parts(suspicion)) {
      (void)dependences_.decide(blocks, rows, work_.rank_tolerances(r));
    }
    solver_->set_active(dependences_.rows_for_gram());
    solver_->assemble(model_.parallel, blocks);
    quality = solver_->factorize(model_.parallel);
  }
  if (quality.positive_definite && quality.reciprocal_condition > GramSolver::singular_below) return {};
  return {Status::Singular, "the gradients of the constraints depend on one another at t = " + text(t) + ": " +
                                work_.name_row(quality.weakest_row) + " follows from others, or its gradient vanishes"};
}

void NormalSpace::find_least(const double* c, double* x, double* mu) {
  std::fill(x, x + 3 * model_.num_points(), 0.0);
  if (model_.num_rows() == 0) return;
  std::transform(c, c + rows_.size(), c_.begin(), [](double a) { return -a; });
  if (one_mass_ != nullptr) {
    // With one mass M^-1 K S^-1 c = K Gamma^-1 c and Gamma^-1 c = S^-1 c/m.
    one_mass_->solve_refined(c_.data(), mu, x);
    for (std::size_t a = 0; a < rows_.size(); ++a) mu[a] /= model_.mass[0];
    return;
  }
  std::fill(mu, mu + rows_.size(), 0.0);
  rows_ = c_;
  // rho = K'x - c, mu -= Gamma^-1 rho, x -= K Gamma^-1 rho
  refine_solution(
      passes, [&] { work_.constraints.apply_transposed(model_.parallel, blocks_, x, c_.data(), rows_.data()); },
      [&](int) {
        solver_->solve_negative(model_.parallel, rows_.data(), rows_.data());
        for (std::size_t a = 0; a < rows_.size(); ++a) mu[a] += rows_[a];
        model_.gather.add_scaled(model_.parallel, blocks_, rows_.data(), unit_.data(), model_.num_moving(), x);
      });
  if (dependences_.is_found()) dependences_.minimize_norm(mu);
}

void NormalSpace::project(const double* u, double* u_N, double* mu) {
  // Computes K'u of the moving points.
  std::copy(u, u + 3 * model_.num_moving(), points_.begin());
  std::vector<double> c(rows_.size());
  if (!c.empty()) {
    work_.constraints.apply_transposed(model_.parallel, blocks_, points_.data(), nullptr, c.data());
  }
  find_least(c.data(), u_N, mu);
}

// ---- T ----

TangentSpace::TangentSpace(Workspace& work)
    : work_(work),
      model_(work.model()),
      solver_(work.coordinates.list_products(unit_masses(model_)),
              {work.coordinates.island_start(), work.coordinates.num_coordinates()}, Ordering::Auto),
      columns_(work.coordinates.num_coordinates()),
      points_(3 * model_.num_points(), 0.0),
      rest_(3 * model_.num_points(), 0.0) {}

Outcome TangentSpace::factorize(double t, const double* blocks) {
  blocks_ = blocks;
  const Stopwatch watch(&work_.times.factor);
  ++work_.counters.split_factorizations;
  solver_.assemble(model_.parallel, blocks);
  const GramSolver::Quality quality = solver_.factorize(model_.parallel);
  if (quality.positive_definite && quality.reciprocal_condition > GramSolver::singular_below) return {};
  return {Status::Singular, "G = A'A is singular at t = " + text(t) + ": coordinate " + text(quality.weakest_row) +
                                " moves no point, or others move the points the same way"};
}

void TangentSpace::project(const double* u, double* u_T, double* x) {
  const std::size_t moving = 3 * model_.num_moving();
  if (x != nullptr) std::fill(x, x + columns_.size(), 0.0);
  std::fill(u_T, u_T + 3 * model_.num_points(), 0.0);
  std::copy(u, u + moving, rest_.begin());
  // rest = u - u_T; u_T += A G^-1 A'rest
  const auto measure = [&] {
    work_.coordinates.apply_transposed(model_.parallel, blocks_, rest_.data(), columns_.data());
  };
  measure();
  refine_solution(passes, measure, [&](int) {
    solver_.solve_negative(model_.parallel, columns_.data(), columns_.data());
    work_.coordinates.apply(model_.parallel, blocks_, columns_.data(), points_.data());
    for (std::size_t j = 0; x != nullptr && j < columns_.size(); ++j) x[j] -= columns_[j];
    for (std::size_t i = 0; i < moving; ++i) {
      u_T[i] -= points_[i];
      rest_[i] += points_[i];
    }
  });
}

}  // namespace tanor::detail
