/// Energies of tuples: digits of a table made with 90 digits, the definition on numbers with derivatives, and threads.

#include <fstream>
#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <tanor/user_kernel.hpp>

#include "evaluate/forces.hpp"
#include "system/numbering.hpp"

namespace tanor {
namespace {

using Json = nlohmann::json;

double number(const Json& text) {
  return std::stod(text.get<std::string>());
}

Json read_table() {
  return Json::parse(std::ifstream(std::string(TANOR_SOURCE_DIR) + "/tests/evaluate/reference/potential_table.json"));
}

/// The law of a row of the table; nothing for laws of pairs.
std::optional<Force> make_law(const Json& row) {
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
  return {};
}

std::vector<double> flatten(const Json& rows) {
  std::vector<double> result;
  for (const Json& row : rows)
    for (const Json& text : row) result.push_back(number(text));
  return result;
}

/// What the system's one energy does: U, f, and the Hessian times a direction.
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
  // A compliant spring at tau = 0 has no derivative of its own: the definition's is compared instead.
  const auto has_spring = !couplings.empty();
  if (!has_spring)
    forces.evaluate_derivatives(serial, 0.0, r.data(), v.data(), nullptr,
                                {own.data(), own_v.data(), coupling.data(), coupling_v.data(), other.data()});
  const auto user = [&](int inner) {
    return static_cast<std::size_t>(numbering.user_point[static_cast<std::size_t>(inner)]);
  };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t u = user(static_cast<int>(i));
    store(answer.force.data(), u, load(f.data(), i));
    store(answer.hessian_times_direction.data(), u, -(own[i] * load(direction.data(), u)));
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
    const auto law = make_law(row);
    if (!law) continue;
    ++num_laws;
    const std::string name = row.at("potential");
    const Answer answer = evaluate(*law, positions, direction);
    std::vector<double> force = flatten(row.at("force")), product = flatten(row.at("hessian_times_direction"));
    const double energy = number(row.at("energy"));
    EXPECT_NEAR(answer.energy, energy, 1e-13 * std::abs(energy)) << name;
    for (std::size_t i = 0; i < force.size(); ++i)
      EXPECT_NEAR(answer.force[i], force[i], 1e-13 * largest(force)) << name << " " << i;
    if (name == "harmonic bond") continue;
    for (std::size_t i = 0; i < product.size(); ++i)
      EXPECT_NEAR(answer.hessian_times_direction[i], product[i], 1e-13 * largest(product)) << name << " " << i;
  }
  EXPECT_EQ(num_laws, 10);
}

/// pi - theta and the force keep their digits through the straight angle.
TEST(PotentialTableTest, HarmonicBendingIsSmoothWhereItIsStraight) {
  const double pi = 3.14159265358979323846;
  for (const Json& row : read_table().at("straight").at("rows")) {
    const double eps = number(row.at("y3_over_l"));
    const Answer answer = evaluate(Bendings{"", {{0, 1, 2}}, BendingLaw::Harmonic, 520.0, pi},
                                   {0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.2, 0.1 * eps, 0.0}, std::vector<double>(9, 1.0));
    const std::vector<double> force = flatten(row.at("force"));
    const double energy = number(row.at("energy"));
    // The places themselves are rounded to 1e-17 m, an angle of 1e-16.
    EXPECT_NEAR(answer.energy, energy, 1e-13 * energy + 520.0 * 2e-16 * eps) << eps;
    for (std::size_t i = 0; i < 9; ++i)
      EXPECT_NEAR(answer.force[i], force[i], 1e-13 * largest(force) + 520.0 * 1e-15 / 0.1) << eps << " " << i;
  }
}

/// The expression, backwards, against numbers with derivatives; a callable and the text of the same energy.
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
