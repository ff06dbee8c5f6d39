#include "friction/contact_coupling.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "friction/instant_of_contacts.hpp"

namespace tanor {
using namespace detail;
namespace {

System draw_beads(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  std::vector<Vector3> positions, directions;
  const std::size_t count = 2 + seed % 4;
  for (std::size_t i = 0; i < count; ++i) {
    positions.push_back({2.0 * static_cast<double>(i), draw(random), draw(random)});
    const Vector3 d{draw(random), draw(random), 1.5 + draw(random)};
    const double length = std::hypot(d[0], d[1], d[2]);
    directions.push_back({d[0] / length, d[1] / length, d[2] / length});
  }
  return make_beads_on_lines(positions, directions, 0.4);
}

/// Draws random sizes x of friction, with its forces tau, and b = K'M^-1 tau by dense products.
struct DrawnFriction {
  DrawnFriction(unsigned seed, InstantOfContacts& at)
      : laws(at.model.system, at.model.numbering, at.work.constraints.tangents(), at.model.incidences),
        coupling(at.work, laws),
        x(laws.num_parts()),
        tau(3 * at.work.constraints.tangents().size()) {
    laws.set_state(at.model.parallel, 0.0, at.r.data(), at.v.data(), at.blocks.data());
    coupling.set_place(at.blocks.data());
    std::mt19937 random(seed + 100);
    std::uniform_real_distribution<double> size(0.5, 5.0);
    for (double& each : x) each = size(random);
    laws.write_forces(x.data(), tau.data());
    Eigen::VectorXd at_points = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(at.r.size()));
    const Tangents& tangents = at.work.constraints.tangents();
    for (std::size_t c = 0; c < tangents.size(); ++c)
      at_points.segment<3>(3 * tangents[c].point) += Eigen::Map<const Eigen::Vector3d>(tau.data() + 3 * c);
    w = at.inverse_mass().cwiseProduct(at_points);
    rows = at.K().transpose() * w;
  }

  FrictionLaws laws;
  ContactCoupling coupling;
  std::vector<double> x, tau;
  Eigen::VectorXd w, rows;  // by dense products
};

TEST(ContactCoupling, AddsTheDenseProductOfGradientsAndFrictionToRows) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    InstantOfContacts at(draw_beads(seed));
    const DrawnFriction drawn(seed, at);

    std::vector<double> rows(at.b.size(), 1.0);
    drawn.coupling.add_to_rows(-2.0, drawn.x.data(), rows.data());

    for (std::size_t a = 0; a < rows.size(); ++a)
      EXPECT_NEAR(rows[a], 1.0 - 2.0 * drawn.rows(static_cast<Eigen::Index>(a)), 1e-13 * drawn.rows.norm()) << seed;
  }
}

TEST(ContactCoupling, WritesTouchedRowsAloneAndKnowsThem) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    InstantOfContacts at(draw_beads(seed));
    const DrawnFriction drawn(seed, at);
    const ContactCoupling& coupling = drawn.coupling;

    std::vector<double> base(coupling.num_touched_rows()), sum(at.b), change(at.b.size(), 0.0);
    coupling.gather(at.b.data(), base.data());
    coupling.write(base.data(), drawn.x.data(), sum.data());
    coupling.write(nullptr, drawn.x.data(), change.data());

    EXPECT_LT(coupling.num_touched_rows(), at.b.size());  // guides do not feel friction along them
    for (std::size_t a = 0; a < sum.size(); ++a) {
      const double dense = drawn.rows(static_cast<Eigen::Index>(a)), allowed = 1e-13 * drawn.rows.norm();
      EXPECT_NEAR(sum[a], at.b[a] + dense, allowed + 1e-14 * std::abs(at.b[a])) << seed;
      EXPECT_NEAR(change[a], dense, allowed) << seed;
    }
  }
}

TEST(ContactCoupling, AddsAccelerationsOfFrictionAndOfItsChange) {
  InstantOfContacts at(draw_beads(3));
  const DrawnFriction drawn(3, at);
  std::vector<double> before(drawn.tau);
  for (double& each : before) each *= 0.25;

  std::vector<double> w(at.r.size(), 0.0), change(w);
  drawn.coupling.add_to_points(1.0, drawn.tau.data(), w.data());
  drawn.coupling.add_change(2.0, drawn.tau.data(), before.data(), change.data());

  for (std::size_t i = 0; i < w.size(); ++i) {
    EXPECT_NEAR(w[i], drawn.w(static_cast<Eigen::Index>(i)), 1e-14 * drawn.w.norm());
    EXPECT_NEAR(change[i], 1.5 * drawn.w(static_cast<Eigen::Index>(i)), 1e-14 * drawn.w.norm());
  }
}

TEST(ContactCoupling, AddsOneForceAtAContact) {
  InstantOfContacts at(draw_beads(5));
  const DrawnFriction drawn(5, at);
  const Tangents& tangents = at.work.constraints.tangents();
  const Vec3 force = 3.0 * tangents.directions(1)[0];

  std::vector<double> rows(at.b.size(), 0.0);
  drawn.coupling.add_force(1, force, rows.data());

  Eigen::VectorXd at_points = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(at.r.size()));
  at_points.segment<3>(3 * tangents[1].point) << force.x, force.y, force.z;
  const Eigen::VectorXd dense = at.K().transpose() * at.inverse_mass().cwiseProduct(at_points);
  EXPECT_GT(dense.norm(), 0.1);
  for (std::size_t a = 0; a < rows.size(); ++a)
    EXPECT_NEAR(rows[a], dense(static_cast<Eigen::Index>(a)), 1e-13 * dense.norm());
}

}  // namespace
}  // namespace tanor
