#include "statics/unsymmetric_newton.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/text.hpp"

namespace tanor {

UnsymmetricNewton::UnsymmetricNewton(EquilibriumEquations& equations, NewtonDescent& measure)
    : equations_(equations), model_(equations.model()), measure_(measure) {
  make_pattern();
}

void UnsymmetricNewton::make_pattern() {
  const StiffnessMatrix& W = equations_.stiffness();
  const std::size_t n = equations_.size(), rows = equations_.num_rows();
  std::vector<std::vector<int>> columns(n + rows);
  for (std::size_t i = 0; i < W.num_points(); ++i) {
    for (int k = W.start()[i]; k < W.start()[i + 1]; ++k) {
      const auto j = static_cast<std::size_t>(W.columns()[static_cast<std::size_t>(k)]);
      for (std::size_t entry = 0; entry < 9; ++entry)
        columns[3 * j + entry % 3].push_back(static_cast<int>(3 * i + entry / 3));
    }
  }
  const auto takes_part = [&](const Incidence& incidence) {
    return static_cast<std::size_t>(incidence.row) < rows && 3 * static_cast<std::size_t>(incidence.point) < n;
  };
  for (const Incidence& incidence : model_.incidences) {
    if (!takes_part(incidence)) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t point = 3 * static_cast<std::size_t>(incidence.point) + c;
      const std::size_t row = n + static_cast<std::size_t>(incidence.row);
      columns[row].push_back(static_cast<int>(point));
      columns[point].push_back(static_cast<int>(row));
    }
  }
  for (std::size_t row = n; row < n + rows; ++row) columns[row].push_back(static_cast<int>(row));
  SquarePattern pattern;
  for (std::vector<int>& column : columns) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
    pattern.rows.insert(pattern.rows.end(), column.begin(), column.end());
    pattern.start.push_back(static_cast<int>(pattern.rows.size()));
  }
  const auto slot = [&](std::size_t row, std::size_t column) {
    const auto begin = pattern.rows.begin() + pattern.start[column];
    const auto end = pattern.rows.begin() + pattern.start[column + 1];
    return static_cast<int>(std::lower_bound(begin, end, static_cast<int>(row)) - pattern.rows.begin());
  };
  for (std::size_t i = 0; i < W.num_points(); ++i) {
    for (int k = W.start()[i]; k < W.start()[i + 1]; ++k) {
      const auto j = static_cast<std::size_t>(W.columns()[static_cast<std::size_t>(k)]);
      for (std::size_t entry = 0; entry < 9; ++entry)
        stiffness_slots_.push_back(slot(3 * i + entry / 3, 3 * j + entry % 3));
    }
  }
  for (const Incidence& incidence : model_.incidences) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t point = 3 * static_cast<std::size_t>(incidence.point) + c;
      const std::size_t row = n + static_cast<std::size_t>(incidence.row);
      gradient_slots_.push_back(takes_part(incidence) ? std::array{slot(point, row), slot(row, point)}
                                                      : std::array{-1, -1});
    }
  }
  for (std::size_t row = n; row < n + rows; ++row) row_slots_.push_back(slot(row, row));
  factor_ = std::make_unique<SparseLu<double>>(std::move(pattern));
}

void UnsymmetricNewton::assemble(double shift) {
  constexpr double compliance = 1e-14;  // over the largest stiffness
  const StiffnessMatrix& W = equations_.stiffness();
  double* const values = factor_->values();
  std::fill_n(values, factor_->pattern().rows.size(), 0.0);
  for (std::size_t k = 0; k < stiffness_slots_.size(); ++k)
    values[stiffness_slots_[k]] += W.blocks()[k / 9].entries[k % 9];
  for (std::size_t i = 0; i < W.num_points(); ++i) {
    for (int k = W.start()[i]; k < W.start()[i + 1]; ++k) {
      if (static_cast<std::size_t>(W.columns()[static_cast<std::size_t>(k)]) != i) continue;
      for (const std::size_t entry : {0, 4, 8})
        values[stiffness_slots_[9 * static_cast<std::size_t>(k) + entry]] += shift * model_.mass[i];
    }
  }
  for (std::size_t k = 0; k < gradient_slots_.size(); ++k) {
    const auto [of_k, transposed] = gradient_slots_[k];
    if (of_k < 0) continue;
    const Incidence& incidence = model_.incidences[k / 3];
    const double g = incidence.sign * equations_.gradients()[3 * static_cast<std::size_t>(incidence.block) + k % 3];
    values[of_k] += g;
    values[transposed] += g;
  }
  const double stiffness = std::max(W.largest(), 1e-300);
  for (const int slot : row_slots_) values[slot] = -compliance / stiffness;
}

/// [ W  K ] [  dr     ]   [  g  ]
/// [ K' 0 ] [ -dlambda] = [ -xi ]
bool UnsymmetricNewton::find_step(const StaticState& state, double shift, std::vector<double>* step) {
  equations_.linearise(state.r.data(), state.lambda.data());
  (void)equations_.evaluate(state.r.data(), state.lambda.data(), g_.data(), xi_.data());
  assemble(shift);
  ++factorizations_;
  if (!factor_->factorize()) return false;
  const std::size_t n = equations_.size();
  step->assign(n + equations_.num_rows(), 0.0);
  std::vector<double> residual(step->size()), image(n), reactions(model_.num_rows()), rows(model_.num_rows());
  for (int round = 0; round < 3; ++round) {
    equations_.stiffness().multiply(step->data(), image.data());
    for (std::size_t i = 0; i < n; ++i) residual[i] = g_[i] - image[i] - shift * model_.mass[i / 3] * (*step)[i];
    for (std::size_t a = 0; a < equations_.num_rows(); ++a) reactions[a] = -(*step)[n + a];
    equations_.add_reactions(reactions.data(), residual.data());
    equations_.apply_transposed(step->data(), rows.data());
    for (std::size_t a = 0; a < equations_.num_rows(); ++a) residual[n + a] = -xi_[a] - rows[a];
    factor_->solve(residual.data());
    for (std::size_t k = 0; k < residual.size(); ++k) (*step)[k] += residual[k];
  }
  return std::all_of(step->begin(), step->end(), [](double x) { return std::isfinite(x); });
}

Outcome UnsymmetricNewton::run(const NewtonLimits& limits, StaticState* state, std::vector<double>* residuals) {
  g_.resize(equations_.size());
  xi_.resize(model_.num_rows());
  const auto combined = [](const StaticResidual& at, double scale) {
    return (scale > 0.0 ? at.force / scale : at.force) + at.violation;
  };
  iterations_ = factorizations_ = 0;
  double shift = 0.0;
  StaticResidual now = measure_.measure(*state);
  const double first_scale = now.scale;
  const auto fail = [&](const char* why) {
    return Outcome{Status::NotConverged, std::string("no equilibrium was found: ") + why + " after " +
                                             std::to_string(iterations_) + " iterations; best residual " +
                                             text(now.force) + " N (" + text(now.relative_force()) +
                                             " of the largest force) at point " +
                                             std::to_string(model_.numbering.user_point[now.worst_point]) +
                                             ", violation " + text(now.violation)};
  };
  for (;;) {
    residuals->push_back(now.force);
    if (!std::isfinite(now.force + now.scale + now.violation))
      return {Status::NotFinite, "forces or constraints are not finite where it starts"};
    // A lone force that vanishes where the point rests has no size there: it is small beside what it was.
    const double rounding = 64.0 * std::numeric_limits<double>::epsilon() *
                            std::max(first_scale, equations_.stiffness().largest() * model_.scene_size);
    if (now.force <= std::max(limits.force_tolerance * now.scale, rounding) && now.violation < 1e-10) return {};
    if (iterations_++ == limits.max_iterations) return fail("no convergence");
    std::vector<double> step;
    bool is_better = false;
    for (int attempt = 0; attempt < 40 && !is_better; ++attempt) {
      const bool is_found = find_step(*state, shift, &step);
      for (double length = 1.0; is_found && !is_better && length > 1e-3; length *= 0.5) {
        StaticState next = *state;
        for (std::size_t i = 0; i < equations_.size(); ++i) next.r[i] += length * step[i];
        for (std::size_t a = 0; a < equations_.num_rows(); ++a) next.lambda[a] -= length * step[equations_.size() + a];
        const StaticResidual found = measure_.measure(next);
        is_better = combined(found, now.scale) < (1.0 - 1e-4 * length) * combined(now, now.scale);
        if (!is_better) continue;
        *state = std::move(next);
        now = found;
      }
      const double frequency2 = equations_.stiffness().largest() / model_.mass[0] + 1e-300;
      shift = is_better ? (shift > 1e-12 * frequency2 ? 0.1 * shift : 0.0) : std::max(10.0 * shift, 1e-6 * frequency2);
    }
    if (!is_better) return fail("the search stalls");
  }
}

}  // namespace tanor
