#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <random>
#include <tanor/tanor.hpp>

#include "dense.hpp"
#include "friction/random_beads.hpp"
#include "reference.hpp"

/// \file The motions of beads at rest on rough planes, which rods join, have unknown directions of sliding. They are
/// looked for once more by Newton's method from a grid of directions, in each subset that sticks.
namespace tanor {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

System make_planes(unsigned seed, std::size_t count) {
  RandomBeads beads(seed, 0.2, 0.9);
  for (std::size_t k = 0; k < count; ++k) {
    const RandomBeads::Bead bead = beads.add();
    const std::string name = "p" + std::to_string(k);
    beads.system.constraints.push_back(
        Planes{name, {bead.index}, vector_of(bead.direction), bead.direction.dot(bead.r)});
    beads.system.friction.push_back(Coulomb{.name = "", .at = {name}, .coefficient = bead.mu});
  }
  return beads.finish();
}

/// Each bead has two components of friction, x [2n]; a = a0 + A x is along them, the reactions are nu = nu0 + V x.
struct Planar {
  std::vector<double> mu;
  std::vector<Eigen::Matrix<double, 3, 2>> T;
  MatrixXd A, V;
  VectorXd a0, nu0;

  explicit Planar(const System& system) {
    const reference::Mechanics dense = reference::make_mechanics(system, 0.0, system.positions, system.velocities);
    const auto n = static_cast<Eigen::Index>(system.masses.size());
    for (Eigen::Index c = 0; c < n; ++c) {
      mu.push_back(std::get<Coulomb>(system.friction[static_cast<std::size_t>(c)]).coefficient);
      const Vector3d k = dense.K.col(c).segment<3>(3 * c).normalized(), e = k.unitOrthogonal();
      T.emplace_back();
      T.back() << e, k.cross(e);
    }
    const MatrixXd S = dense.S();
    const auto answer = [&](const VectorXd& f, const VectorXd& phi, auto&& a, auto&& nu) {
      const VectorXd lambda = -reference::solve_full(S, phi + dense.K.transpose() * f.cwiseQuotient(dense.M));
      const VectorXd w = (f + dense.K * lambda).cwiseQuotient(dense.M);
      for (Eigen::Index c = 0; c < n; ++c) {
        a.template segment<2>(2 * c) = T[static_cast<std::size_t>(c)].transpose() * w.segment<3>(3 * c);
        nu(c) = lambda(c);
      }
    };
    A.resize(2 * n, 2 * n);
    V.resize(n, 2 * n);
    a0.resize(2 * n);
    nu0.resize(n);
    answer(dense.f, dense.phi, a0, nu0);
    for (Eigen::Index j = 0; j < 2 * n; ++j) {
      VectorXd f = VectorXd::Zero(dense.f.size());
      f.segment<3>(3 * (j / 2)) = T[static_cast<std::size_t>(j / 2)].col(j % 2);
      answer(f, VectorXd::Zero(dense.phi.size()), A.col(j), V.col(j));
    }
  }

  /// Returns the accelerations of all motions that were found. `margin` is that of RoughContacts.
  std::vector<VectorXd> find_all(double* margin) const {
    const auto n = static_cast<Eigen::Index>(mu.size());
    std::vector<VectorXd> motions;
    constexpr int directions = 12;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> log_size(-1.5, 2.5);
    if (can_rest(margin)) motions.push_back(VectorXd::Zero(2 * n));
    for (unsigned subset = 1; subset < (1u << n); ++subset) {
      const auto slides = [&](Eigen::Index c) { return ((subset >> c) & 1) != 0; };
      int starts = 1;
      for (Eigen::Index c = 0; c < n; ++c) starts *= slides(c) ? directions : 1;
      for (int start = 0; start < 3 * starts; ++start) {
        VectorXd x = VectorXd::Zero(2 * n);
        int rest = start / 3;
        for (Eigen::Index c = 0; c < n; ++c) {
          if (!slides(c)) continue;
          const double angle = 6.283185307179586 * (rest % directions) / directions;
          rest /= directions;
          x.segment<2>(2 * c) = std::exp(log_size(random)) * mu[static_cast<std::size_t>(c)] *
                                (0.1 + std::abs(nu0(c))) * Vector2d(std::cos(angle), std::sin(angle));
        }
        if (!solve(slides, &x)) continue;
        const VectorXd a = a0 + A * x;
        const double size = a0.norm();
        bool obeys = true;
        double least = 1.0;
        for (Eigen::Index c = 0; c < n; ++c) {
          const Vector2d own = x.segment<2>(2 * c), towards = a.segment<2>(2 * c);
          const double limit = mu[static_cast<std::size_t>(c)] * std::abs(nu0(c) + V.row(c) * x);
          const double slack =
              slides(c) ? -own.dot(towards) / (own.norm() * size) : (limit - own.norm()) / (limit + own.norm());
          obeys = obeys && slack >= 0.0;
          least = std::min(least, std::abs(slack));
        }
        if (!obeys) continue;
        *margin = std::min(*margin, least);
        const bool is_known = std::any_of(motions.begin(), motions.end(),
                                          [&](const VectorXd& other) { return (other - a).norm() < 1e-7 * size; });
        if (!is_known) motions.push_back(a);
      }
    }
    return motions;
  }

 private:
  /// Returns true if some friction lets all beads rest. The rods' pulls are statically undetermined, so that the search
  /// goes along lines in the space of that friction.
  bool can_rest(double* margin) const {
    const auto n = static_cast<Eigen::Index>(mu.size());
    MatrixXd vectors;
    const VectorXd values = reference::eigenvalues(A, &vectors);
    const Eigen::Index rank = (values.array() > 1e-10 * values.maxCoeff()).count();
    const MatrixXd F = vectors.leftCols(2 * n - rank);
    const VectorXd least = -reference::solve_least_squares(A, a0);
    const auto slack = [&](const VectorXd& x) {
      double worst = 1.0;
      for (Eigen::Index c = 0; c < n; ++c) {
        const double limit = mu[static_cast<std::size_t>(c)] * std::abs(nu0(c) + V.row(c) * x),
                     own = x.segment<2>(2 * c).norm();
        worst = std::min(worst, (limit - own) / (limit + own));
      }
      return worst;
    };
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    double best = slack(least);
    for (int line = 0; line < (F.cols() == 1 ? 1 : 3000); ++line) {
      VectorXd d(F.cols()), at = VectorXd::Zero(F.cols());
      for (Eigen::Index i = 0; i < d.size(); ++i) {
        d(i) = F.cols() == 1 ? 1.0 : normal(random);
        at(i) = F.cols() == 1 ? 0.0 : 3.0 * (least.norm() + nu0.norm()) * normal(random);
      }
      const VectorXd from = least + F * at, along = F * d;
      std::vector<double> roots{0.0};
      for (Eigen::Index c = 0; c < n; ++c) {
        // The limit is reached where |x + s d|^2 = mu^2 (nu + s V d)^2.
        const double m = mu[static_cast<std::size_t>(c)] * mu[static_cast<std::size_t>(c)],
                     nu = nu0(c) + V.row(c) * from, dnu = V.row(c) * along;
        const Vector2d x = from.segment<2>(2 * c), dx = along.segment<2>(2 * c);
        const double a = dx.squaredNorm() - m * dnu * dnu, b = x.dot(dx) - m * nu * dnu,
                     e = x.squaredNorm() - m * nu * nu;
        if (b * b < a * e) continue;
        for (const double sign : {1.0, -1.0}) roots.push_back((-b + sign * std::sqrt(b * b - a * e)) / a);
      }
      std::sort(roots.begin(), roots.end());
      for (std::size_t i = 0; i + 1 < roots.size(); ++i)
        best = std::max(best, slack(from + 0.5 * (roots[i] + roots[i + 1]) * along));
      const double wide = 1.0 + roots.back() - roots.front();
      best =
          std::max({best, slack(from + (roots.front() - wide) * along), slack(from + (roots.back() + wide) * along)});
    }
    *margin = std::min(*margin, std::abs(best));
    return best >= 0.0;
  }

  /// Solves for a_c = 0 where a bead sticks; else for |x_c|^2 = mu^2 nu_c^2 with x_c parallel to a_c.
  template <class Slides>
  bool solve(const Slides& slides, VectorXd* x) const {
    const auto n = static_cast<Eigen::Index>(mu.size());
    MatrixXd J(2 * n, 2 * n);
    VectorXd F(2 * n);
    for (int pass = 0; pass < 40; ++pass) {
      const VectorXd a = a0 + A * *x;
      J.setZero();
      for (Eigen::Index c = 0; c < n; ++c) {
        const Eigen::Index i = 2 * c, j = i + 1;
        if (!slides(c)) {
          F.segment<2>(i) = a.segment<2>(i);
          J.middleRows<2>(i) = A.middleRows<2>(i);
          continue;
        }
        const double m = mu[static_cast<std::size_t>(c)] * mu[static_cast<std::size_t>(c)], nu = nu0(c) + V.row(c) * *x;
        F(i) = (*x)(i) * (*x)(i) + (*x)(j) * (*x)(j)-m * nu * nu;
        J.row(i) = -2.0 * m * nu * V.row(c);
        J(i, i) += 2.0 * (*x)(i);
        J(i, j) += 2.0 * (*x)(j);
        F(j) = (*x)(i)*a(j) - (*x)(j)*a(i);
        J.row(j) = (*x)(i)*A.row(j) - (*x)(j)*A.row(i);
        J(j, i) += a(j);
        J(j, j) -= a(i);
      }
      const VectorXd step = reference::solve_partial(J, F);
      if (!step.allFinite()) return false;
      *x -= step;
      if (step.norm() <= 1e-13 * x->norm()) return true;
    }
    return false;
  }
};

TEST(FrictionOnPlanes, BeadsAtRestHaveAsManyMotionsAsTheLaw) {
  int unique = 0, several = 0, none = 0, unproven = 0;
  for (const std::size_t count : {2, 3}) {
    for (unsigned seed = 1; seed <= (count == 2 ? 60u : 15u); ++seed) {
      const System system = make_planes(seed, count);
      double margin = 1.0;
      const Planar twin(system);
      const std::vector<VectorXd> all = twin.find_all(&margin);
      if (margin < 1e-6) continue;
      Dynamics dynamics(system);
      std::vector<double> w(3 * count);
      const SolveReport report = dynamics.solve(
          {.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w});
      const Simulation run(system);
      SCOPED_TRACE(std::to_string(count) + " beads, seed " + std::to_string(seed) + ": " + std::to_string(all.size()) +
                   " motions; " + report.outcome.what + report.friction.uniqueness_reason);
      const bool is_unproven = report.friction.uniqueness == Uniqueness::Unproven;
      unproven += is_unproven ? 1 : 0;
      (all.empty() ? none : all.size() == 1 ? unique : several) += 1;
      if (is_unproven) {
        EXPECT_NE(report.friction.uniqueness_reason.find("too many"), std::string::npos);
        continue;
      }
      EXPECT_EQ(report.outcome.status, status_of(all.size()));
      EXPECT_EQ(run.outcome().status, status_of(all.size())) << run.outcome().what;
      if (all.size() != 1 || !report.outcome.ok()) continue;
      EXPECT_EQ(report.friction.uniqueness, Uniqueness::Proven);
      for (std::size_t c = 0; c < count; ++c) {
        const Vector2d a = twin.T[c].transpose() * reference::point(w, static_cast<Index>(c));
        EXPECT_LE((a - all[0].segment<2>(2 * static_cast<Eigen::Index>(c))).norm(), 1e-9 * (1.0 + all[0].norm()));
      }
    }
  }
  EXPECT_LE(unproven, 3);
  EXPECT_GT(unique, 40);
  EXPECT_GT(several, 0);
}

// Some contacts give way, then others, and each time the law is searched again. All of that has one budget.
TEST(FrictionOnPlanes, SearchesOfHardIslandsEndSoonAndSaySo) {
  double longest = 0.0;
  int unproven = 0;
  for (unsigned seed = 1; seed <= 14; ++seed) {
    System system = make_planes(seed, 3 + seed % 7);
    for (Friction& friction : system.friction) {
      auto& coulomb = std::get<Coulomb>(friction);
      coulomb.static_coefficient = 1.5 * coulomb.coefficient;
    }
    Dynamics dynamics(system);
    std::vector<double> w(system.positions.size());
    const std::clock_t begin = std::clock();
    const SolveReport report = dynamics.solve(
        {.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w});
    longest = std::max(longest, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    unproven += report.friction.uniqueness == Uniqueness::Unproven ? 1 : 0;
  }
  EXPECT_GT(unproven, 3);
  EXPECT_LT(longest, 1.2);  // s; 0.6 s where the library is optimized, and half of it on a fast processor
}

}  // namespace
}  // namespace tanor
