#pragma once

/// \file A system solved at one instant, and its certificate.

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "certificate/certificate.hpp"
#include "random_systems.hpp"

namespace tanor {
using namespace detail;

/// A system solved at its start, and the result, in the inner order.
struct Case {
  Forms forms;
  double t = 0.0;
  std::vector<double> r, v, w, eta, lambda, tau;

  /// The system that a certificate is given. A test may change it to differ from the one that was solved.
  System& told_system() { return const_cast<System&>(forms.model.system); }

  explicit Case(System system, const SolverOptions& options = {}) : forms(std::move(system), options) {
    const Model& model = forms.model;
    for (std::vector<double>* array : {&r, &v, &w, &eta, &tau}) array->resize(3 * model.num_points());
    lambda.resize(model.num_rows());
    model.numbering.gather_points(model.system.positions, r);
    model.numbering.gather_points(model.system.velocities, v);
    EXPECT_TRUE(forms.main->start(t, r.data(), v.data(), StartMode::Check).outcome.ok());
    solve();
  }
  SolveReport report;

  Case(const RandomSystem& random, const SolverOptions& options) : forms(random.system, options), t(random.t) {
    const Model& model = forms.model;
    for (std::vector<double>* array : {&r, &v, &w, &eta, &tau}) array->resize(3 * model.num_points());
    lambda.resize(model.num_rows());
    model.numbering.gather_points(random.positions, r);
    model.numbering.gather_points(random.velocities, v);
    forms.work.prescribe_all(t, r.data(), v.data());
    solve();
  }

  void solve() {
    const std::size_t size = forms.main->size();
    std::vector<double> x(size), x_dot(size), x_ddot(size);
    Reactions reactions;
    ASSERT_TRUE(forms.main->set_state(t, r.data(), v.data(), x.data(), x_dot.data()).ok());
    const Request to_rounding{.exact = true, .refuses_several = true};
    const Outcome begun = forms.main->begin(t, x.data(), x_dot.data(), forms.is_tangent() ? Request{} : to_rounding,
                                            {x_ddot.data(), nullptr, &report, &reactions});
    ASSERT_TRUE(begun.ok()) << begun.what;
    const Kinematics own{t, x.data(), x_dot.data()}, points{t, r.data(), v.data()};
    forms.main->write_points(own, x_ddot.data(), reactions, r.data(), v.data(), w.data());
    ASSERT_TRUE(forms.reactions({own, points}, to_rounding, reactions, lambda.data(), eta.data()).ok());
    forms.main->write_friction(reactions, tau.data());
  }
  Certificate certify(SecondFactorization by = SecondFactorization::Auto) {
    return tanor::certify(forms, {t, r, v, w, eta, lambda, tau, report.friction}, by);
  }
};

/// Returns true if a check whose identity has these words fails. Throws where there is none.
inline bool fails(const Certificate& certificate, const std::string& words) {
  const auto& checks = certificate.checks;
  const auto found = std::ranges::find_if(
      checks, [&](const CertificateCheck& check) { return check.identity.find(words) != std::string::npos; });
  if (found == checks.end()) throw std::out_of_range("nobody tries " + words);
  return !(found->error <= found->allowed);
}

/// Returns "<identity>" of the first check that failed.
inline std::string failed(const Certificate& certificate) {
  for (const CertificateCheck& check : certificate.checks) {
    if (!(check.error <= check.allowed)) return check.identity;
  }
  return "";
}

}  // namespace tanor
