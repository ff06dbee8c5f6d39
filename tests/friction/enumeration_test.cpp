#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <tanor/tanor.hpp>

#include "dense.hpp"
#include "friction/contact_problem.hpp"
#include "friction/random_beads.hpp"
#include "friction/rough_contacts.hpp"
#include "reference.hpp"

/// \file The motions of few contacts at rest, counted by tanor and by programs of another kind: homotopy continuation
/// for beads on lines in space, all signs in the plane, Newton's method from a grid of directions on planes.
namespace tanor {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

struct Kind {
  unsigned first_seed, scenes;
  std::size_t beads, lines;  // the other beads are free
  bool doubled, closed;      // a rod given twice; a rod from the last bead to the first one
};

System make_beads(unsigned seed, const Kind& kind) {
  RandomBeads beads(seed, 0.1, 0.7);
  for (std::size_t k = 0; k < kind.beads; ++k) {
    const RandomBeads::Bead bead = beads.add();
    if (k >= kind.lines) continue;
    const std::string name = "l" + std::to_string(k);
    beads.system.constraints.push_back(Lines{name, {bead.index}, vector_of(bead.r), vector_of(bead.direction)});
    beads.system.friction.push_back(Coulomb{.name = "", .at = {name}, .coefficient = bead.mu});
  }
  if (kind.doubled) beads.rods.pairs.push_back({0, 1});
  if (kind.closed) beads.rods.pairs.push_back({0, static_cast<Index>(kind.beads) - 1});
  return beads.finish();
}

Uniqueness uniqueness_of(std::size_t motions) {
  return motions == 0 ? Uniqueness::None : motions == 1 ? Uniqueness::Proven : Uniqueness::Several;
}

/// Returns all "(x, y, z)" of a text.
std::vector<Vector3d> vectors_in(const std::string& text) {
  std::vector<Vector3d> result;
  for (std::size_t k = text.find('('); k != std::string::npos; k = text.find('(', k + 1)) {
    Vector3d each;
    if (std::sscanf(text.c_str() + k, "(%lf, %lf, %lf)", &each(0), &each(1), &each(2)) == 3) result.push_back(each);
  }
  return result;
}

TEST(FrictionEnumeration, FourHundredScenesHaveAsManyMotionsAsTheLaw) {
  const Kind kinds[] = {{1, 100, 2, 2, false, false}, {1, 60, 3, 3, false, false},  {1, 40, 3, 2, false, false},
                        {1, 60, 4, 4, false, false},  {1, 40, 4, 3, false, false},  {1, 30, 4, 2, false, false},
                        {201, 20, 2, 2, true, false}, {201, 20, 3, 3, true, false}, {201, 10, 3, 3, false, true},
                        {201, 20, 4, 3, false, true}};
  unsigned num_scenes = 0, several = 0, resting = 0, borderline = 0;
  for (const Kind& kind : kinds) {
    for (unsigned seed = kind.first_seed; seed < kind.first_seed + kind.scenes; ++seed) {
      ++num_scenes;
      const System system = make_beads(seed, kind);
      const reference::RoughContacts twin(system);
      const auto counted = twin.find_all();
      // Rounding may decide between several motions here; that is so in a few of these scenes.
      constexpr double told_apart = 1e-6;
      if (counted.margin < told_apart || !counted.is_certain) {
        ++borderline;
        continue;
      }
      const auto& motions = counted.motions;
      std::vector<double> w(system.positions.size());
      Dynamics dynamics(system);
      const SolveReport report = dynamics.solve(
          {.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w});
      const Simulation run(system);
      SCOPED_TRACE(std::to_string(kind.beads) + " beads, seed " + std::to_string(seed) + ": " +
                   std::to_string(motions.size()) + " motions; " + report.outcome.what);
      EXPECT_EQ(report.outcome.status, status_of(motions.size()));
      EXPECT_EQ(run.outcome().status, status_of(motions.size())) << run.outcome().what;
      EXPECT_EQ(report.friction.uniqueness, uniqueness_of(motions.size())) << report.friction.uniqueness_reason;
      if (motions.size() == 1 && report.outcome.ok()) {
        for (std::size_t c = 0; c < twin.mu.size(); ++c) {
          const auto i = static_cast<Eigen::Index>(c);
          const double wanted = motions[0].a(i), scale = 1.0 + motions[0].a.lpNorm<Eigen::Infinity>();
          EXPECT_NEAR(twin.lines[c].dot(reference::point(w, static_cast<Index>(twin.points[c]))), wanted, 1e-9 * scale);
          EXPECT_NEAR(twin.lines[c].dot(reference::point(run.accelerations(), static_cast<Index>(twin.points[c]))),
                      wanted, 1e-9 * scale);
        }
        resting += motions[0].a.lpNorm<Eigen::Infinity>() < 1e-9 ? 1 : 0;
      } else if (motions.size() > 1) {
        ++several;
        EXPECT_NE(report.outcome.what.find(std::to_string(motions.size()) + " accelerations"), std::string::npos);
        // Each named acceleration belongs to a contact that the message names.
        const std::vector<Vector3d> named = vectors_in(report.outcome.what);
        EXPECT_EQ(named.size(), motions.size());
        for (std::size_t c = 0; c < twin.mu.size(); ++c) {
          if (report.outcome.what.find("at l" + std::to_string(c) + "[0]") == std::string::npos) continue;
          for (const auto& motion : motions) {
            const Vector3d a = motion.a(static_cast<Eigen::Index>(c)) * twin.lines[c];
            const bool is_named = std::any_of(named.begin(), named.end(), [&](const Vector3d& each) {
              return (each - a).norm() <= 5e-4 * a.norm() + 1e-12;  // messages have four digits
            });
            EXPECT_TRUE(is_named) << a.transpose();
          }
        }
      }
    }
  }
  EXPECT_EQ(num_scenes, 400u);
  EXPECT_LE(borderline, 4u);
  EXPECT_GT(several, 25u);
  EXPECT_GT(resting, 60u);
}

// ---- ten contacts, eleven contacts ----

/// Makes a row of beads on lines in the plane z = 0, which has one degree of freedom and a reaction along one line
/// each.
System make_row(unsigned seed, std::size_t count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-1.0, 1.0), angle(0.0, 6.283185307179586), log_mass(-1.0, 1.0),
      coefficient(0.1, 0.7);
  System system;
  Rods rods{"rods", {}, {}, {}};
  for (std::size_t k = 0; k < count; ++k) {
    const auto bead = static_cast<Index>(k);
    const Vector3 r{2.0 * static_cast<double>(k), place(random), 0.0};
    system.positions.insert(system.positions.end(), r.begin(), r.end());
    system.masses.push_back(std::exp(log_mass(random)));
    const double a = angle(random), b = angle(random);
    const std::string name = "l" + std::to_string(k);
    system.constraints.push_back(Lines{name, {bead}, r, Vector3{std::cos(a), std::sin(a), 0.0}});
    system.forces.push_back(ConstantForce{"", {bead}, Vector3{3.0 * std::cos(b), 3.0 * std::sin(b), 0.0}});
    system.friction.push_back(Coulomb{.name = "", .at = {name}, .coefficient = coefficient(random)});
    if (k > 0) rods.pairs.push_back({bead - 1, bead});
  }
  system.velocities.assign(3 * count, 0.0);
  system.constraints.push_back(rods);
  return system;
}

/// The motions of such a row: bead k has the acceleration c_k u along its line, and the forces R = F + T_k e_k -
/// T_(k-1) e_(k-1) act on it besides those of the line, for the pulls T of the rods.
struct Row {
  std::vector<double> mass, mu, c;
  std::vector<Vector2d> F, l, n, e;

  explicit Row(const System& system) {
    const std::size_t count = system.masses.size();
    const auto plane = [](const Vector3d& a) { return Vector2d(a(0), a(1)); };
    const auto values = [&](const VectorFunction& f) {
      return Vector2d(f.components[0](0.0).value(), f.components[1](0.0).value());
    };
    for (std::size_t k = 0; k < count; ++k) {
      mass.push_back(system.masses[k]);
      mu.push_back(std::get<Coulomb>(system.friction[k]).coefficient);
      l.push_back(values(std::get<Lines>(system.constraints[k]).direction).normalized());
      n.emplace_back(-l[k](1), l[k](0));
      F.push_back(values(std::get<ConstantForce>(system.forces[k]).force));
      const auto bead = static_cast<Index>(k);
      if (k + 1 < count)
        e.push_back(plane(reference::point(system.positions, bead + 1) - reference::point(system.positions, bead))
                        .normalized());
      c.push_back(k == 0 ? 1.0 : c[k - 1] * e[k - 1].dot(l[k - 1]) / e[k - 1].dot(l[k]));
    }
  }

  /// Returns u of all motions. For each sense of u all signs of the reactions are tried, with one linear system each.
  std::vector<double> find_all(double* margin) const {
    const auto count = static_cast<Eigen::Index>(mass.size());
    std::vector<double> found;
    if (can_rest()) found.push_back(0.0);
    for (const double sense : {1.0, -1.0}) {
      for (unsigned signs = 0; signs < (1u << count); ++signs) {
        // The equations m c u = l.R - sense sgn(c) mu sigma n.R hold with sigma n.R >= 0; unknowns are u, T_0, ...
        Eigen::MatrixXd J = Eigen::MatrixXd::Zero(count, count);
        VectorXd b(count);
        const auto sigma = [&](Eigen::Index k) { return (signs >> k) & 1 ? 1.0 : -1.0; };
        const auto at = [](Eigen::Index k) { return static_cast<std::size_t>(k); };
        for (Eigen::Index k = 0; k < count; ++k) {
          const Vector2d along = l[at(k)] - sense * std::copysign(1.0, c[at(k)]) * mu[at(k)] * sigma(k) * n[at(k)];
          J(k, 0) = mass[at(k)] * c[at(k)];
          if (k + 1 < count) J(k, k + 1) = -along.dot(e[at(k)]);
          if (k > 0) J(k, k) += along.dot(e[at(k) - 1]);
          b(k) = along.dot(F[at(k)]);
        }
        const VectorXd x = reference::solve_partial(J, b);
        if (!x.allFinite() || sense * x(0) <= 0.0) continue;
        bool obeys = true;
        double least = 1.0;
        for (Eigen::Index k = 0; k < count; ++k) {
          Vector2d R = F[at(k)];
          if (k + 1 < count) R += x(k + 1) * e[at(k)];
          if (k > 0) R -= x(k) * e[at(k) - 1];
          obeys = obeys && sigma(k) * n[at(k)].dot(R) >= 0.0;
          least = std::min(least, std::abs(n[at(k)].dot(R)) / (R.norm() + 1e-3));
        }
        if (obeys) {
          found.push_back(x(0));
          *margin = std::min(*margin, least);
        }
      }
    }
    return found;
  }

  /// Returns true if some pulls let all beads rest. The pulls T_k that T_(k-1) leaves possible are intervals, from bead
  /// to
  /// bead.
  bool can_rest() const {
    using Interval = std::pair<double, double>;
    constexpr double far = 1e9;
    std::vector<Interval> before{{0.0, 0.0}};
    for (std::size_t k = 0; k < mass.size(); ++k) {
      const Vector2d to = k + 1 < mass.size() ? e[k] : Vector2d::Zero().eval(),
                     from = k > 0 ? e[k - 1] : Vector2d::Zero().eval();
      // The condition |l.R| <= mu |n.R| says that the product of f_+ and f_-, mu n.R +- l.R, is not negative.
      const Vector2d normals[2] = {mu[k] * n[k] + l[k], mu[k] * n[k] - l[k]};
      const auto product = [&](double T0, double T1) {
        const Vector2d R = F[k] + T1 * to - T0 * from;
        return normals[0].dot(R) * normals[1].dot(R);
      };
      const auto is_possible = [&](double T1, const Interval& own) {
        std::vector<double> tried{own.first, own.second};
        for (const Vector2d& f : normals) {
          const double root = f.dot(F[k] + T1 * to) / f.dot(from);
          if (root > own.first && root < own.second) tried.push_back(root);
        }
        std::sort(tried.begin(), tried.end());
        const std::size_t ends = tried.size();
        for (std::size_t i = 0; i + 1 < ends; ++i) tried.push_back(0.5 * (tried[i] + tried[i + 1]));
        return std::any_of(tried.begin(), tried.end(), [&](double T0) { return product(T0, T1) >= 0.0; });
      };
      if (k + 1 == mass.size())
        return std::any_of(before.begin(), before.end(), [&](const Interval& own) { return is_possible(0.0, own); });
      std::vector<Interval> after;
      for (const Interval& own : before) {
        std::vector<double> ends{-far, far};
        for (const Vector2d& f : normals) {
          for (const double T0 : {own.first, own.second}) ends.push_back(-f.dot(F[k] - T0 * from) / f.dot(to));
        }
        // Both f_+ and f_- vanish where R = 0.
        Eigen::Matrix2d both;
        both << to, -from;
        if (std::abs(both.determinant()) > 1e-12) {
          const Vector2d T = -both.inverse() * F[k];
          if (T(1) >= own.first && T(1) <= own.second) ends.push_back(T(0));
        }
        std::sort(ends.begin(), ends.end());
        for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
          if (is_possible(0.5 * (ends[i] + ends[i + 1]), own)) after.emplace_back(ends[i], ends[i + 1]);
        }
      }
      // The intervals are united.
      std::sort(after.begin(), after.end());
      before.clear();
      for (const Interval& each : after) {
        if (!before.empty() && each.first <= before.back().second)
          before.back().second = std::max(before.back().second, each.second);
        else
          before.push_back(each);
      }
    }
    return false;
  }
};

TEST(FrictionEnumeration, TenContactsAreCountedAndElevenAreNot) {
  std::multiset<std::size_t> counts;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    for (const std::size_t count : {10, 11}) {
      const System system = make_row(seed, count);
      Dynamics dynamics(system);
      std::vector<double> w(3 * count);
      const SolveReport report = dynamics.solve(
          {.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w});
      SCOPED_TRACE("seed " + std::to_string(seed) + ": " + report.outcome.what);
      if (count == 11) {
        if (report.outcome.ok() && report.friction.uniqueness != Uniqueness::Proven) {
          EXPECT_EQ(report.friction.uniqueness, Uniqueness::Unproven);
          EXPECT_NE(report.friction.uniqueness_reason.find("more than ten"), std::string::npos);
        }
        EXPECT_NE(report.friction.uniqueness, Uniqueness::None);
        continue;
      }
      double margin = 1.0;
      const Row row(system);
      const std::vector<double> all = row.find_all(&margin);
      if (margin < 1e-6) continue;
      counts.insert(all.size());
      EXPECT_EQ(report.outcome.status, status_of(all.size())) << all.size();
      EXPECT_EQ(report.friction.uniqueness, uniqueness_of(all.size())) << report.friction.uniqueness_reason;
      if (all.size() == 1 && report.outcome.ok()) {
        const double along = Vector2d(w[0], w[1]).dot(row.l[0]);
        EXPECT_NEAR(along, all[0], 1e-8 * (1.0 + std::abs(all[0])));
      }
    }
  }
  EXPECT_GT(counts.count(1), 10u);
  EXPECT_GT(counts.size(), 35u);
}

TEST(FrictionEnumeration, SeventyBeadsThatAreTooManyToCountStayAtRest) {
  System system = make_row(1, 70);
  for (Constraint& constraint : system.constraints) {
    if (auto* const line = std::get_if<Lines>(&constraint)) line->direction = Vector3{0.0, 1.0, 0.0};
  }
  for (std::size_t k = 0; k < 70; ++k) {
    system.positions[3 * k + 1] = 0.0;
    std::get<Lines>(system.constraints[k]).origin = Vector3{2.0 * static_cast<double>(k), 0.0, 0.0};
    system.forces[k] = ConstantForce{"", {static_cast<Index>(k)}, Vector3{0.0, 0.09, 1.0}};  // mu is 0.1 at least
  }
  Dynamics dynamics(system);
  std::vector<double> w(system.positions.size(), 1.0);

  const SolveReport report = dynamics.solve(
      {.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w});

  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  EXPECT_EQ(report.friction.sticking, 70u);
  for (const double each : w) EXPECT_NEAR(each, 0.0, 1e-12);
}

// ---- contacts that all slide ----

using detail::ContactProblem;

/// Makes contacts that slide, with reactions that turn in a plane, or keep to a line, and change each other.
ContactProblem make_sliding(unsigned seed, Eigen::Index count, bool on_lines) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> mu(0.1, 1.2);
  ContactProblem problem;
  problem.A = Eigen::MatrixXd::Identity(count, count);
  problem.a0 = VectorXd::Zero(count);
  problem.N0 = VectorXd::Zero(3 * count);
  problem.W = Eigen::MatrixXd::Zero(3 * count, count);
  for (Eigen::Index c = 0; c < count; ++c) {
    problem.contacts.push_back({c, 1, true, mu(random)});
    const Vector3d u = Vector3d::NullaryExpr([&] { return normal(random); }),
                   v = on_lines ? u : Vector3d::NullaryExpr([&] { return normal(random); });
    problem.N0.segment<3>(3 * c) = normal(random) * u + normal(random) * v;
    for (Eigen::Index j = 0; j < count; ++j)
      problem.W.block<3, 1>(3 * c, j) = 0.6 * (normal(random) * u + normal(random) * v);
  }
  return problem;
}

/// Returns the sizes of friction that Newton's method finds from many starts.
std::vector<VectorXd> find_sizes(const ContactProblem& problem, int starts) {
  const Eigen::Index count = problem.size();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> log_size(-3.0, 5.0);
  std::vector<VectorXd> found;
  for (int start = 0; start < starts; ++start) {
    VectorXd s = VectorXd::NullaryExpr(count, [&] { return std::exp(log_size(random)); }), F(count);
    for (int pass = 0; pass < 60; ++pass) {
      Eigen::MatrixXd J = Eigen::MatrixXd::Identity(count, count);
      for (Eigen::Index c = 0; c < count; ++c) {
        const auto k = static_cast<std::size_t>(c);
        const Vector3d N = problem.normal_force(k, s);
        F(c) = s(c) - problem.contacts[k].mu * N.norm();
        J.row(c) -= problem.contacts[k].mu * N.normalized().transpose() * problem.W.middleRows<3>(3 * c);
      }
      s -= reference::solve_partial(J, F);
      if (!s.allFinite()) break;
    }
    if (!s.allFinite() || s.minCoeff() < 0.0 || F.norm() > 1e-11 * s.norm()) continue;
    const auto is_same = [&](const VectorXd& other) { return (other - s).norm() <= 1e-7 * s.norm(); };
    if (std::none_of(found.begin(), found.end(), is_same)) found.push_back(s);
  }
  return found;
}

TEST(FrictionEnumeration, SizesOfFrictionThatSlidesAreThoseThatNewtonsMethodFindsFromManyStarts) {
  std::multiset<std::size_t> counts;
  int open = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    for (const bool on_lines : {true, false}) {
      const ContactProblem problem = make_sliding(seed, seed % 3 + 1, on_lines);
      const std::vector<VectorXd> wanted = find_sizes(problem, 400);
      std::size_t work_left = detail::most_work(true);

      const detail::ContactSolutions all = detail::find_all(problem, &work_left, {});

      SCOPED_TRACE("seed " + std::to_string(seed) + (on_lines ? ", lines" : ", planes") + ": " + all.reason);
      if (!all.is_complete) {
        ++open;
        continue;
      }
      counts.insert(wanted.size());
      EXPECT_EQ(all.found.size(), wanted.size());
      EXPECT_EQ(all.uniqueness, uniqueness_of(wanted.size()));
      for (const VectorXd& s : all.found) {
        EXPECT_TRUE(std::any_of(wanted.begin(), wanted.end(),
                                [&](const VectorXd& other) { return (other - s).norm() <= 1e-7 * s.norm(); }));
      }
    }
  }
  EXPECT_LE(open, 2);
  EXPECT_GT(counts.count(0), 5u);
  EXPECT_GT(counts.count(1), 40u);
  EXPECT_GT(counts.size() - counts.count(0) - counts.count(1), 5u);
}

/// Every sign sigma of the reactions gives one linear system (I - sigma mu n.W) s = sigma mu n.N0.
TEST(FrictionEnumeration, TenContactsThatSlideOnLinesAreCountedInTheMiddleOfARun) {
  std::multiset<std::size_t> counts;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    constexpr Eigen::Index count = 10;
    ContactProblem problem = make_sliding(seed, count, true);
    problem.W *= 0.3;
    std::size_t wanted = 0;
    for (unsigned signs = 0; signs < 1u << count; ++signs) {
      Eigen::MatrixXd J = Eigen::MatrixXd::Identity(count, count);
      VectorXd b(count);
      for (Eigen::Index c = 0; c < count; ++c) {
        const Vector3d along = ((signs >> c) & 1 ? -1.0 : 1.0) * problem.contacts[static_cast<std::size_t>(c)].mu *
                               problem.N0.segment<3>(3 * c).normalized();
        J.row(c) -= along.transpose() * problem.W.middleRows<3>(3 * c);
        b(c) = along.dot(problem.N0.segment<3>(3 * c));
      }
      wanted += reference::solve_partial(J, b).minCoeff() > 0.0;
    }
    std::size_t work_left = detail::most_work(false);

    const detail::ContactSolutions all = detail::find_all(problem, &work_left, {});

    EXPECT_TRUE(all.is_complete) << all.reason;
    EXPECT_EQ(all.found.size(), wanted);
    EXPECT_EQ(all.uniqueness, uniqueness_of(wanted));
    counts.insert(wanted);
  }
  EXPECT_GT(counts.count(1), 0u);
  EXPECT_LT(counts.count(1), counts.size());
}

TEST(FrictionEnumeration, TheReasonOfSlidingThatIsUnprovenIsThatOfItsSearch) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0, 0.3, 0.0, 1.8, -0.5, 0.0};
  system.velocities = {1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0};
  system.masses = {1.0, 1.5, 0.7};
  system.constraints = {Planes{"table", {0, 1, 2}, Vector3{0.0, 0.0, 1.0}, 0.0},
                        Rods{"rods", {{0, 1}, {1, 2}}, {}, {}}};
  system.forces = {Gravity{"", {0.0, 0.0, -10.0}}, ConstantForce{"", {1}, Vector3{3.0, 4.0, 0.0}}};
  system.friction = {Coulomb{.name = "", .at = {"table"}, .coefficient = 1.05, .reaction = Coulomb::Reaction::Full}};
  Dynamics dynamics(system);
  std::vector<double> w(9);

  const SolveReport report = dynamics.solve(
      {.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w});

  EXPECT_EQ(report.friction.uniqueness, Uniqueness::Unproven) << report.outcome.what;
  EXPECT_NE(report.friction.uniqueness_reason.find("turn in space"), std::string::npos)
      << report.friction.uniqueness_reason;
}

}  // namespace
}  // namespace tanor
