/// Energies of tuples agree with a table made with 90 digits, with the definition on dual numbers, and for all thread
/// counts.

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <tanor/user_kernel.hpp>

#include "evaluate/forces.hpp"
#include "system/numbering.hpp"

namespace tanor {
using namespace detail;
namespace {

using Json = nlohmann::json;

double number(const Json& text) {
  return std::stod(text.get<std::string>());
}

Json read_table() {
  return Json::parse(std::ifstream(std::string(TANOR_SOURCE_DIR) + "/tests/evaluate/reference/potential_table.json"));
}

/// Makes the law of a row of the table.
Force make_law(const Json& row) {
  const std::string law = row.at("potential");
  const Json& given = row.at("parameters");
  const auto p = [&](const char* name) { return number(given.at(name)); };
  if (law == "harmonic bond") return Bonds{"", {{0, 1}}, BondLaw::Harmonic, p("k"), p("r0"), {}, {}, {}};
  if (law == "fene") return Bonds{"", {{0, 1}}, BondLaw::Fene, p("k"), {}, p("R0"), {}, {}};
  if (law == "morse") return Bonds{"", {{0, 1}}, BondLaw::Morse, {}, p("r0"), {}, p("D"), p("a")};
  if (law == "harmonic angle") return Bendings{"", {{0, 1, 2}}, BendingLaw::Harmonic, p("k"), p("theta0")};
  if (law == "cosine-harmonic angle") return Bendings{"", {{0, 1, 2}}, BendingLaw::CosineHarmonic, p("k"), p("theta0")};
  if (law == "cosine bending (worm-like)") return Bendings{"", {{0, 1, 2}}, BendingLaw::Cosine, p("k"), {}};
  if (law == "opls")
    return Torsions{"", {{0, 1, 2, 3}}, TorsionLaw::Opls, {p("k1"), p("k2"), p("k3"), p("k4")}, {}, 1, {}, {}};
  if (law == "multi (Ryckaert-Bellemans)") {
    Torsions torsions{"", {{0, 1, 2, 3}}, TorsionLaw::Multi, {}, {}, 1, {}, {}};
    for (const Json& c : given.at("c")) torsions.coefficients.push_back(number(c));
    return torsions;
  }
  if (law == "periodic (charmm) dihedral")
    return Torsions{"", {{0, 1, 2, 3}}, TorsionLaw::Periodic, {}, p("k"), given.at("n").get<int>(), p("phi0"), {}};
  if (law == "harmonic dihedral (improper)")
    return Torsions{"", {{0, 1, 2, 3}}, TorsionLaw::Harmonic, {}, p("k"), 1, {}, p("phi0")};
  if (law == "coulomb")
    return PairForces{
        .points = {0, 1}, .law = PairLaw::Coulomb, .strength = p("strength"), .charges = {p("q1"), p("q2")}};
  EXPECT_EQ(law, "yukawa");
  return PairForces{.points = {0, 1}, .law = PairLaw::Yukawa, .strength = p("strength"), .length = p("length")};
}

std::vector<double> flatten(const Json& rows) {
  std::vector<double> result;
  for (const Json& row : rows)
    for (const Json& text : row) result.push_back(number(text));
  return result;
}

/// The results of the system's one energy, which are U, f, and the Hessian times a direction.
struct Answer {
  double energy;
  std::vector<double> force, hessian_times_direction;
};

Answer evaluate(const Force& law, const std::vector<double>& positions, const std::vector<double>& direction) {
  const std::size_t n = positions.size() / 3;
  const System system{.positions = positions, .masses = std::vector<double>(n, 1.0), .forces = {law}};
  const Numbering numbering = tanor::number(system);
  Forces forces(system, numbering);
  const Parallel serial(1);
  std::vector<double> r(3 * n), v(3 * n, 0.0), f(3 * n);
  numbering.gather_points(positions, r);
  forces.evaluate(serial, 0.0, r.data(), v.data(), f.data());
  const std::vector<Influence> influences = forces.list_influences();
  const std::vector<Coupling> couplings = forces.list_couplings();
  std::vector<Block3> own(n), own_v(n), coupling(couplings.size()), coupling_v(couplings.size()),
      other(influences.size());
  Answer answer{forces.potential(serial, 0.0, r.data()), std::vector<double>(3 * n), std::vector<double>(3 * n)};
  // A spring is a rod that gives way. tau = -k (L - rest) is an unknown of its own, whose derivative is -k u'.
  const std::vector<Spring> springs = forces.springs().list_compliant();
  std::vector<double> units(3 * springs.size()), tau(springs.size(), 0.0), residuals(springs.size());
  forces.springs().evaluate_compliant(serial, r.data(), v.data(), tau.data(), units.data(), residuals.data());
  for (std::size_t k = 0; k < springs.size(); ++k) tau[k] = -residuals[k];
  forces.evaluate_derivatives(serial, 0.0, r.data(), v.data(), tau.data(),
                              {own.data(), own_v.data(), coupling.data(), coupling_v.data(), other.data()});
  for (std::size_t k = 0; k < springs.size(); ++k)
    coupling[k].add_product(-springs[k].stiffness, load(units.data(), k), load(units.data(), k));
  const auto user = [&](int inner) {
    return static_cast<std::size_t>(numbering.user_point[static_cast<std::size_t>(inner)]);
  };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t u = user(static_cast<int>(i));
    store(answer.force.data(), u, load(f.data(), i));
    store(answer.hessian_times_direction.data(), u, -(own[i] * load(direction.data(), u)));
  }
  for (std::size_t k = 0; k < couplings.size(); ++k) {
    const std::size_t i = user(couplings[k].i), j = user(couplings[k].j);
    const Vec3 change = coupling[k] * (load(direction.data(), j) - load(direction.data(), i));
    add_to(answer.hessian_times_direction.data(), j, -change);
    add_to(answer.hessian_times_direction.data(), i, change);
  }
  for (std::size_t k = 0; k < influences.size(); ++k) {
    const std::size_t on = user(influences[k].on);
    store(answer.hessian_times_direction.data(), on,
          load(answer.hessian_times_direction.data(), on) - other[k] * load(direction.data(), user(influences[k].of)));
  }
  return answer;
}

double largest(const std::vector<double>& x) {
  double result = 0.0;
  for (const double each : x) result = std::max(result, std::abs(each));
  return result;
}

TEST(PotentialTableTest, EnergiesForcesAndHessiansHaveThirteenDigits) {
  const Json table = read_table();
  const std::vector<double> positions = flatten(table.at("positions")), direction = flatten(table.at("direction"));
  int num_laws = 0;
  for (const Json& row : table.at("table")) {
    ++num_laws;
    const std::string name = row.at("potential");
    const Answer answer = evaluate(make_law(row), positions, direction);
    std::vector<double> force = flatten(row.at("force")), product = flatten(row.at("hessian_times_direction"));
    const double energy = number(row.at("energy"));
    EXPECT_NEAR(answer.energy, energy, 1e-13 * std::abs(energy)) << name;
    for (std::size_t i = 0; i < force.size(); ++i)
      EXPECT_NEAR(answer.force[i], force[i], 1e-13 * largest(force)) << name << " " << i;
    for (std::size_t i = 0; i < product.size(); ++i)
      EXPECT_NEAR(answer.hessian_times_direction[i], product[i], 1e-13 * largest(product)) << name << " " << i;
  }
  EXPECT_EQ(num_laws, 12);
}

/// pi - theta and the force keep their digits through the straight angle.
TEST(PotentialTableTest, HarmonicBendingIsSmoothWhereItIsStraight) {
  const double pi = 3.14159265358979323846;
  const Json table = read_table();
  for (const Json& row : table.at("straight").at("rows")) {
    const double eps = number(row.at("y3_over_l"));
    const Answer answer = evaluate(Bendings{"", {{0, 1, 2}}, BendingLaw::Harmonic, 520.0, pi},
                                   {0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.2, 0.1 * eps, 0.0}, std::vector<double>(9, 1.0));
    const std::vector<double> force = flatten(row.at("force"));
    const double energy = number(row.at("energy"));
    // The places themselves are rounded to 1e-17 m, which is an angle of 1e-16.
    EXPECT_NEAR(answer.energy, energy, 1e-13 * energy + 520.0 * 2e-16 * (eps + 1e-16)) << eps;
    for (std::size_t i = 0; i < 9; ++i)
      EXPECT_NEAR(answer.force[i], force[i], 1e-13 * largest(force) + 520.0 * 1e-15 / 0.1) << eps << " " << i;
  }
}

/// The expression is differentiated backwards. It agrees with numbers that carry derivatives, as a callable and as the
/// text of the same energy.
TEST(PotentialKernelTest, ExpressionAndDefinitionAgree) {
  const auto callable = make_potential_kernel<2>([](const auto& a, const auto& b, const auto& t) {
    using std::sqrt, std::atan2;
    const auto x = a[0] - b[0], y = a[1] - 2.0 * b[2];
    return sqrt(x * x + y * y + 1.0) * (1.0 + 0.1 * t) + atan2(a[2], 2.0 + b[1] * b[1]);
  });
  const auto text = formula_potential("sqrt((x1-x2)^2 + (y1-2*z2)^2 + 1)*(1 + 0.1*t) + atan2(z1, 2 + y2^2)", 2);
  const std::vector<double> r{0.3, -0.8, 0.4, 0.9, 0.2, -0.5};
  std::vector<double> gradients[2], hessians[2];
  double energies[2], rates[2];
  const PotentialKernel* const kernels[] = {&callable, &text};
  for (int k = 0; k < 2; ++k) {
    gradients[k].resize(6);
    hessians[k].resize(36);
    kernels[k]->evaluate(kernels[k]->context.get(),
                         {1, 0.7, r.data(), nullptr, &energies[k], gradients[k].data(), hessians[k].data(), &rates[k]});
  }
  EXPECT_NEAR(energies[0], energies[1], 1e-15);
  EXPECT_NEAR(rates[0], rates[1], 1e-16);
  const System system{.positions = r, .masses = {1.0, 1.0}, .forces = {Potential{"", {{0, 1}}, text, {}}}};
  const Numbering numbering = tanor::number(system);
  const PotentialFamily family(make_energy_group(system, std::get<Potential>(system.forces[0])), numbering);
  std::vector<double> inner(6), forces(6), rate(1);
  numbering.gather_points(r, inner);
  std::vector<Block3> blocks(4);
  family.evaluate_forces(Parallel(1), 0.7, inner.data(), forces.data(), rate.data());
  family.evaluate_stiffness(Parallel(1), 0.7, inner.data(), blocks.data());
  EXPECT_NEAR(rate[0], rates[0], 1e-15);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(gradients[0][i], gradients[1][i], 2e-15);
    EXPECT_NEAR(-forces[i], gradients[1][i], 2e-15);
    for (std::size_t j = 0; j < 6; ++j) {
      EXPECT_NEAR(hessians[0][6 * i + j], hessians[1][6 * i + j], 5e-15);
      EXPECT_NEAR(-blocks[2 * (i / 3) + j / 3](static_cast<int>(i % 3), static_cast<int>(j % 3)),
                  hessians[1][6 * i + j], 5e-15);
    }
  }
}

/// Expects that kernels by hand and by definition agree on tuples in a zigzag of random steps, which have parameters of
/// their own where the law reads them.
template <class Group>
void expect_hand_and_definition_to_agree(Group group, double bound) {
  constexpr Index n = 45;  // five packs of eight and a rest, in a row and not
  constexpr int p = points_of_member<Group>();
  System system;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-0.2, 0.2);
  for (Index i = 0; i < n; ++i)
    system.positions.insert(system.positions.end(),
                            {0.7 * i + uniform(random), 0.6 * (i % 2) + uniform(random), uniform(random)});
  system.masses.assign(n, 1.0);
  auto& members = group.*KindOf<Group>::members;
  for (Index i = 0; i + p <= n; ++i) {
    auto& member = members.emplace_back();
    for (int k = 0; k < p; ++k) member[static_cast<std::size_t>(k)] = i + k;
  }
  std::swap(members[3], members[20]);
  const Numbering numbering = tanor::number(system);
  const EnergyGroup energies = make_energy_group(system, group);
  ASSERT_TRUE(static_cast<bool>(energies.by_hand));
  const PotentialFamily family(energies, numbering);
  const std::size_t size = members.size(), width = 3 * p;
  std::vector<double> r(3 * n), forces(width * size), found(size), rates(size), places, energy(size),
      gradient(width * size);
  numbering.gather_points(system.positions, r);
  family.evaluate_forces(Parallel(1), 0.0, r.data(), forces.data(), rates.data());
  family.evaluate_energies(Parallel(1), 0.0, r.data(), found.data());
  for (const Index point : energies.points)
    for (std::size_t axis = 0; axis < 3; ++axis) places.push_back(system.positions[3 * point + axis]);
  energies.kernel.evaluate(energies.kernel.context.get(), {size, 0.0, places.data(), energies.constants.data(),
                                                           energy.data(), gradient.data(), nullptr, nullptr});
  const double scale = largest(gradient);
  for (std::size_t k = 0; k < size; ++k) {
    EXPECT_NEAR(found[k], energy[k], bound * largest(energy)) << k;
    for (std::size_t i = 0; i < width; ++i)
      EXPECT_NEAR(forces[3 * (i / 3 * size + k) + i % 3], -gradient[k * width + i], bound * scale) << k << " " << i;
  }
}

TEST(EnergyKernelTest, BondsByHandAreThoseOfTheDefinition) {
  Parameter each;
  for (int k = 0; k < 44; ++k) each.constants.push_back(1.0 + 0.1 * k);
  expect_hand_and_definition_to_agree(Bonds{.law = BondLaw::Fene, .stiffness = each, .limit = 1.9}, 1e-13);
  expect_hand_and_definition_to_agree(Bonds{.law = BondLaw::Morse, .rest_length = 0.8, .depth = each, .width = 2.0},
                                      1e-13);
  expect_hand_and_definition_to_agree(Bonds{.stiffness = each, .rest_length = 0.9}, 1e-13);
}

TEST(EnergyKernelTest, BendingsByHandAreThoseOfTheDefinition) {
  Parameter each;
  for (int k = 0; k < 43; ++k) each.constants.push_back(1.0 + 0.1 * k);
  for (const BendingLaw law : {BendingLaw::Harmonic, BendingLaw::CosineHarmonic, BendingLaw::Cosine})
    expect_hand_and_definition_to_agree(Bendings{.law = law, .stiffness = each, .rest = 1.9}, 1e-13);
  expect_hand_and_definition_to_agree(Bendings{.stiffness = each, .rest = KindOf<Bendings>::pi}, 1e-12);
}

TEST(EnergyKernelTest, TorsionsByHandAreThoseOfTheDefinition) {
  Parameter each;
  for (int k = 0; k < 42; ++k) each.constants.push_back(1.0 + 0.1 * k);
  expect_hand_and_definition_to_agree(Torsions{.law = TorsionLaw::Opls, .coefficients = {1.0, -2.0, 3.0, 0.7}}, 1e-12);
  expect_hand_and_definition_to_agree(Torsions{.law = TorsionLaw::Multi, .coefficients = {1.0, -2.0, 3.0, 0.7, 2.0}},
                                      1e-12);
  for (const int multiplicity : {0, 1, 5})
    expect_hand_and_definition_to_agree(
        Torsions{.law = TorsionLaw::Periodic, .stiffness = each, .multiplicity = multiplicity, .phase = 0.4}, 1e-12);
  expect_hand_and_definition_to_agree(Torsions{.law = TorsionLaw::Harmonic, .stiffness = each, .rest = 2.8}, 1e-12);
}

/// A tuple beyond the end of its law is named, and its force is no number.
TEST(EnergyKernelTest, UndefinedTuplesAreNamed) {
  const auto find = [](const Force& force, const std::vector<double>& positions) {
    const System system{
        .positions = positions, .masses = std::vector<double>(positions.size() / 3, 1.0), .forces = {force}};
    const Numbering numbering = tanor::number(system);
    Forces forces(system, numbering);
    std::vector<double> r(positions.size()), v(r.size()), f(r.size());
    numbering.gather_points(positions, r);
    forces.evaluate(Parallel(1), 0.0, r.data(), v.data(), f.data());
    EXPECT_TRUE(std::ranges::any_of(f, [](double x) { return std::isnan(x); }));
    return forces.energies().find_undefined(Parallel(1), 0.0, r.data());
  };
  const std::vector<double> line{0, 0, 0, 1, 0, 0, 2, 0, 0, 2, 1, 0};

  EXPECT_EQ(find(Bonds{"fene", {{0, 1}, {0, 2}}, BondLaw::Fene, 1.0, {}, 1.5, {}, {}}, line),
            "fene: [0, 2]: the distance 2 is not below the limit 1.5");
  EXPECT_EQ(find(Bendings{"", {{0, 1, 2}}, BendingLaw::Harmonic, 1.0, 2.0}, line),
            "bending0: [0, 1, 2]: its angle is straight, where the force of law harmonic has no direction unless all "
            "rest at pi");
  EXPECT_EQ(find(Torsions{"", {{0, 1, 2, 3}}, TorsionLaw::Opls, {1, 0, 0, 0}, {}, 1, {}, {}}, line),
            "torsion0: [0, 1, 2, 3]: its first three points are on a straight line: there is no dihedral");
  EXPECT_EQ(find(Potential{"u", {{0, 1}}, formula_potential("log(x1 - x2)", 2), {}}, line),
            "u: [0, 1]: the energy or its gradient is not finite");
}

/// Returns the eigenvalues of a symmetric matrix in ascending order, by Jacobi's rotations.
std::vector<double> eigenvalues(std::vector<std::vector<double>> a) {
  const std::size_t n = a.size();
  for (int sweep = 0; sweep < 30; ++sweep) {
    for (std::size_t p = 0; p < n; ++p) {
      for (std::size_t q = p + 1; q < n; ++q) {
        const double angle = 0.5 * std::atan2(2.0 * a[p][q], a[q][q] - a[p][p]), c = std::cos(angle),
                     s = std::sin(angle);
        for (std::size_t k = 0; k < n; ++k) {
          const double x = a[k][p], y = a[k][q];
          a[k][p] = c * x - s * y;
          a[k][q] = s * x + c * y;
        }
        for (std::size_t k = 0; k < n; ++k) {
          const double x = a[p][k], y = a[q][k];
          a[p][k] = c * x - s * y;
          a[q][k] = s * x + c * y;
        }
      }
    }
  }
  std::vector<double> result;
  for (std::size_t i = 0; i < n; ++i) result.push_back(a[i][i]);
  std::sort(result.begin(), result.end());
  return result;
}

/// In A3 a worm-like chain of ten rods is straight. Its Hessian and the tension give the frequencies across it.
TEST(PotentialTableTest, AStraightChainHasTheFrequenciesOfTheClosedForm) {
  const Json table = Json::parse(
      std::ifstream(std::string(TANOR_SOURCE_DIR) + "/tests/evaluate/reference/A3_bending_chain_modes.json"));
  const std::size_t n = 11;
  const double length = number(table.at("l")), mass = number(table.at("m")), kappa = number(table.at("kappa"));
  std::vector<double> positions;
  std::vector<std::array<Index, 3>> triples;
  for (std::size_t i = 0; i < n; ++i) {
    positions.insert(positions.end(), {length * static_cast<double>(i), 0.0, 0.0});
    if (i + 2 < n) triples.push_back({static_cast<Index>(i), static_cast<Index>(i + 1), static_cast<Index>(i + 2)});
  }
  const auto expect = [&](const Bendings& bendings, const char* key, std::size_t first, std::size_t last,
                          double tension, std::size_t num_zero) {
    std::vector<std::vector<double>> stiffness;
    for (std::size_t j = first; j < last; ++j) {
      std::vector<double> direction(3 * n, 0.0);
      direction[3 * j + 1] = 1.0;
      const std::vector<double> column = evaluate(bendings, positions, direction).hessian_times_direction;
      std::vector<double>& row = stiffness.emplace_back();
      for (std::size_t i = first; i < last; ++i) {
        const double of_tension = i == j ? 2.0 : i + 1 == j || j + 1 == i ? -1.0 : 0.0;
        row.push_back((column[3 * i + 1] + tension / length * of_tension) / mass);
      }
    }
    const std::vector<double> found = eigenvalues(stiffness);
    const double most = found.back();
    for (std::size_t k = 0; k < num_zero; ++k) EXPECT_LT(std::abs(found[k]), 1e-12 * most) << key;
    ASSERT_EQ(found.size(), num_zero + table.at(key).size());
    for (std::size_t k = num_zero; k < found.size(); ++k) {
      const double omega = number(table.at(key)[k - num_zero]);
      EXPECT_NEAR(found[k], omega * omega, 1e-10 * omega * omega + 1e-15 * most) << key << " " << k;
    }
  };
  for (const Bendings& bendings : {Bendings{"", triples, BendingLaw::Cosine, kappa, {}},
                                   Bendings{"", triples, BendingLaw::Harmonic, kappa, KindOf<Bendings>::pi}}) {
    expect(bendings, "hinged_closed_omega", 1, n - 1, 1.5, 0);
    expect(bendings, "clamped_omega", 2, n, 0.0, 0);
    expect(bendings, "free_omega", 0, n, 0.0, 2);
  }
}

TEST(PotentialTest, AnyNumberOfThreadsGivesTheSameBits) {
  constexpr Index n = 5003;
  System system;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-0.3, 0.3);
  Torsions torsions{"", {}, TorsionLaw::Opls, {1.0, 2.0, 3.0, 4.0}, {}, 1, {}, {}};
  for (Index i = 0; i < n; ++i) {
    system.positions.insert(system.positions.end(),
                            {0.5 * i + uniform(random), (i % 2) + uniform(random), uniform(random)});
    system.masses.push_back(1.0);
    if (i + 3 < n) torsions.quadruples.push_back({i, i + 1, i + 2, i + 3});
  }
  system.forces = {torsions};
  const Numbering numbering = tanor::number(system);
  Forces forces(system, numbering);
  std::vector<double> r(3 * n), v(3 * n, 0.0), one(3 * n), three(3 * n);
  numbering.gather_points(system.positions, r);
  forces.evaluate(Parallel(1), 0.0, r.data(), v.data(), one.data());
  forces.evaluate(Parallel(3), 0.0, r.data(), v.data(), three.data());
  EXPECT_EQ(one, three);
  EXPECT_EQ(forces.potential(Parallel(1), 0.0, r.data()), forces.potential(Parallel(3), 0.0, r.data()));
}

}  // namespace
}  // namespace tanor
