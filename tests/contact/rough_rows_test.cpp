/// Contacts that open, stick and slide at one instant, and their impacts, against an enumeration of all modes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <tanor/motion.hpp>

#include "dense.hpp"
#include "measures.hpp"

namespace tanor {
namespace {

/// Points on rods, some of which touch planes to one side with friction, each its own.
struct RoughScene {
  System system;
  Eigen::MatrixXd rods;                   ///< K' of what holds to both sides
  Eigen::MatrixXd normals, along, other;  ///< [contact] rows: n and the tangents
  Eigen::VectorXd inverse_mass, force, v;
  std::vector<double> mu;
  bool is_planar = false;

  Eigen::Index size() const { return inverse_mass.size(); }
  std::size_t contacts() const { return mu.size(); }
};

Eigen::VectorXd project(const Eigen::MatrixXd& K, const Eigen::VectorXd& inverse_mass, const Eigen::VectorXd& v) {
  if (K.rows() == 0) return v;
  const Eigen::MatrixXd S = K * inverse_mass.asDiagonal() * K.transpose();
  return v -
         inverse_mass.asDiagonal() * K.transpose() * reference::solve_least_squares(S, Eigen::VectorXd(K * v), 1e-11);
}

/// In a planar scene all points and normals are in the plane y = 0, so that contacts slide in two senses alone.
RoughScene make_scene(std::mt19937& generator, bool is_planar, double restitution) {
  std::uniform_real_distribution<double> number(-1.0, 1.0), positive(0.5, 2.0);
  const auto count = [&](int least, int most) { return std::uniform_int_distribution<int>(least, most)(generator); };
  RoughScene made;
  made.is_planar = is_planar;
  System& system = made.system;
  const int contacts = count(1, 6), points = contacts + count(0, 2);
  const Eigen::Index size = 3 * points;
  made.inverse_mass.resize(size);
  made.force.resize(size);
  for (int i = 0; i < points; ++i) {
    const Point point = system.add_point({{number(generator), is_planar ? 0.0 : number(generator), number(generator)}});
    system.masses[static_cast<std::size_t>(point.index)] = positive(generator);
    const Vector3 f{5.0 * number(generator), is_planar ? 0.0 : 5.0 * number(generator), 5.0 * number(generator) - 5.0};
    system.forces.push_back(ConstantForce{.points = {point.index}, .force = f});
    for (Eigen::Index c = 0; c < 3; ++c) {
      made.force[3 * i + c] = f[static_cast<std::size_t>(c)];
      made.inverse_mass[3 * i + c] = 1.0 / system.masses[static_cast<std::size_t>(point.index)];
    }
  }
  made.rods.resize(0, size);
  const auto add_row = [&](Eigen::MatrixXd* rows) {
    rows->conservativeResize(rows->rows() + 1, size);
    rows->row(rows->rows() - 1).setZero();
    return rows->row(rows->rows() - 1);
  };
  if (is_planar) {
    Planes flat{.normal = Vector3{0.0, 1.0, 0.0}};
    for (int i = 0; i < points; ++i) {
      flat.points.push_back(static_cast<Index>(i));
      add_row (&made.rods)(3 * i + 1) = 1.0;
    }
    system.constraints.push_back(flat);
  }
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < points; ++i)
    for (int j = i + 1; j < points; ++j) pairs.emplace_back(i, j);
  std::ranges::shuffle(pairs, generator);
  // As many rods as points can bear and keep two motions: a tree, and some more.
  const int free = (is_planar ? 2 : 3) * points - (is_planar ? 3 : 6);
  pairs.resize(static_cast<std::size_t>(
      std::min({count(0, 8), std::max(free, points > 1 ? 1 : 0), static_cast<int>(pairs.size())})));
  for (const auto& [i, j] : pairs) {
    system.constraints.push_back(Rods{.pairs = {{static_cast<Index>(i), static_cast<Index>(j)}}});
    const Eigen::Vector3d d =
        (reference::place(system.positions, j) - reference::place(system.positions, i)).normalized();
    auto row = add_row(&made.rods);
    row.segment<3>(3 * i) = -d.transpose();
    row.segment<3>(3 * j) = d.transpose();
  }
  for (int i = 0; i < contacts; ++i) {
    Eigen::Vector3d n(number(generator), is_planar ? 0.0 : number(generator), 0.3 + std::abs(number(generator)));
    n.normalize();
    const Eigen::Vector3d across = is_planar ? Eigen::Vector3d(0.0, 1.0, 0.0) : n.unitOrthogonal();
    const Eigen::Vector3d t = across.cross(n);
    const std::string name = "floor" + std::to_string(i);
    made.mu.push_back(0.8 * std::abs(number(generator)) + 0.02);
    system.constraints.push_back(Planes{.name = name,
                                        .points = {static_cast<Index>(i)},
                                        .normal = Vector3{n[0], n[1], n[2]},
                                        .offset = n.dot(reference::place(system.positions, i)),
                                        .side = OneSide::AtLeast,
                                        .restitution = restitution});
    system.friction.push_back(Coulomb{.at = {name}, .coefficient = made.mu.back()});
    add_row(&made.normals).segment<3>(3 * i) = n.transpose();
    add_row(&made.along).segment<3>(3 * i) = t.transpose();
    add_row(&made.other).segment<3>(3 * i) = across.transpose();
  }
  made.v = Eigen::VectorXd::Zero(size);
  return made;
}

/// Makes contacts slide: v with all normals at rest, or with `approach`, as rods allow it.
void set_velocities(std::mt19937& generator, bool approach, RoughScene* made) {
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (double& each : made->v) each = number(generator);
  Eigen::MatrixXd K = made->rods;
  if (!approach) {
    K.conservativeResize(K.rows() + made->normals.rows(), Eigen::NoChange);
    K.bottomRows(made->normals.rows()) = made->normals;
  }
  made->v = project(K, made->inverse_mass, made->v);
  made->system.velocities.assign(made->v.begin(), made->v.end());
}

/// u = W r + q with all but the contacts eliminated; components (n, t, s) of each contact.
struct Reduced {
  Eigen::MatrixXd H, W;  ///< rows of H: components
};
Reduced reduce(const RoughScene& made) {
  Reduced reduced;
  const auto m = static_cast<Eigen::Index>(made.contacts());
  reduced.H.resize(3 * m, made.size());
  for (Eigen::Index c = 0; c < m; ++c) {
    reduced.H.row(3 * c) = made.normals.row(c);
    reduced.H.row(3 * c + 1) = made.along.row(c);
    reduced.H.row(3 * c + 2) = made.other.row(c);
  }
  reduced.W.resize(3 * m, 3 * m);
  for (Eigen::Index k = 0; k < 3 * m; ++k) {
    const Eigen::VectorXd w = made.inverse_mass.cwiseProduct(reduced.H.row(k).transpose());
    reduced.W.col(k) = reduced.H * project(made.rods, made.inverse_mass, w);
  }
  return reduced;
}

/// Accelerations without contacts. The rods turn: K'w = -phi, |v_j - v_i|^2 across them over their length.
Eigen::VectorXd free_accelerations(const RoughScene& made) {
  Eigen::VectorXd w = made.inverse_mass.cwiseProduct(made.force), b = made.rods * w;
  Eigen::Index row = made.is_planar ? made.size() / 3 : 0;
  for (const Constraint& constraint : made.system.constraints) {
    const Rods* const rod = std::get_if<Rods>(&constraint);
    if (rod == nullptr) continue;
    const auto [i, j] = rod->pairs.front();
    const Eigen::Vector3d d = reference::place(made.system.positions, j) - reference::place(made.system.positions, i),
                          u = made.v.segment<3>(3 * j) - made.v.segment<3>(3 * i);
    b[row++] += (u.squaredNorm() - std::pow(u.dot(d.normalized()), 2)) / d.norm();
  }
  if (made.rods.rows() == 0) return w;
  const Eigen::MatrixXd S = made.rods * made.inverse_mass.asDiagonal() * made.rods.transpose();
  return w - made.inverse_mass.asDiagonal() * made.rods.transpose() * reference::solve_least_squares(S, b, 1e-11);
}

enum class Mode { Open, Stick, Slide, SlideBack };

struct Answer {
  std::vector<Mode> modes;
  Eigen::VectorXd r, u;
  double margin;  ///< the least distance to another mode
};

/// Lists all answers to u = W r + q by trying all modes. Contacts with a velocity `moving` (t, s) slide against it; the
/// others slide along t in two senses, as in a plane.
std::vector<Answer> enumerate(const Reduced& reduced, const Eigen::VectorXd& q, const std::vector<double>& mu,
                              const std::vector<Eigen::Vector2d>& moving) {
  const std::size_t m = mu.size();
  std::vector<Answer> answers;
  std::vector<int> digits(m, 0);
  const auto num_modes = [&](std::size_t c) { return moving[c].norm() > 1e-9 ? 2 : 4; };
  const double scale = q.lpNorm<Eigen::Infinity>() + 1e-300, force = scale / reduced.W.diagonal().maxCoeff();
  for (bool has_more = true; has_more;) {
    std::vector<Mode> modes(m);
    Eigen::MatrixXd B = Eigen::MatrixXd::Zero(q.size(), 0);
    std::vector<Eigen::Index> zero;
    const auto unknown = [&](Eigen::Index component) {
      zero.push_back(component);
      B.conservativeResize(Eigen::NoChange, B.cols() + 1);
      B.col(B.cols() - 1).setZero();
      B(component, B.cols() - 1) = 1.0;
    };
    for (std::size_t c = 0; c < m; ++c) {
      const Eigen::Index i = 3 * static_cast<Eigen::Index>(c);
      const bool moves = num_modes(c) == 2;
      modes[c] = moves && digits[c] == 1 ? Mode::Slide : static_cast<Mode>(digits[c]);
      if (modes[c] == Mode::Open) continue;
      unknown(i);
      if (moves)
        B.block<2, 1>(i + 1, B.cols() - 1) = -mu[c] / moving[c].norm() * moving[c];
      else if (modes[c] == Mode::Stick)
        unknown(i + 1);
      else
        B(i + 1, B.cols() - 1) = modes[c] == Mode::Slide ? -mu[c] : mu[c];
    }
    Answer answer{.modes = modes, .r = Eigen::VectorXd::Zero(q.size()), .u = {}, .margin = 1e300};
    if (!zero.empty()) {
      const Eigen::MatrixXd M = reduced.W(zero, Eigen::all) * B;
      answer.r = B * reference::solve_least_squares(M, Eigen::VectorXd(-q(zero)), 1e-12);
    }
    answer.u = q + reduced.W * answer.r;
    bool solves = true;
    for (const Eigen::Index i : zero) solves = solves && std::abs(answer.u(i)) <= 1e-9 * scale;
    for (std::size_t c = 0; c < m; ++c) {
      const Eigen::Index i = 3 * static_cast<Eigen::Index>(c);
      const double N = answer.r(i) / force, T = answer.r(i + 1) / force, a = answer.u(i + 1) / scale;
      if (modes[c] == Mode::Open) {
        answer.margin = std::min(answer.margin, answer.u(i) / scale);
        continue;
      }
      answer.margin = std::min(answer.margin, N);
      if (num_modes(c) == 2) continue;
      const double sense = modes[c] == Mode::Slide ? a : modes[c] == Mode::SlideBack ? -a : mu[c] * N - std::abs(T);
      answer.margin = std::min(answer.margin, sense);
    }
    const auto same = [&](const Answer& other) { return (other.u - answer.u).norm() <= 1e-7 * scale; };
    if (solves && answer.margin > -1e-9 && std::ranges::none_of(answers, same)) answers.push_back(answer);
    has_more = false;
    for (std::size_t c = 0; c < m && !has_more; ++c) {
      has_more = ++digits[c] < num_modes(c);
      if (!has_more) digits[c] = 0;
    }
  }
  return answers;
}

std::vector<Eigen::Vector2d> slides(const Reduced& reduced, const Eigen::VectorXd& v) {
  const Eigen::VectorXd u = reduced.H * v;
  std::vector<Eigen::Vector2d> result;
  for (Eigen::Index i = 0; i < u.size(); i += 3) result.emplace_back(u(i + 1), u(i + 2));
  return result;
}

/// Compares modes and motion with the only answer of the enumeration; several are refused, and none is a jam.
void compare(const RoughScene& made, int scene, std::array<int, 3>* found) {
  const Reduced reduced = reduce(made);
  const Eigen::VectorXd free = free_accelerations(made), q = reduced.H * free;
  const std::vector<Answer> answers = enumerate(reduced, q, made.mu, slides(reduced, made.v));
  if (std::ranges::any_of(answers, [](const Answer& each) { return each.margin < 1e-6; })) return;
  const Simulation simulation(made.system, {.method = Method::Dop853}, {.threads = 1});
  const std::vector<ContactEvent>& events = simulation.report().contact_events;
  ++(*found)[std::min<std::size_t>(answers.size(), 2)];
  if (answers.size() > 1) {
    EXPECT_EQ(simulation.outcome().status, Status::NotUnique) << scene << simulation.outcome().what;
    return;
  }
  if (answers.empty()) {
    const bool jams = !events.empty() && events.front().change == ContactChange::Jam;
    EXPECT_TRUE(jams || simulation.outcome().status == Status::NoSolution) << scene << simulation.outcome().what;
    return;
  }
  ASSERT_TRUE(simulation.outcome().ok()) << scene << ": " << simulation.outcome().what;
  EXPECT_TRUE(events.empty()) << scene;
  const Answer& answer = answers.front();
  const Eigen::VectorXd w =
      free + project(made.rods, made.inverse_mass, made.inverse_mass.cwiseProduct(reduced.H.transpose() * answer.r));
  EXPECT_LT(largest_difference(simulation.accelerations(), {w.data(), static_cast<std::size_t>(w.size())}),
            1e-8 * (1.0 + w.cwiseAbs().maxCoeff()))
      << scene;
  const std::span<const double> lambda = simulation.multipliers();
  const bool shares_load = std::ranges::count(answer.modes, Mode::Stick) > 1;  // their forces may not be unique
  for (std::size_t c = 0; c < made.contacts(); ++c) {
    const double N = lambda[lambda.size() - made.contacts() + c];
    EXPECT_EQ(N > 0.0, answer.modes[c] != Mode::Open) << scene << ", contact " << c;
    if (shares_load) continue;
    EXPECT_NEAR(N, answer.r(3 * static_cast<Eigen::Index>(c)), 1e-7 * (1.0 + std::abs(N))) << scene;
  }
}

TEST(RoughRows, MovingContactsHaveTheModesAndMotionsOfAnEnumeration) {
  std::mt19937 generator(1);
  std::array<int, 3> found{};
  for (int scene = 0; scene < 600; ++scene) {
    RoughScene made = make_scene(generator, scene % 2 == 1, 0.0);
    set_velocities(generator, false, &made);
    compare(made, scene, &found);
  }
  EXPECT_GT(found[1], 300);
}

TEST(RoughRows, ContactsAtRestHaveTheModesAndMotionsOfAnEnumeration) {
  std::mt19937 generator(2);
  std::array<int, 3> found{};
  for (int scene = 0; scene < 400; ++scene) compare(make_scene(generator, true, 0.0), scene, &found);
  EXPECT_GT(found[1], 200);
}

TEST(RoughRows, ImpactsAreAmongThoseOfAnEnumerationAndGainNoEnergy) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  int compared = 0;
  for (int scene = 0; scene < 1000; ++scene) {
    const double restitution = scene % 2 == 0 ? 0.0 : part(generator);
    RoughScene made = make_scene(generator, true, restitution);
    set_velocities(generator, true, &made);
    made.system.forces.clear();
    const Reduced reduced = reduce(made);
    const Eigen::VectorXd before = reduced.H * made.v;
    const Simulation simulation(made.system, {.method = Method::Dop853}, {.threads = 1});
    const auto energy = [&](std::span<const double> u) {
      double sum = 0.0;
      for (std::size_t i = 0; i < u.size(); ++i)
        sum += 0.5 * u[i] * u[i] / made.inverse_mass[static_cast<Eigen::Index>(i)];
      return sum;
    };
    const std::vector<double> v(made.v.begin(), made.v.end());
    if (simulation.velocities().empty()) continue;
    EXPECT_LE(energy(simulation.velocities()), energy(v) * (1.0 + 1e-14)) << scene;
    // Contacts that separate take no part in the first impact.
    bool all_approach = true;
    for (Eigen::Index i = 0; i < before.size(); i += 3) all_approach = all_approach && before(i) < 0.0;
    if (!all_approach || restitution > 0.0 || !simulation.outcome().ok()) continue;
    const std::vector<Answer> answers =
        enumerate(reduced, before, made.mu, std::vector<Eigen::Vector2d>(made.contacts(), Eigen::Vector2d::Zero()));
    const Eigen::VectorXd after =
        reduced.H * Eigen::Map<const Eigen::VectorXd>(simulation.velocities().data(), made.size());
    EXPECT_TRUE(std::ranges::any_of(answers, [&](const Answer& each) { return (each.u - after).norm() < 1e-9; }))
        << scene;
    ++compared;
  }
  EXPECT_GT(compared, 50);
}

/// The double pendulums of Kane and Levinson (1985) gain energy by Newton's law with friction in one of five impacts.
TEST(RoughRows, DoublePendulumsGainNoEnergyFromAFloor) {
  std::mt19937 generator(4);
  std::uniform_real_distribution<double> number(-1.0, 1.0), part(0.1, 0.9);
  int capped = 0;
  for (int scene = 0; scene < 1000; ++scene) {
    System system;
    const Index support = system.add_support({0.0, 0.0, 0.0}).index;
    Vector3 r{}, v{};
    for (int k = 0; k < 2; ++k) {
      const double angle = 1.2 * number(generator), rate = 3.0 * number(generator);
      r = {r[0] + std::sin(angle), 0.0, r[2] - std::cos(angle)};
      v = {v[0] + std::cos(angle) * rate, 0.0, v[2] + std::sin(angle) * rate};
      system.add_point({.position = r, .velocity = v});
    }
    system.constraints.push_back(Rods{.pairs = {{support, 1}, {1, 2}}});
    system.constraints.push_back(Planes{.name = "floor",
                                        .points = {2},
                                        .normal = Vector3{0.0, 0.0, 1.0},
                                        .offset = r[2],
                                        .side = OneSide::AtLeast,
                                        .restitution = part(generator)});
    system.friction.push_back(Coulomb{.at = {"floor"}, .coefficient = part(generator)});
    const auto energy = [](std::span<const double> u) {
      return 0.5 * std::inner_product(u.begin(), u.end(), u.begin(), 0.0);
    };
    const double before = energy(system.velocities);
    const Simulation simulation(system, {.method = Method::Dop853}, {.threads = 1});
    ASSERT_TRUE(simulation.outcome().ok()) << scene << ": " << simulation.outcome().what;
    EXPECT_LE(energy(simulation.velocities()), before * (1.0 + 1e-14)) << scene;
    for (const ContactEvent& event : simulation.report().contact_events) capped += event.restitution_capped ? 1 : 0;
  }
  EXPECT_GT(capped, 20);
}

}  // namespace
}  // namespace tanor
