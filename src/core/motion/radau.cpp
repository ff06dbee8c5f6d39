#include "motion/radau.hpp"

#include <algorithm>

#include "base/text.hpp"

namespace tanor::detail {

namespace {

/// Returns sum_j row_j stages_j[k].
double combine(const RadauCoefficients::Row& row, const std::array<std::vector<double>, 3>& stages, std::size_t k) {
  return row[0] * stages[0][k] + row[1] * stages[1][k] + row[2] * stages[2][k];
}

}  // namespace

Radau5::Radau5(const IntegrationOptions& options, Mechanics& mechanics)
    : options_(options), implicit_(options, mechanics), mechanics_(mechanics), equations_(*implicit_.equations) {
  const std::size_t n = mechanics.size(), d = equations_.num_rows();
  for (Stages<double>* stages : {&moved_, &x_, &v_, &a_}) {
    for (std::vector<double>& stage : *stages) stage.resize(n);
  }
  for (Stages<double>* stages : {&lambda_, &rows_}) {
    for (std::vector<double>& stage : *stages) stage.resize(d);
  }
  pair_.resize(n);
  pair_rows_.resize(d);
}

/// Keeps the last length if the wanted one is hardly longer, which is not worth new factors.
double Radau5::choose_step(double last, double wanted) const {
  return last <= wanted && wanted <= 1.2 * last ? last : wanted;
}

StepResult Radau5::step(const State& from, double h, State* to) {
  StepResult result;
  predict(from, h);
  if (result.outcome = solve_stages(from, h, to->t); !result.outcome.ok()) return result;
  to->work = from.work;
  if (mechanics_.has_work()) {
    if (result.outcome = add_work(from, h, to); !result.outcome.ok()) return result;
  }
  place_stage(from, h, to->t, 2);
  to->x = x_[2];
  to->v = v_[2];
  result = implicit_.finish(to, MovedVelocity::IsError);
  if (result.outcome.ok()) result.error = larger(result.error, estimate_error(from, h, *to));
  return result;
}

/// Predicts the stages from the polynomials through the last ones. That of v_0 + moved has degree 3, that of lambda
/// degree 2.
void Radau5::predict(const State& from, double h) {
  if (!knows_stages_ || (from.t != end_ && from.t != begin_)) return start_anew(from);
  const double last = end_ - begin_, from_u = (from.t - begin_) / last;
  const auto& c = radau_.c;
  const auto lagrange = [&](double u, std::size_t j, bool with_start) {
    double product = with_start ? u / c[j] : 1.0;
    for (std::size_t k = 0; k < 3; ++k) product *= k == j ? 1.0 : (u - c[k]) / (c[j] - c[k]);
    return product;
  };
  RadauCoefficients::Matrix of_moved, of_lambda;
  for (std::size_t i = 0; i < 3; ++i) {
    const double u = from_u + c[i] * h / last;
    for (std::size_t j = 0; j < 3; ++j) {
      of_moved[i][j] = lagrange(u, j, true) - lagrange(from_u, j, true);
      of_lambda[i][j] = lagrange(u, j, false);
    }
  }
  const auto apply = [](const RadauCoefficients::Matrix& m, Stages<double>& stages, std::size_t k) {
    const RadauCoefficients::Row old{stages[0][k], stages[1][k], stages[2][k]};
    for (std::size_t i = 0; i < 3; ++i) stages[i][k] = m[i][0] * old[0] + m[i][1] * old[1] + m[i][2] * old[2];
  };
  for (std::size_t k = 0; k < moved_[0].size(); ++k) apply(of_moved, moved_, k);
  for (std::size_t k = 0; k < lambda_[0].size(); ++k) apply(of_lambda, lambda_, k);
}

void Radau5::start_anew(const State& from) {
  for (std::vector<double>& stage : moved_) std::fill(stage.begin(), stage.end(), 0.0);
  for (std::vector<double>& stage : lambda_)
    equations_.write_multipliers(from.reactions, from.x.data(), from.v.data(), stage.data());
}

/// Iterates with the present matrices. If that stalls, makes new ones at the state that the iteration reached.
Outcome Radau5::solve_stages(const State& from, double h, double t_end) {
  constexpr int most_renewals = 2;
  knows_stages_ = false;
  for (int renewals = 0;; ++renewals) {
    if (implicit_.wants_linearisation()) {
      place_stage(from, h, t_end, 1);
      implicit_.linearise(stage_time(from, h, t_end, 1), x_[1].data(), v_[1].data(), lambda_[1].data());
    }
    if (implicit_.wants_factors(from, h)) {
      // s M - df/dv - df/dr/s with s = gamma/h and (alpha + i beta)/h
      const double s = radau_.gamma / h;
      const std::complex<double> z = radau_.alpha_beta / h;
      Outcome found = implicit_.factorize(NewtonWeights<double>{s, 1.0, 1.0 / s});
      if (found.ok()) found = implicit_.factorize(NewtonWeights<std::complex<double>>{z, 1.0, 1.0 / z});
      if (!found.ok()) {
        implicit_.renew();
        return found;
      }
    }
    bool converged = false;
    if (Outcome found = iterate(from, h, t_end, &converged); !found.ok()) {
      implicit_.renew();
      return found;
    }
    if (converged) break;
    implicit_.renew();
    if (renewals == most_renewals)
      return {Status::NotConverged, "Newton's iteration of the step from t = " + text(from.t) + " stalls"};
    if (!implicit_.newton.shrinks()) start_anew(from);
  }
  implicit_.note_convergence();
  knows_stages_ = true;
  begin_ = from.t;
  end_ = t_end;
  return {};
}

Outcome Radau5::iterate(const State& from, double h, double t_end, bool* converged) {
  const std::size_t n = from.x.size(), d = equations_.num_rows();
  const auto& s = radau_.t_inverse;
  for (;;) {
    for (std::size_t i = 0; i < 3; ++i) {
      place_stage(from, h, t_end, i);
      Outcome found = implicit_.evaluate(stage_time(from, h, t_end, i), x_[i].data(), v_[i].data(), lambda_[i].data(),
                                         a_[i].data(), rows_[i].data());
      if (!found.ok()) return found;
    }
    // The residuals M^-1 (f + K lambda) - A^-1 moved/h and the rows, transformed
    for (std::size_t k = 0; k < n; ++k) {
      RadauCoefficients::Row residual;
      for (std::size_t i = 0; i < 3; ++i) residual[i] = a_[i][k] - combine(radau_.a_inverse[i], moved_, k) / h;
      const auto along = [&](std::size_t i) {
        return s[i][0] * residual[0] + s[i][1] * residual[1] + s[i][2] * residual[2];
      };
      a_[0][k] = along(0);
      pair_[k] = {along(1), along(2)};
    }
    for (std::size_t k = 0; k < d; ++k) {
      pair_rows_[k] = {combine(s[1], rows_, k), combine(s[2], rows_, k)};
      rows_[0][k] = combine(s[0], rows_, k);
    }
    equations_.solve(a_[0].data(), rows_[0].data());
    equations_.solve(pair_.data(), pair_rows_.data());

    switch (implicit_.newton.check(take_increments(from, h))) {
      case NewtonIteration::Verdict::GoOn:
        break;
      case NewtonIteration::Verdict::Converged:
        *converged = true;
        return {};
      case NewtonIteration::Verdict::Stalls:
        return {};
    }
  }
}

double Radau5::stage_time(const State& from, double h, double t_end, std::size_t i) const {
  return i == 2 ? t_end : from.t + radau_.c[i] * h;
}

/// Computes r_i = r_0 + h c_i v_0 + h sum_j a_ij moved_j and v_i = v_0 + moved_i.
void Radau5::place_stage(const State& from, double h, double t_end, std::size_t i) {
  for (std::size_t k = 0; k < from.x.size(); ++k) {
    x_[i][k] = from.x[k] + h * (radau_.c[i] * from.v[k] + combine(radau_.a[i], moved_, k));
    v_[i][k] = from.v[k] + moved_[i][k];
  }
  mechanics_.prescribe(stage_time(from, h, t_end, i), x_[i].data(), v_[i].data());
}

/// Transforms the increments back and adds them. Returns the largest one over the tolerance.
double Radau5::take_increments(const State& from, double h) {
  const auto back = [&](const RadauCoefficients::Row& row, double first, std::complex<double> pair) {
    return row[0] * first + row[1] * pair.real() + row[2] * pair.imag();
  };
  for (std::size_t k = 0; k < from.x.size(); ++k) {
    const double first = a_[0][k];
    for (std::size_t i = 0; i < 3; ++i) {
      a_[i][k] = back(radau_.t[i], first, pair_[k]);
      moved_[i][k] += a_[i][k];
    }
  }
  for (std::size_t k = 0; k < lambda_[0].size(); ++k) {
    for (std::size_t i = 0; i < 3; ++i) lambda_[i][k] += back(radau_.t[i], rows_[0][k], pair_rows_[k]);
  }
  double largest = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < from.x.size(); ++k) x_[i][k] = h * combine(radau_.a[i], a_, k);
    const double ratio =
        mechanics_
            .error_ratios(from.t,
                          {x_[i].data(), a_[i].data(), from.x.data(), from.v.data(), from.x.data(), v_[i].data()},
                          options_.atol, options_.rtol)
            .largest();
    largest = ratio > largest || !(ratio == ratio) ? ratio : largest;
  }
  return largest;
}

/// Estimates the error over the tolerance. With s = gamma/h, rho_r = r_0' + sum e_i (r_i - r_0)/h = sum_j (e'A)_j
/// moved_j and rho_v = w_0 + sum e_i moved_i/h, it solves
///
///   (s M - df/dv - df/dr/s) e_v - K mu = M rho_v + df/dr rho_r/s,   K'e_v = 0,   e_r = (e_v + rho_r)/s
///
/// If the estimate exceeds the tolerance, it is repeated with w at (r_0 + e_r, v_0 + e_v) in place of w_0. Otherwise
/// stiff components that are already damped away would count.
double Radau5::estimate_error(const State& from, double h, const State& to) {
  const double s = radau_.gamma / h;
  RadauCoefficients::Row e_a{};
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) e_a[j] += radau_.e[i] * radau_.a[i][j];
  }
  std::vector<double>&rho = v_[0], &e_r = x_[0], &e_v = a_[0], &mu = rows_[0];
  e_v = from.a;
  double error = 0.0;
  for (int pass = 0; pass < 2; ++pass) {
    for (std::size_t k = 0; k < from.x.size(); ++k) {
      rho[k] = combine(e_a, moved_, k);
      e_r[k] = rho[k] / s;
      e_v[k] += combine(radau_.e, moved_, k) / h;
    }
    std::fill(mu.begin(), mu.end(), 0.0);
    equations_.add_stiffness(e_r.data(), e_v.data(), mu.data());
    equations_.solve(e_v.data(), mu.data());
    for (std::size_t k = 0; k < from.x.size(); ++k) e_r[k] = (e_v[k] + rho[k]) / s;
    error = mechanics_
                .error_ratios(from.t, {e_r.data(), e_v.data(), from.x.data(), from.v.data(), to.x.data(), to.v.data()},
                              options_.atol, options_.rtol)
                .largest();
    if (pass == 1 || !(error > 1.0)) break;
    std::vector<double>&x = x_[1], &v = v_[1], &lambda = rows_[1];
    for (std::size_t k = 0; k < from.x.size(); ++k) {
      x[k] = from.x[k] + e_r[k];
      v[k] = from.v[k] + e_v[k];
    }
    equations_.write_multipliers(to.reactions, x.data(), v.data(), lambda.data());
    if (!implicit_.evaluate(from.t, x.data(), v.data(), lambda.data(), e_v.data(), mu.data()).ok()) break;
  }
  return error;
}

/// Integrates the works by the stages, as the motion is.
Outcome Radau5::add_work(const State& from, double h, State* to) {
  for (std::size_t i = 0; i < 3; ++i) {
    place_stage(from, h, to->t, i);
    Power power;
    Outcome found = implicit_.evaluate(stage_time(from, h, to->t, i), x_[i].data(), v_[i].data(), lambda_[i].data(),
                                       a_[i].data(), rows_[i].data(), &power);
    if (!found.ok()) return found;
    to->work.add(h * radau_.a[2][i], power);
  }
  return {};
}

}  // namespace tanor::detail
