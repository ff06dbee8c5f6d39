#pragma once

/// \file A dense program of its own for two or three beads on rough lines and planes, joined in a row by rods or
/// springs. It shares nothing with src/: once the tensions of the rods are known the law of each bead is explicit, so
/// that all motions of an instant are the roots of one or two equations.

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace tanor::rough_row {

using Eigen::Vector3d, Eigen::VectorXd, Eigen::MatrixXd;

/// A bead at r on the line along the first direction, or on the plane through both.
struct Bead {
  Vector3d r;
  std::array<Vector3d, 2> directions;  // orthonormal
  bool is_on_plane = false;
  double mass = 1.0, mu = 0.0, mu_s = 0.0, rate = 1.0;
  Vector3d size, phase, v = Vector3d::Zero();

  Vector3d force(double t) const {
    Vector3d f;
    for (int c = 0; c < 3; ++c) f(c) = size(c) * std::sin(rate * t + phase(c));
    return f;
  }
  Vector3d along(const Vector3d& f) const {
    Vector3d result = f.dot(directions[0]) * directions[0];
    if (is_on_plane) result += f.dot(directions[1]) * directions[1];
    return result;
  }
};

/// Joins a bead to the next one: a rod, or a spring where the stiffness is not 0.
struct Joint {
  double length = 0.0, stiffness = 0.0;
  bool is_rod() const { return stiffness == 0.0; }
};

struct Row {
  std::vector<Bead> beads;
  std::vector<Joint> joints;
};

class Program {
 public:
  /// Steps are no longer than this, s.
  explicit Program(const Row& row, double longest_step = 1e-2)
      : row_(row), longest_step_(longest_step), modes_(row.beads.size()) {
    for (const Bead& bead : row.beads) {
      y_.push_back(bead.r);
      v_.push_back(bead.v);
    }
    tensions_ = VectorXd::Zero(static_cast<Eigen::Index>(row.joints.size()));
  }

  bool is_certain = true;  ///< false once several motions obey the law, or none, or steps are too many
  int events = 0;          ///< stops and starts

  const Vector3d& position(std::size_t i) const { return y_[i]; }

  void advance_to(double t_end) {
    for (std::size_t i = 0; i < size(); ++i)
      modes_[i] = v_[i].norm() > 0.0 ? Mode{false, v_[i].normalized()} : Mode{true, Vector3d::Zero()};
    decide(0.0, false);
    double t = 0.0, h = 0.1 * longest_step_;
    constexpr int most_attempts = 200000;
    int attempts = 0;
    while (is_certain && t < t_end && events < 200) {
      is_certain = ++attempts < most_attempts;
      const Points from = y_, speed = v_;
      const double length = std::min(h, t_end - t), error = step(t, length, from, speed) / 1e-12;
      if (!is_certain) return;
      if (error > 1.0) {
        h = length * std::max(0.2, 0.8 * std::pow(error, -0.2));
        y_ = from;
        v_ = speed;
        is_certain = h > 1e-15;
        continue;
      }
      if (meets(t + length)) {
        locate(t, length, from, speed, &t);
      } else {
        t += length;
        h = std::min(longest_step_, length * std::min(4.0, 0.8 * std::pow(error + 1e-10, -0.2)));
      }
    }
    is_certain = is_certain && events < 200;
  }

 private:
  using Points = std::vector<Vector3d>;
  struct Mode {
    bool is_held;
    Vector3d sense;  // of sliding on a line; of a plane it only tells that the bead has left
  };
  /// An instant: what the rods do, and the forces on the beads without them.
  struct Instant {
    Points e, loads, speeds;
    std::vector<double> turning;
  };

  std::size_t size() const { return row_.beads.size(); }

  Instant look(double t, const Points& r, const Points& v) const {
    Instant at;
    at.speeds = v;
    for (const Bead& bead : row_.beads) at.loads.push_back(bead.force(t));
    for (std::size_t k = 0; k < row_.joints.size(); ++k) {
      const Vector3d d = r[k + 1] - r[k], e = d.normalized(), u = v[k + 1] - v[k];
      at.e.push_back(e);
      at.turning.push_back((u - u.dot(e) * e).squaredNorm() / d.norm());
      if (row_.joints[k].is_rod()) continue;
      const Vector3d pull = row_.joints[k].stiffness * (d.norm() - row_.joints[k].length) * e;
      at.loads[k] += pull;
      at.loads[k + 1] -= pull;
    }
    return at;
  }
  Vector3d load(const Instant& at, std::size_t i, const VectorXd& T) const {
    Vector3d f = at.loads[i];
    if (i < row_.joints.size() && row_.joints[i].is_rod()) f += T(static_cast<Eigen::Index>(i)) * at.e[i];
    if (i > 0 && row_.joints[i - 1].is_rod()) f -= T(static_cast<Eigen::Index>(i - 1)) * at.e[i - 1];
    return f;
  }

  /// How a bead is treated: held, sliding along its velocity or sense, or at rest with this coefficient.
  struct Law {
    enum { Held, Slides, Rests } kind;
    double mu;
    Vector3d sense;
  };

  /// Returns the acceleration of a bead under a force, and what a change of the force by `by` makes of it.
  static Vector3d accelerate(const Bead& bead, const Law& law, const Vector3d& f, const Vector3d& by,
                             Vector3d* change) {
    *change = Vector3d::Zero();
    if (law.kind == Law::Held) return Vector3d::Zero();
    const Vector3d g = bead.along(f), N = f - g, dg = bead.along(by), dN = by - dg;
    const double n = N.norm(), by_n = n > 0.0 ? N.dot(dN) / n : 0.0;
    if (law.kind == Law::Slides) {
      *change = (dg - law.mu * by_n * law.sense) / bead.mass;
      return (g - law.mu * n * law.sense) / bead.mass;
    }
    const double most = law.mu * n;
    if (g.norm() <= most) return Vector3d::Zero();
    const Vector3d s = g.normalized();
    const double spare = 1.0 - most / g.norm();
    *change = (spare * dg + (most * s.dot(dg) / g.norm() - law.mu * by_n) * s) / bead.mass;
    return spare * g / bead.mass;
  }

  /// Solves for the tensions from a guess by Newton's method. Returns true if all rods keep their lengths.
  bool solve(const Instant& at, const std::vector<Law>& laws, VectorXd* T, Points* a) const {
    const auto rods = T->size();
    a->assign(size(), Vector3d::Zero());
    for (int pass = 0; pass < 30; ++pass) {
      VectorXd miss = VectorXd::Zero(rods);
      MatrixXd by = MatrixXd::Zero(rods, rods);
      double scale = 1.0;
      const auto add = [&](Eigen::Index k, double sign, std::size_t i) {
        const auto joint = static_cast<std::size_t>(k);
        if (!row_.joints[joint].is_rod()) return;
        const Vector3d f = load(at, i, *T);
        Vector3d change;
        (*a)[i] = accelerate(row_.beads[i], laws[i], f, Vector3d::Zero(), &change);
        scale = std::max(scale, (*a)[i].norm());
        miss(k) += sign * at.e[joint].dot((*a)[i]);
        for (Eigen::Index j = std::max<Eigen::Index>(0, static_cast<Eigen::Index>(i) - 1);
             j <= std::min(static_cast<Eigen::Index>(i), rods - 1); ++j) {
          if (!row_.joints[static_cast<std::size_t>(j)].is_rod()) continue;
          const double way = static_cast<std::size_t>(j) == i ? 1.0 : -1.0;
          accelerate(row_.beads[i], laws[i], f, way * at.e[static_cast<std::size_t>(j)], &change);
          by(k, j) += sign * at.e[joint].dot(change);
        }
      };
      for (Eigen::Index k = 0; k < rods; ++k) {
        const auto joint = static_cast<std::size_t>(k);
        if (row_.joints[joint].is_rod()) miss(k) = at.turning[joint];
        add(k, -1.0, joint);
        add(k, 1.0, joint + 1);
        if (laws[joint].kind == Law::Held && laws[joint + 1].kind == Law::Held) miss(k) = 0.0;
      }
      if (miss.lpNorm<Eigen::Infinity>() <= 3e-14 * scale || (pass > 8 && miss.norm() <= 1e-12 * scale)) {
        for (std::size_t i = 0; i < size(); ++i) {
          Vector3d change;
          (*a)[i] = accelerate(row_.beads[i], laws[i], load(at, i, *T), Vector3d::Zero(), &change);
        }
        return true;
      }
      const double part = pass % 3 == 2 ? 0.5 : 1.0;  // since full steps may go to and fro over a kink
      *T -= part * by.completeOrthogonalDecomposition().solve(miss);
      if (!(T->norm() < 1e6)) return false;
    }
    return false;
  }

  std::vector<Law> sliding_laws(const Points& v) const {
    std::vector<Law> laws;
    for (std::size_t i = 0; i < size(); ++i) {
      const Bead& bead = row_.beads[i];
      if (modes_[i].is_held)
        laws.push_back({Law::Held, 0.0, Vector3d::Zero()});
      else if (!bead.is_on_plane)
        laws.push_back({Law::Slides, bead.mu, modes_[i].sense});
      else if (v[i].norm() > 0.0)
        laws.push_back({Law::Slides, bead.mu, v[i].normalized()});
      else
        laws.push_back({Law::Rests, bead.mu, Vector3d::Zero()});
    }
    return laws;
  }

  /// Makes a step of Dormand and Prince from there, and returns its error.
  double step(double t, double h, const Points& r0, const Points& v0) {
    static constexpr double c[7] = {0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0};
    static constexpr double b[7][6] = {{},
                                       {0.2},
                                       {3.0 / 40, 9.0 / 40},
                                       {44.0 / 45, -56.0 / 15, 32.0 / 9},
                                       {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
                                       {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
                                       {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
    static constexpr double e[7] = {71.0 / 57600,      0.0,          -71.0 / 16695, 71.0 / 1920,
                                    -17253.0 / 339200, 22.0 / 525.0, -1.0 / 40};
    std::array<Points, 7> rates, accelerations;
    for (std::size_t s = 0; s < 7; ++s) {
      y_ = r0;
      v_ = v0;
      for (std::size_t j = 0; j < s; ++j) {
        for (std::size_t i = 0; i < size(); ++i) {
          y_[i] += h * b[s][j] * rates[j][i];
          v_[i] += h * b[s][j] * accelerations[j][i];
        }
      }
      rates[s] = v_;
      if (!solve(look(t + c[s] * h, y_, v_), sliding_laws(v_), &tensions_, &accelerations[s])) {
        is_certain = h > 1e-9;  // too long a step
        return 1e10;
      }
    }
    double error = 0.0;
    for (std::size_t i = 0; i < size(); ++i) {
      Vector3d of_r = Vector3d::Zero(), of_v = of_r;
      for (std::size_t s = 0; s < 7; ++s) {
        of_r += h * e[s] * rates[s][i];
        of_v += h * e[s] * accelerations[s][i];
      }
      error = std::max({error, of_r.norm(), of_v.norm()});
    }
    return error;
  }

  bool shares(std::size_t k) const { return row_.joints[k].is_rod() && modes_[k].is_held && modes_[k + 1].is_held; }

  /// Returns what the force of friction leaves to spare of its limit, mu^2 |N|^2 - |F|^2: quadratic in the tensions.
  double spare(const Instant& at, std::size_t i, const VectorXd& T) const {
    const Vector3d f = load(at, i, T), g = row_.beads[i].along(f);
    return row_.beads[i].mu_s * row_.beads[i].mu_s * (f - g).squaredNorm() - g.squaredNorm();
  }

  using Interval = std::array<double, 2>;
  /// Returns the tensions of the rod k that let bead i rest, as the other rod stands.
  std::vector<Interval> intervals(const Instant& at, std::size_t i, std::size_t k) const {
    constexpr double far = 1e4;
    VectorXd T = tensions_;
    const auto value = [&](double x) {
      T(static_cast<Eigen::Index>(k)) = x;
      return spare(at, i, T);
    };
    const double c = value(0.0), a = 0.5 * (value(1.0) + value(-1.0)) - c, b = 0.5 * (value(1.0) - value(-1.0)),
                 D = b * b - 4.0 * a * c;
    if (D < 0.0) return a > 0.0 ? std::vector<Interval>{{-far, far}} : std::vector<Interval>{};
    const double q = -0.5 * (b + std::copysign(std::sqrt(D), b)), x0 = std::min(q / a, c / q),
                 x1 = std::max(q / a, c / q);
    return a > 0.0 ? std::vector<Interval>{{-far, x0}, {x1, far}} : std::vector<Interval>{{x0, x1}};
  }

  /// Returns true if some tensions of the rods between held beads let all of them rest.
  bool may_rest(const Instant& at) const {
    std::vector<std::size_t> shared;
    for (std::size_t k = 0; k < row_.joints.size(); ++k)
      if (shares(k)) shared.push_back(k);
    for (std::size_t i = 0; i < size(); ++i) {
      const bool is_alone = std::none_of(shared.begin(), shared.end(), [&](auto k) { return k == i || k + 1 == i; });
      const double rounding = 1e-11 * (1.0 + load(at, i, tensions_).squaredNorm());
      if (modes_[i].is_held && is_alone && spare(at, i, tensions_) < -rounding) return false;
    }
    if (shared.empty()) return true;
    if (shared.size() == 2) return all_three_may_rest(at);
    for (const auto& [x0, x1] : intervals(at, shared[0], shared[0]))
      for (const auto& [y0, y1] : intervals(at, shared[0] + 1, shared[0]))
        if (std::max(x0, y0) <= std::min(x1, y1)) return true;
    return false;
  }

  /// The first bead bounds the first tension and the last one the second one. What the middle one has to spare is
  /// largest in a corner of such a box, in the middle of an edge or inside.
  bool all_three_may_rest(const Instant& at) const {
    const auto value = [&](double x, double y) { return spare(at, 1, Eigen::Vector2d(x, y)); };
    // The quadratic c + b.T + T'A T/2
    const double c = value(0, 0), b0 = 0.5 * (value(1, 0) - value(-1, 0)), b1 = 0.5 * (value(0, 1) - value(0, -1)),
                 a00 = value(1, 0) + value(-1, 0) - 2.0 * c, a11 = value(0, 1) + value(0, -1) - 2.0 * c,
                 a01 = value(1, 1) - c - b0 - b1 - 0.5 * a00 - 0.5 * a11, det = a00 * a11 - a01 * a01;
    for (const auto& [x0, x1] : intervals(at, 0, 0)) {
      for (const auto& [y0, y1] : intervals(at, 2, 1)) {
        std::vector<Interval> tried{{(a01 * b1 - a11 * b0) / det, (a01 * b0 - a00 * b1) / det}};
        for (const double x : {x0, x1}) tried.push_back({x, -(b1 + a01 * x) / a11});
        for (const double y : {y0, y1}) tried.push_back({-(b0 + a01 * y) / a00, y});
        for (const double x : {x0, x1})
          for (const double y : {y0, y1}) tried.push_back({x, y});
        for (const auto& [x, y] : tried)
          if (x >= x0 && x <= x1 && y >= y0 && y <= y1 && value(x, y) >= 0.0) return true;
      }
    }
    return false;
  }

  /// Returns true if at the present state a bead has stopped or held ones do not rest.
  bool meets(double t) {
    const Instant at = look(t, y_, v_);
    Points a;
    if (!solve(at, sliding_laws(v_), &tensions_, &a)) return true;
    for (std::size_t i = 0; i < size(); ++i) {
      if (modes_[i].is_held) continue;
      if (!row_.beads[i].is_on_plane && v_[i].dot(modes_[i].sense) <= 0.0) return true;
      if (row_.beads[i].is_on_plane && v_[i].norm() < at_rest && v_[i].dot(a[i]) < 0.0) return true;
    }
    return !may_rest(at);
  }

  void locate(double t, double length, const Points& r, const Points& v, double* end) {
    double low = 0.0, high = length;
    while (high - low > 1e-15) {
      const double middle = 0.5 * (low + high);
      if (middle <= low || middle >= high) break;
      step(t, middle, r, v);
      if (!is_certain) return;
      (meets(t + middle) ? high : low) = middle;
    }
    step(t, high, r, v);
    *end = t + high;
    ++events;
    const bool gives_way = !may_rest(look(*end, y_, v_));
    for (std::size_t i = 0; i < size(); ++i) {
      if (v_[i].norm() >= 10.0 * at_rest) continue;
      v_[i].setZero();
      modes_[i].is_held = true;
    }
    decide(*end, gives_way);
  }

  /// Finds all motions in which beads at rest have these coefficients.
  std::vector<Points> find_motions(const Instant& at, const std::vector<Law>& laws, VectorXd* T) const {
    std::vector<Points> found;
    const auto try_from = [&](VectorXd guess) {
      Points a;
      if (!solve(at, laws, &guess, &a)) return;
      const auto is_same = [&](const Points& other) {
        double apart = 0.0, scale = 1.0;
        for (std::size_t i = 0; i < size(); ++i) {
          apart = std::max(apart, (other[i] - a[i]).norm());
          scale = std::max(scale, a[i].norm());
        }
        return apart < 1e-9 * scale;
      };
      if (std::any_of(found.begin(), found.end(), is_same)) return;
      found.push_back(a);
      *T = guess;
    };
    constexpr std::array guesses{0.0,   1.0,  -1.0,  2.0,  -2.0,  4.0,  -4.0,  8.0,   -8.0,
                                 -16.0, 16.0, -32.0, 32.0, -64.0, 64.0, 128.0, -128.0};
    try_from(tensions_);
    for (const double x : guesses) {
      if (row_.joints.size() == 1) try_from(VectorXd::Constant(1, x));
      for (std::size_t k = 0; row_.joints.size() == 2 && k < guesses.size(); ++k)
        try_from(Eigen::Vector2d(x, guesses[k]));
    }
    return found;
  }

  /// Chooses who sticks: static limits first; those that they let move have the smaller friction from then on. Where
  /// something gives way, limits a little lower tell who.
  void decide(double t, bool gives_way) {
    const Instant at = look(t, y_, v_);
    std::vector<char> released(size(), 0);
    for (std::size_t round = 0; round <= size(); ++round) {
      std::vector<Law> laws = sliding_laws(v_);
      for (std::size_t i = 0; i < size(); ++i) {
        if (!modes_[i].is_held) continue;
        const Bead& bead = row_.beads[i];
        laws[i] = {Law::Rests, released[i] != 0 ? bead.mu : bead.mu_s * (gives_way && round == 0 ? 1.0 - 1e-8 : 1.0),
                   Vector3d::Zero()};
      }
      VectorXd T = tensions_;
      const std::vector<Points> found = find_motions(at, laws, &T);
      if (is_certain = found.size() == 1; !is_certain) return;
      tensions_ = T;
      bool goes_on = false;
      for (std::size_t i = 0; i < size(); ++i) {
        if (!modes_[i].is_held || released[i] != 0 || found[0][i].norm() <= 1e-9) continue;
        released[i] = 1;
        goes_on = true;
      }
      if (goes_on) continue;
      for (std::size_t i = 0; i < size(); ++i)
        if (modes_[i].is_held && found[0][i].norm() > 1e-9) modes_[i] = {false, found[0][i].normalized()};
      return;
    }
  }

  static constexpr double at_rest = 1e-10;  // m/s
  const Row& row_;
  const double longest_step_;
  std::vector<Mode> modes_;
  Points y_, v_;
  VectorXd tensions_;
};

}  // namespace tanor::rough_row
