/// The certificate finds every single corrupted number.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "certificate/tampering.hpp"
#include "reference.hpp"

namespace tanor {
namespace {

TEST(TamperedCertificate, FindsEveryCorruptedSlotOfS) {
  for (const System& system : {make_driven_chain(), make_chain_with_coordinates()}) {
    const std::size_t slots = Tampering::num_slots(
        Tampering::S(Case(system, {.form = Form::Normal, .linear_solver = LinearSolver::General}).forms));
    for (std::size_t slot = 0; slot < slots; ++slot) {
      Case solved(system, {.form = Form::Normal, .linear_solver = LinearSolver::General});
      Tampering::corrupt_slot(Tampering::S(solved.forms), slot, 1e-6);
      EXPECT_FALSE(solved.certify().passed()) << "slot " << slot;
    }
  }
}

/// Makes `pieces` bent chains beside each other, of `rods` rods each. They are closed if `close`.
System make_pieces(int pieces, int rods, bool close) {
  System system;
  Rods group{"rods", {}, {}, {}};
  for (int piece = 0; piece < pieces; ++piece) {
    const auto first = static_cast<Index>(system.num_points());
    const int points = close ? rods : rods + 1;
    for (int k = 0; k < points; ++k) {
      const double angle = 2.0 * M_PI * k / (close ? rods : 2 * rods);
      system.positions.insert(system.positions.end(),
                              {3.0 * piece + std::cos(angle), std::sin(angle) + 0.1 * k, 0.3 * std::sin(3.0 * angle)});
      system.masses.push_back(1.0 + 0.1 * k);
    }
    for (int k = 0; k < rods; ++k) group.pairs.push_back({first + k, first + (k + 1) % points});
  }
  system.velocities.assign(system.positions.size(), 0.0);
  system.constraints = {group};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}, Springs{"spring", {{0, 2}}, 5.0, 0.2, 0.5}};
  return system;
}

/// Makes three branches of two rods at one bead.
System make_tree() {
  System system = make_pieces(1, 6, false);
  std::get<Rods>(system.constraints[0]).pairs = {{0, 1}, {1, 2}, {0, 3}, {3, 4}, {0, 5}, {5, 6}};
  return system;
}

/// Every linear solver has a factor of its own (but the closed form, which reads K itself), and each point takes part
/// in it.
TEST(TamperedCertificate, FindsEveryCorruptedEliminationOfEachLinearSolver) {
  struct Eliminated {
    const char* solver;
    System system;
    LinearSolver wanted = LinearSolver::Auto;
  };
  const Eliminated all[] = {{"paths", make_pieces(1, 12, false), LinearSolver::Paths},
                            {"paths", make_pieces(1, 9, true), LinearSolver::Paths},
                            {"batches", make_pieces(3, 3, true), LinearSolver::Batches},
                            {"trees", make_tree(), LinearSolver::Trees}};
  for (const auto& [solver, system, wanted] : all) {
    std::size_t points = 0;
    for (std::size_t point = 0; point < system.num_points(); ++point) {
      Case solved(system, {.linear_solver = wanted});
      ASSERT_EQ(solved.forms.plan.linear_solver(), solver);
      EXPECT_TRUE(solved.certify().passed()) << solver;
      ASSERT_TRUE(Tampering::corrupt_elimination(solved.forms, solved.r, point, {4e-6, -7e-6, 5e-6}));
      EXPECT_FALSE(solved.certify().passed()) << solver << ", point " << point;
      ++points;
    }
    EXPECT_GT(points, 2u) << solver;
  }
}

TEST(TamperedCertificate, FindsEveryCorruptedSlotOfH) {
  for (const System& system : {only_coordinates(), make_chain_with_coordinates()}) {
    const std::size_t slots = Tampering::num_slots(Tampering::H(Case(system, {.form = Form::Tangent}).forms));
    for (std::size_t slot = 0; slot < slots; ++slot) {
      Case solved(system, {.form = Form::Tangent});
      Tampering::corrupt_slot(Tampering::H(solved.forms), slot, 1e-6);
      EXPECT_FALSE(solved.certify().passed()) << "slot " << slot;
    }
  }
}

TEST(TamperedCertificate, FindsEveryCorruptedNumberOfK) {
  const std::size_t numbers = Tampering::K(Case(make_driven_chain()).forms).size();
  for (std::size_t k = 0; k < numbers; ++k) {
    Case solved(make_driven_chain());
    Tampering::K(solved.forms)[k] += 1e-6;
    Tampering::refactorize(solved.forms);
    EXPECT_FALSE(solved.certify().passed()) << "number " << k;
  }
}

TEST(TamperedCertificate, FindsEveryCorruptedRowOfPhiAndNamesIt) {
  for (std::size_t a = 0; a < 4; ++a) {
    Case solved(make_driven_chain());
    // The effect of a wrong phi on the answer is S dlambda = -dphi and dw = M^-1 K dlambda.
    Workspace& work = solved.forms.work;
    const Model& model = solved.forms.model;
    std::vector<double> rows(model.num_rows(), 0.0), change(solved.w.size(), 0.0);
    rows[a] = 1e-6;
    solved.forms.normal->linearization().solve_negative(rows.data(), rows.data());
    model.gather.add_scaled(model.parallel, Tampering::K(solved.forms).data(), rows.data(), model.inverse_mass.data(),
                            model.num_moving(), change.data());
    for (std::size_t i = 0; i < change.size(); ++i) {
      solved.w[i] += change[i];
      solved.eta[i] += model.mass[i / 3] * change[i];
    }
    for (std::size_t b = 0; b < rows.size(); ++b) solved.lambda[b] += rows[b];

    const Certificate certificate = solved.certify();

    EXPECT_EQ(failed(certificate), "K'w + phi = 0");
    EXPECT_NE(certificate.line().find(work.name_row(a)), std::string::npos) << certificate.line();
  }
}

/// A kind without a hand-written kernel runs on its own definition, and so does the certificate, in another arithmetic
/// and from the system, so that an error on the way shows.
TEST(TamperedCertificate, FindsAKernelThatSpoilsADefinition) {
  System system;
  system.positions = {0.5, 0.0, 0.0};
  system.masses = {1.0};
  system.velocities = {0.0, 2.0 * M_PI * 0.5, 0.6};  // a turn a second
  system.constraints = {Helices{"wire", {0}, {}, {0.0, 0.0, 1.0}, 0.5, 0.6, 0.0}};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  EXPECT_TRUE(Case(system).certify().passed()) << Case(system).certify().line();

  Case along(system), around(system);
  Tampering::along_helix(along.forms).e2.y *= 1.001;     // this changes phi alone, for y is 0 and y_dot is not
  Tampering::around_helix(around.forms).turns *= 1.001;  // this changes K
  along.solve();
  around.solve();

  EXPECT_EQ(failed(along.certify()), "K'w + phi = 0");
  EXPECT_TRUE(fails(around.certify(), "M w = f + K lambda")) << around.certify().line();
}

TEST(TamperedCertificate, FindsACorruptedPsi) {
  Case solved(only_coordinates());
  // w = A q_ddot + psi keeps A'(M w - f) = 0 for any psi, so that only the curve itself detects the error.
  for (std::size_t i = 0; i < 9; ++i) {
    Case wrong(only_coordinates());
    Workspace& work = wrong.forms.work;
    const Model& model = wrong.forms.model;
    std::vector<double> force(wrong.w.size(), 0.0), x(work.coordinates.num_coordinates()), change(wrong.w.size(), 0.0);
    // dw = (I - A H^-1 A'M) dpsi
    force[i] = model.mass[i / 3] * 1e-3;
    const std::vector<double>& A = wrong.forms.tangent->dynamics().blocks();
    work.coordinates.apply_transposed(model.parallel, A.data(), force.data(), x.data());
    wrong.forms.tangent->dynamics().completed().solve_negative(x.data());
    work.coordinates.apply(model.parallel, A.data(), x.data(), change.data());
    change[i] += 1e-3;
    for (std::size_t k = 0; k < 9; ++k) wrong.w[k] += change[k];

    EXPECT_EQ(failed(wrong.certify()), "w = d2/dt2 r(q(t), t)") << i;
  }
}

TEST(TamperedCertificate, Equations9And10FindEachSlotOfSAndOfH) {
  const System system = make_chain_with_coordinates();
  for (const char* equation : {"(9)", "(10)"}) {
    // The form that steps keeps its factor, and the other one is made afresh.
    for (std::size_t slot = 0;
         slot < Tampering::num_slots(Tampering::S(Case(system, {.linear_solver = LinearSolver::General}).forms));
         ++slot) {
      Case solved(system, {.form = Form::Normal, .linear_solver = LinearSolver::General});
      EXPECT_FALSE(fails(solved.certify(), equation));
      Tampering::corrupt_slot(Tampering::S(solved.forms), slot, 1e-6);
      EXPECT_TRUE(fails(solved.certify(), equation)) << "S " << slot;
    }
    for (std::size_t slot = 0; slot < Tampering::num_slots(Tampering::H(Case(system).forms)); ++slot) {
      Case solved(system, {.form = Form::Tangent});
      Tampering::corrupt_slot(Tampering::H(solved.forms), slot, 1e-6);
      EXPECT_TRUE(fails(solved.certify(), equation)) << "H " << slot;
    }
  }
}

}  // namespace
}  // namespace tanor
