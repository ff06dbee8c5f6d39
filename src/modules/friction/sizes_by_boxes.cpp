#include <algorithm>
#include <cmath>
#include <vector>

#include "friction/enumeration.hpp"

#include "base/dense.hpp"

/// \file Finds all solutions of s_c = mu_c |N0_c + sum_j W_cj s_j|, s >= 0, by boxes that are cut until each holds
/// none, or one that Newton's method finds (Krawczyk's test; Neumaier, Interval Methods for Systems of Equations,
/// 1990).
namespace tanor::detail {

namespace {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// The homogeneous form with s = unit y/theta, z = (theta, y), y_c = mu_c |G_c z|. Each solution has one z whose
/// largest number is 1.
struct Homogeneous {
  std::vector<double> mu;
  std::vector<Matrix3Xd> G;  // [contact]: [3][contacts + 1]
};

struct Box {
  VectorXd middle, radius;  // [contacts + 1]; the radius of the number that is 1 is 0
  Eigen::Index fixed;
};

enum class Verdict { Empty, Solved, Cut };

class Search {
 public:
  explicit Search(const Homogeneous& problem) : problem_(problem), m_(static_cast<Eigen::Index>(problem.mu.size())) {}

  Verdict examine(Box* box, VectorXd* solution) const;

 private:
  VectorXd defect(const VectorXd& z) const;
  MatrixXd jacobian(const VectorXd& z) const;
  bool narrow(Box* box) const;
  bool refine(Eigen::Index fixed, VectorXd* z) const;
  Eigen::Index variable(Eigen::Index k, Eigen::Index fixed) const { return k < fixed ? k : k + 1; }

  const Homogeneous& problem_;
  Eigen::Index m_;
};

VectorXd Search::defect(const VectorXd& z) const {
  VectorXd result(m_);
  for (Eigen::Index c = 0; c < m_; ++c) {
    const auto k = static_cast<std::size_t>(c);
    result(c) = z(c + 1) - problem_.mu[k] * (problem_.G[k] * z).norm();
  }
  return result;
}

/// Returns the derivative of the defect by all of z.
MatrixXd Search::jacobian(const VectorXd& z) const {
  MatrixXd J = MatrixXd::Zero(m_, m_ + 1);
  for (Eigen::Index c = 0; c < m_; ++c) {
    const auto k = static_cast<std::size_t>(c);
    const Vector3d N = problem_.G[k] * z;
    const double size = N.norm();
    if (size > 0.0) J.row(c) = -problem_.mu[k] / size * N.transpose() * problem_.G[k];
    J(c, c + 1) += 1.0;
  }
  return J;
}

/// Narrows the box, as y_c lies between mu times the least and the largest |G_c z| of the box. Returns false if nothing
/// is left.
bool Search::narrow(Box* box) const {
  for (Eigen::Index c = 0; c < m_; ++c) {
    const auto k = static_cast<std::size_t>(c);
    const double size = (problem_.G[k] * box->middle).norm();
    const double spread = problem_.G[k].colwise().norm() * box->radius;
    double& y = box->middle(c + 1);
    double& radius = box->radius(c + 1);
    constexpr double rounding = 1e-14;
    const double low = std::max(y - radius, problem_.mu[k] * std::max(0.0, size - spread) * (1.0 - rounding));
    const double high = std::min(y + radius, problem_.mu[k] * (size + spread) * (1.0 + rounding));
    if (low > high) return low - high < 1e-13;
    if (c + 1 == box->fixed) continue;
    y = 0.5 * (low + high);
    radius = 0.5 * (high - low);
  }
  return true;
}

bool Search::refine(Eigen::Index fixed, VectorXd* z) const {
  for (int pass = 0; pass < 30; ++pass) {
    const VectorXd rest = defect(*z);
    if (rest.lpNorm<Eigen::Infinity>() <= 1e-15 * z->lpNorm<Eigen::Infinity>()) return true;
    const MatrixXd all = jacobian(*z);
    MatrixXd J(m_, m_);
    for (Eigen::Index k = 0; k < m_; ++k) J.col(k) = all.col(variable(k, fixed));
    const VectorXd step = dense::solve(J, rest);
    if (!step.allFinite()) return false;
    for (Eigen::Index k = 0; k < m_; ++k) (*z)(variable(k, fixed)) -= step(k);
  }
  return defect(*z).lpNorm<Eigen::Infinity>() <= 1e-12 * z->lpNorm<Eigen::Infinity>();
}

Verdict Search::examine(Box* box, VectorXd* solution) const {
  for (int pass = 0; pass < 3; ++pass) {
    if (!narrow(box)) return Verdict::Empty;
  }
  // The box is taken a little larger, so that no solution lies on its border.
  VectorXd radius = (1.1 * box->radius).array() + 1e-11;
  radius(box->fixed) = 0.0;
  const MatrixXd all = jacobian(box->middle);
  MatrixXd J(m_, m_), spread(m_, m_);
  VectorXd own(m_);
  for (Eigen::Index k = 0; k < m_; ++k) {
    J.col(k) = all.col(variable(k, box->fixed));
    own(k) = radius(variable(k, box->fixed));
  }
  // Directions of N in the box differ from the middle one by at most sqrt(2) times the sine of the angle.
  for (Eigen::Index c = 0; c < m_; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const double size = (problem_.G[i] * box->middle).norm(), wide = problem_.G[i].colwise().norm() * radius;
    const double turn = wide < size ? std::sqrt(2.0) * wide / size : 2.0;
    for (Eigen::Index k = 0; k < m_; ++k)
      spread(c, k) = problem_.mu[i] * turn * problem_.G[i].col(variable(k, box->fixed)).norm();
  }
  const MatrixXd inverse = dense::Lu(J).inverse();
  if (!inverse.allFinite()) return Verdict::Cut;
  const VectorXd step = inverse * defect(box->middle);
  const VectorXd reach = inverse.cwiseAbs() * (spread * own);
  bool is_inside = true;
  for (Eigen::Index k = 0; k < m_; ++k) {
    if (std::abs(step(k)) - reach(k) > own(k)) return Verdict::Empty;
    is_inside = is_inside && std::abs(step(k)) + reach(k) <= own(k);
  }
  if (!is_inside) return Verdict::Cut;
  *solution = box->middle;
  return refine(box->fixed, solution) ? Verdict::Solved : Verdict::Cut;
}

}  // namespace

bool find_sizes_by_boxes(const ContactProblem& problem, std::vector<VectorXd>* found) {
  constexpr double smallest = 1e-9;
  const Eigen::Index m = problem.size();
  const Eigen::Index most_boxes = 20000 / (m * m);
  double unit = 0.0;
  for (std::size_t c = 0; c < problem.contacts.size(); ++c) unit = std::max(unit, problem.limit(c, VectorXd::Zero(m)));
  if (unit == 0.0) unit = 1.0;
  Homogeneous scaled;
  for (Eigen::Index c = 0; c < m; ++c) {
    scaled.mu.push_back(problem.contacts[static_cast<std::size_t>(c)].mu);
    scaled.G.emplace_back(3, m + 1) << problem.N0.segment<3>(3 * c) / unit, problem.W.middleRows<3>(3 * c);
  }
  const Search search(scaled);
  std::vector<Box> boxes;
  for (Eigen::Index fixed = 0; fixed <= m; ++fixed) {
    Box box{VectorXd::Constant(m + 1, 0.5), VectorXd::Constant(m + 1, 0.5), fixed};
    box.middle(fixed) = 1.0;
    box.radius(fixed) = 0.0;
    boxes.push_back(std::move(box));
  }
  bool is_complete = true;
  for (Eigen::Index count = 0; !boxes.empty(); ++count) {
    if (count == most_boxes) return false;
    Box box = std::move(boxes.back());
    boxes.pop_back();
    VectorXd z;
    switch (search.examine(&box, &z)) {
      case Verdict::Empty:
        break;
      case Verdict::Solved:
        // theta = 0 is a solution at infinity
        if (z(0) > 1e-12 && z.minCoeff() > -1e-9) add_new(unit / z(0) * z.tail(m).cwiseMax(0.0), found);
        break;
      case Verdict::Cut: {
        Eigen::Index widest = 0;
        if (box.radius.maxCoeff(&widest) < smallest) {
          is_complete = false;
          break;
        }
        box.radius(widest) *= 0.5;
        Box other = box;
        box.middle(widest) -= box.radius(widest);
        other.middle(widest) += other.radius(widest);
        boxes.push_back(std::move(box));
        boxes.push_back(std::move(other));
        break;
      }
    }
  }
  return is_complete;
}

}  // namespace tanor::detail
