#include "friction/rough_contacts.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <random>

#include "dense.hpp"
#include "reference.hpp"

namespace tanor::reference {
namespace {

/// Finds all complex solutions x [q] of x_j^2 = mu_j^2 N_j.N_j with N_j = N0_j + W_j x (no conjugation). These are q
/// quadrics, which have 2^q solutions (Bezout). Paths lead there from x_j = +-1 (total-degree homotopy in projective
/// coordinates; Morgan 1987).
class Quadrics {
 public:
  using Complex = std::complex<double>;
  using Vector = Eigen::VectorXcd;
  using Matrix = Eigen::MatrixXcd;

  /// Takes N0 and W as [q] of 3 and 3 x q.
  Quadrics(std::vector<double> mu, std::vector<Eigen::Vector3d> N0, std::vector<Eigen::Matrix3Xd> W)
      : mu_(std::move(mu)) {
    const auto q = static_cast<Eigen::Index>(mu_.size());
    unit_ = 1e-300;
    for (std::size_t j = 0; j < mu_.size(); ++j) unit_ = std::max(unit_, mu_[j] * N0[j].norm());
    for (std::size_t j = 0; j < mu_.size(); ++j) {
      Matrix& G = G_.emplace_back(3, q + 1);
      G << (N0[j] / unit_).cast<Complex>(), W[j].cast<Complex>();
    }
    patch_ = Vector(q + 1);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> angle(0.0, 6.283185307179586);
    for (Complex& each : patch_) each = std::polar(1.0, angle(random));
    turn_ = std::polar(1.0, angle(random));
  }

  /// Returns the real solutions, refined. `smallest` becomes the least distance of a solution from being a double one
  /// or from
  /// infinity.
  std::vector<Eigen::VectorXd> find_real(double* smallest) const {
    const std::size_t q = mu_.size();
    std::vector<Eigen::VectorXd> found;
    for (std::size_t start = 0; start < (std::size_t{1} << q); ++start) {
      Vector z(static_cast<Eigen::Index>(q) + 1);
      z(0) = 1.0;
      for (std::size_t j = 0; j < q; ++j) z(static_cast<Eigen::Index>(j) + 1) = (start >> j) & 1 ? 1.0 : -1.0;
      z /= (patch_.array() * z.array()).sum();
      if (!follow(&z)) {
        *smallest = 0.0;
        continue;
      }
      const Complex theta = z(0);
      if (std::abs(theta) < 1e-9 * z.norm()) continue;  // at infinity
      const Vector x = z.tail(static_cast<Eigen::Index>(q)) / theta;
      const double size = x.norm() + 1e-300, turned = x.imag().norm() / size;
      if (turned > 1e-6) {
        *smallest = std::min(*smallest, turned);
        continue;
      }
      found.push_back(unit_ * x.real());
    }
    return found;
  }

 private:
  /// Computes H(z, s) = (turn (1 - s) (x^2 - theta^2) + s F, patch.z - 1) and its derivatives.
  void evaluate(const Vector& z, double s, Vector* H, Matrix* J, Vector* rate) const {
    const auto q = static_cast<Eigen::Index>(mu_.size());
    J->setZero(q + 1, q + 1);
    for (Eigen::Index j = 0; j < q; ++j) {
      const auto k = static_cast<std::size_t>(j);
      const Eigen::Vector3cd N = G_[k] * z;
      const Complex x = z(j + 1), square = (N.array() * N.array()).sum();
      const Complex F = x * x - mu_[k] * mu_[k] * square, G = x * x - z(0) * z(0);
      (*H)(j) = turn_ * (1.0 - s) * G + s * F;
      (*rate)(j) = F - turn_ * G;
      J->row(j) = -2.0 * s * mu_[k] * mu_[k] * (N.transpose() * G_[k]);
      (*J)(j, j + 1) += 2.0 * x * (s + turn_ * (1.0 - s));
      (*J)(j, 0) -= 2.0 * turn_ * (1.0 - s) * z(0);
    }
    (*H)(q) = (patch_.array() * z.array()).sum() - 1.0;
    (*rate)(q) = 0.0;
    J->row(q) = patch_.transpose();
  }

  bool correct(Vector* z, double s, int most, double wanted) const {
    Vector H(z->size()), rate(z->size());
    Matrix J;
    for (int pass = 0; pass < most; ++pass) {
      evaluate(*z, s, &H, &J, &rate);
      const Vector step = J.partialPivLu().solve(H);
      *z -= step;
      if (!(step.norm() < 1e10)) return false;
      if (step.norm() <= wanted * z->norm()) return true;
    }
    return false;
  }

  bool follow(Vector* z) const {
    double s = 0.0, ds = 0.05;
    int good = 0;
    const auto tangent = [&](const Vector& at, double here) -> Vector {
      Vector H(at.size()), rate(at.size());
      Matrix J;
      evaluate(at, here, &H, &J, &rate);
      return -J.partialPivLu().solve(rate);
    };
    while (s < 1.0) {
      ds = std::min(ds, 1.0 - s);
      const Vector k1 = tangent(*z, s), k2 = tangent(*z + 0.5 * ds * k1, s + 0.5 * ds);
      const Vector k3 = tangent(*z + 0.5 * ds * k2, s + 0.5 * ds), k4 = tangent(*z + ds * k3, s + ds);
      Vector trial = *z + ds / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
      const Vector before = trial;
      // A point far from the predicted one may belong to another path.
      if (correct(&trial, s + ds, 3, 1e-10) && (trial - before).norm() < 1e-4 * trial.norm()) {
        *z = trial;
        s += ds;
        if (++good >= 3) {
          ds *= 2.0;
          good = 0;
        }
      } else {
        ds *= 0.5;
        good = 0;
        if (ds < 1e-13) return false;
      }
    }
    return correct(z, 1.0, 20, 1e-14);
  }

  std::vector<double> mu_;
  std::vector<Matrix> G_;  // [j]: 3 x (q + 1)
  double unit_ = 1.0;
  Vector patch_;
  Complex turn_;
};

}  // namespace

RoughContacts::RoughContacts(const System& system, double t) {
  const Mechanics dense = make_mechanics(system, t, system.positions, system.velocities);
  std::vector<Eigen::Index> first_row;
  Eigen::Index row = 0;
  for (const Constraint& constraint : system.constraints) {
    if (const auto* line = std::get_if<Lines>(&constraint)) {
      for (const Friction& friction : system.friction) {
        const auto& coulomb = std::get<Coulomb>(friction);
        if (std::find(coulomb.at.begin(), coulomb.at.end(), line->name) == coulomb.at.end()) continue;
        mu.push_back(coulomb.coefficient);
        points.push_back(line->points[0]);
        const auto& d = line->direction.components;
        lines.push_back(Eigen::Vector3d(d[0](t).value(), d[1](t).value(), d[2](t).value()).normalized());
        first_row.push_back(row);
      }
      row += 2;
    } else if (const auto* rods = std::get_if<Rods>(&constraint)) {
      row += static_cast<Eigen::Index>(rods->pairs.size());
    }
  }
  const auto k = static_cast<Eigen::Index>(mu.size());
  // The answer is lambda = -S^+ (phi + K'M^-1 f), w = M^-1 (f + K lambda).
  const Eigen::MatrixXd S = dense.S(), inverse = solve_least_squares(S, Eigen::MatrixXd::Identity(S.rows(), S.rows()));
  const auto answer = [&](const Eigen::VectorXd& f, const Eigen::VectorXd& phi, auto&& a, auto&& N) {
    const Eigen::VectorXd lambda = -inverse * (phi + dense.K.transpose() * f.cwiseQuotient(dense.M));
    const Eigen::VectorXd w = (f + dense.K * lambda).cwiseQuotient(dense.M);
    for (Eigen::Index c = 0; c < k; ++c) {
      const auto i = static_cast<std::size_t>(c);
      a(c) = lines[i].dot(w.segment<3>(3 * points[i]));
      N.template segment<3>(3 * c) = dense.K.block(3 * points[i], first_row[i], 3, 2) * lambda.segment<2>(first_row[i]);
    }
  };
  A.resize(k, k);
  W.resize(3 * k, k);
  a0.resize(k);
  N0.resize(3 * k);
  answer(dense.f, dense.phi, a0, N0);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(dense.phi.size());
  for (Eigen::Index c = 0; c < k; ++c) {
    Eigen::VectorXd f = Eigen::VectorXd::Zero(dense.f.size());
    f.segment<3>(3 * points[static_cast<std::size_t>(c)]) = lines[static_cast<std::size_t>(c)];
    answer(f, none, A.col(c), W.col(c));
  }
  // Rounding is removed where other constraints hold a contact altogether.
  const double mobility = dense.M.cwiseInverse().maxCoeff(), force = dense.f.cwiseAbs().maxCoeff();
  A = (A.array().abs() > 1e-11 * mobility).select(A, 0.0);
  a0 = (a0.array().abs() > 1e-11 * mobility * force).select(a0, 0.0);
}

Eigen::Vector3d RoughContacts::normal(Eigen::Index c, const Eigen::VectorXd& x) const {
  return N0.segment<3>(3 * c) + W.middleRows<3>(3 * c) * x;
}

RoughContacts::Counted RoughContacts::find_all() const {
  const auto k = static_cast<Eigen::Index>(mu.size());
  Counted counted;
  const double largest = A.diagonal().maxCoeff() + 1e-300;
  const double size_a = a0.cwiseAbs().maxCoeff() + 1e-300;
  const auto add = [&](const Eigen::VectorXd& x, const Eigen::VectorXd& a) {
    for (const Motion& other : counted.motions) {
      if ((other.a - a).cwiseAbs().maxCoeff() <= 1e-8 * size_a) return;
    }
    counted.motions.push_back({x, a});
  };
  const auto see = [&](double slack) {
    counted.margin = std::min(counted.margin, std::abs(slack));
    return slack >= 0.0;
  };
  for (std::size_t subset = 0; subset < (std::size_t{1} << k); ++subset) {
    std::vector<Eigen::Index> slide, stick;
    for (Eigen::Index c = 0; c < k; ++c) ((subset >> c) & 1 ? slide : stick).push_back(c);
    // The friction is x_S = p + Q x_J + F z.
    const auto q = static_cast<Eigen::Index>(slide.size());
    Eigen::VectorXd p = Eigen::VectorXd::Zero(k);
    Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(k, q), F(k, 0);
    for (Eigen::Index j = 0; j < q; ++j) Q(slide[static_cast<std::size_t>(j)], j) = 1.0;
    if (!stick.empty()) {
      const Eigen::MatrixXd A_SS = A(stick, stick);
      Eigen::MatrixXd vectors;
      const Eigen::VectorXd values = reference::eigenvalues(A_SS, &vectors);
      const Eigen::Index rank = (values.array() > 1e-10 * largest).count(), null = A_SS.rows() - rank;
      const Eigen::MatrixXd U = vectors.rightCols(rank);
      const Eigen::MatrixXd inverse = U * values.tail(rank).cwiseInverse().asDiagonal() * U.transpose();
      const Eigen::VectorXd a0_S = a0(stick);
      const Eigen::MatrixXd A_SJ = A(stick, slide);
      p(stick) = -inverse * a0_S;
      Q(stick, Eigen::all) = -inverse * A_SJ;
      F = Eigen::MatrixXd::Zero(k, null);
      F(stick, Eigen::all) = vectors.leftCols(null);
    }
    bool feels_share = false;
    for (const Eigen::Index c : slide) feels_share = feels_share || (W.middleRows<3>(3 * c) * F).norm() > 1e-9;
    std::vector<Eigen::VectorXd> candidates{Eigen::VectorXd(0)};
    if (q > 0) {
      std::vector<double> own_mu;
      std::vector<Eigen::Vector3d> own_N0;
      std::vector<Eigen::Matrix3Xd> own_W;
      for (const Eigen::Index c : slide) {
        own_mu.push_back(mu[static_cast<std::size_t>(c)]);
        own_N0.emplace_back(N0.segment<3>(3 * c) + W.middleRows<3>(3 * c) * p);
        own_W.emplace_back(W.middleRows<3>(3 * c) * Q);
      }
      double smallest = 1.0;
      candidates = Quadrics(own_mu, own_N0, own_W).find_real(&smallest);
      counted.margin = std::min(counted.margin, smallest);
    }
    for (const Eigen::VectorXd& x_J : candidates) {
      const Eigen::VectorXd x = p + Q * x_J, a = a0 + A * x;
      const auto is_zero = [&](Eigen::Index c) { return std::abs(a(c)) <= 1e-9 * size_a; };
      bool obeys = std::all_of(stick.begin(), stick.end(), is_zero);  // else they cannot
      if (obeys && std::all_of(slide.begin(), slide.end(), is_zero)) {
        // All contacts rest, and x is a corner of the possible shares: those that "slide" are at their limits.
        if (slide.empty() || slack(stick, x) < 0.0) obeys = slide.empty();
      } else {
        // A contact that others hold does not slide.
        for (const Eigen::Index c : slide) {
          obeys = obeys && !is_zero(c);
          if (obeys) obeys = see(-a(c) * (x(c) > 0.0 ? 1.0 : -1.0) / size_a);
        }
        if (obeys && feels_share) counted.is_certain = false;
      }
      Eigen::VectorXd held = x;
      const Eigen::MatrixXd shares = feels_share ? Eigen::MatrixXd(k, 0) : F;
      if (obeys && holds(stick, shares, &held, &counted)) add(held, a);
    }
  }
  return counted;
}

double RoughContacts::slack(const std::vector<Eigen::Index>& stick, const Eigen::VectorXd& x) const {
  double least = 1.0;
  for (const Eigen::Index c : stick) {
    const double limit = mu[static_cast<std::size_t>(c)] * normal(c, x).norm(), own = std::abs(x(c));
    least = std::min(least, limit + own > 0.0 ? (limit - own) / (limit + own) : 0.0);
  }
  return least;
}

bool RoughContacts::holds(const std::vector<Eigen::Index>& stick, const Eigen::MatrixXd& F, Eigen::VectorXd* x_found,
                          Counted* counted) const {
  const Eigen::VectorXd x = *x_found;
  const auto slack = [&](const Eigen::VectorXd& at) { return this->slack(stick, at); };
  double best = slack(x);
  if (F.cols() > 0) {
    std::mt19937 random(3);
    std::cauchy_distribution<double> cauchy;
    std::normal_distribution<double> normal_number;
    const int lines_tried = F.cols() == 1 ? 1 : 4000;
    const double size = x.norm() + N0.norm();
    for (int line = 0; line < lines_tried && best < 1e-3; ++line) {
      Eigen::VectorXd at(F.cols()), d(F.cols());
      for (Eigen::Index i = 0; i < d.size(); ++i) {
        at(i) = line == 0 ? 0.0 : size * cauchy(random);
        d(i) = F.cols() == 1 ? 1.0 : normal_number(random);
      }
      const Eigen::VectorXd from = x + F * at, along = F * d.normalized();
      std::vector<double> roots{0.0};
      for (const Eigen::Index c : stick) {
        // The roots of (x + s d)^2 - mu^2 |N + s W d|^2 = e + 2 b s + a s^2 are the ends of the intervals.
        const double m = mu[static_cast<std::size_t>(c)];
        const Eigen::Vector3d N = normal(c, from), dN = W.middleRows<3>(3 * c) * along;
        const double a = along(c) * along(c) - m * m * dN.squaredNorm(), b = from(c) * along(c) - m * m * N.dot(dN);
        const double e = from(c) * from(c) - m * m * N.squaredNorm(), D = b * b - a * e;
        if (D < 0.0) continue;
        const double root = -(b + std::copysign(std::sqrt(D), b));
        if (a != 0.0) roots.push_back(root / a);
        if (root != 0.0) roots.push_back(e / root);
      }
      std::sort(roots.begin(), roots.end());
      const double wide = 1.0 + roots.back() - roots.front();
      std::vector<double> tried{roots.front() - wide, roots.back() + wide};
      for (std::size_t i = 0; i + 1 < roots.size(); ++i) tried.push_back(0.5 * (roots[i] + roots[i + 1]));
      for (const double s : tried) {
        if (slack(from + s * along) <= best) continue;
        *x_found = from + s * along;
        best = slack(*x_found);
      }
    }
  }
  if (F.cols() <= 1) counted->margin = std::min(counted->margin, std::abs(best));
  return best >= 0.0;
}

}  // namespace tanor::reference
