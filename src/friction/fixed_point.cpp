#include "friction/fixed_point.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace tanor {

namespace {

using Vector = Eigen::VectorXd;

Eigen::Map<const Vector> as_vector(const std::vector<double>& x) {
  return {x.data(), static_cast<Eigen::Index>(x.size())};
}
Eigen::Map<Vector> as_vector(std::vector<double>* x) {
  return {x->data(), static_cast<Eigen::Index>(x->size())};
}

double largest(const std::vector<double>& x) {
  return x.empty() ? 0.0 : as_vector(x).lpNorm<Eigen::Infinity>();
}

double ratio(double part, double whole) {
  return part == 0.0 ? 0.0 : part / std::max(whole, std::numeric_limits<double>::min());
}

}  // namespace

/// Anderson's method: the last differences of g = F(x) - x and of F(x), in a ring, with the products of the former.
/// They steer, the answer does not rest on them: in single precision, half of what an iteration reads.
class FixedPoint::History {
 public:
  History(int depth, std::size_t size)
      : size_(size),
        dg_(static_cast<std::size_t>(depth), std::vector<float>(size)),
        df_(dg_),
        products_(depth, depth),
        along_(depth),
        image_(size),
        g_(size) {}

  int depth() const { return static_cast<int>(dg_.size()); }
  void clear() {
    count_ = next_ = 0;
    has_last_ = false;
  }
  /// x := F - dF gamma, gamma the least |g - dG gamma|, at F = `image` (Walker and Ni, SIAM J. Numer. Anal. 49, 2011).
  void advance(const Parts& image, Parts* x);

 private:
  static constexpr std::size_t chunk = 512;  // of each array at a time: it stays in the nearest cache
  void add(const Parts& image, const Parts& x);

  std::size_t size_, count_ = 0, next_ = 0;
  bool has_last_ = false;
  std::vector<std::vector<float>> dg_, df_;
  Eigen::MatrixXd products_;  // dG'dG
  Vector along_;              // dG'g
  Parts image_, g_;           // the last ones
};

namespace {

double dot(const float* a, const float* b, std::size_t size) {
  double sum = 0.0;
#pragma omp simd reduction(+ : sum)
  for (std::size_t k = 0; k < size; ++k) sum += static_cast<double>(a[k]) * static_cast<double>(b[k]);
  return sum;
}

}  // namespace

void FixedPoint::History::add(const Parts& image, const Parts& x) {
  const std::size_t place = next_;
  next_ = (next_ + 1) % dg_.size();
  count_ = std::min(count_ + 1, dg_.size());
  std::vector<double> products(count_, 0.0);
  double along = 0.0;
  for (std::size_t begin = 0; begin < size_; begin += chunk) {
    const std::size_t length = std::min(chunk, size_ - begin);
    float *const dg = dg_[place].data() + begin, *const df = df_[place].data() + begin;
    double *const f_last = image_.data() + begin, *const g_last = g_.data() + begin;
    const double *const f = image.data() + begin, *const x_now = x.data() + begin;
#pragma omp simd reduction(+ : along)
    for (std::size_t k = 0; k < length; ++k) {
      const double g = f[k] - x_now[k];
      dg[k] = static_cast<float>(g - g_last[k]);
      df[k] = static_cast<float>(f[k] - f_last[k]);
      along += static_cast<double>(dg[k]) * g;
      f_last[k] = f[k];
      g_last[k] = g;
    }
    for (std::size_t j = 0; j < count_; ++j) products[j] += dot(dg_[j].data() + begin, dg, length);
  }
  // dG'g, with g moved by dg
  for (std::size_t j = 0; j < count_; ++j) {
    const auto row = static_cast<Eigen::Index>(place), column = static_cast<Eigen::Index>(j);
    products_(row, column) = products_(column, row) = products[j];
    along_(column) += products[j];
  }
  along_(static_cast<Eigen::Index>(place)) = along;
}

void FixedPoint::History::advance(const Parts& image, Parts* x) {
  if (has_last_) {
    add(image, *x);
  } else {
    image_ = image;
    as_vector(&g_) = as_vector(image) - as_vector(*x);
    has_last_ = true;
  }
  const auto count = static_cast<Eigen::Index>(count_);
  const Eigen::MatrixXd normal = products_.topLeftCorner(count, count);
  const Vector gamma =
      count > 0 ? Vector(normal.completeOrthogonalDecomposition().solve(along_.head(count))) : Vector();
  for (std::size_t begin = 0; begin < size_; begin += chunk) {
    const std::size_t length = std::min(chunk, size_ - begin);
    double* const next = x->data() + begin;
    std::copy_n(image.data() + begin, length, next);
    for (std::size_t j = 0; j < count_; ++j) {
      const float* const df = df_[j].data() + begin;
      const double weight = gamma(static_cast<Eigen::Index>(j));
      for (std::size_t k = 0; k < length; ++k) next[k] -= weight * static_cast<double>(df[k]);
    }
  }
}

FixedPoint::FixedPoint(const FrictionLaws& laws, Response& response, std::size_t num_rows)
    : laws_(laws),
      response_(response),
      x_(laws.num_parts()),
      image_(laws.num_parts()),
      lambda_(num_rows),
      dlambda_(num_rows) {}
FixedPoint::~FixedPoint() = default;

/// F(x): what the laws say at the multipliers that x leaves.
void FixedPoint::evaluate(const Parallel& parallel, const Parts& x, Parts* image) {
  response_.find_multipliers(x.data(), lambda_.data());
  laws_.evaluate(parallel, lambda_.data(), image->data());
}

FixedPoint::Result FixedPoint::iterate(const Parallel& parallel, int depth, double* lambda) {
  constexpr int patience = 12;  // iterations without getting nearer
  const int most_iterations = depth > 0 ? 100 : 500;
  Parts &x = x_, &image = image_;
  laws_.evaluate(parallel, lambda, x.data());
  if (depth > 0 && (!history_ || history_->depth() != depth)) history_ = std::make_unique<History>(depth, x.size());
  if (depth > 0) history_->clear();
  Result result;
  double distance_before = 0.0, best = std::numeric_limits<double>::infinity();
  int since_best = 0;
  while (result.iterations < most_iterations) {
    evaluate(parallel, x, &image);
    ++result.iterations;
    const double distance = (as_vector(image) - as_vector(x)).lpNorm<Eigen::Infinity>();
    if (!std::isfinite(distance)) return result;
    result.change = ratio(distance, largest(image));
    if (depth == 0 || result.iterations == 2)
      result.contraction = std::max(result.contraction, ratio(distance, distance_before));
    if (result.iterations == 1) result.contraction = 0.0;
    distance_before = distance;
    if (result.change <= tolerance) {
      result.has_converged = true;
      break;
    }
    // Rounding of an ill-conditioned S may keep it from getting nearer.
    since_best = distance < 0.9 * best ? 0 : since_best + 1;
    best = std::min(best, distance);
    constexpr double rounding = 1e-9;
    if (since_best >= patience / 2 && result.change <= rounding) {
      result.has_converged = true;
      break;
    }
    if (depth == 0) {
      std::swap(x, image);
      continue;
    }
    if (since_best >= patience) break;
    history_->advance(image, &x);
  }
  std::copy(lambda_.begin(), lambda_.end(), lambda);
  return result;
}

/// (I - F') step = defect by GMRES (Saad and Schultz 1986) at the last x: F' = -dx/d lambda S^-1 K'M^-1 costs one
/// solve.
double FixedPoint::find_newton_step(const Parallel& parallel, const Parts& defect, Parts* step, int* iterations) {
  const auto size = static_cast<Eigen::Index>(defect.size());
  const int most = static_cast<int>(std::min<Eigen::Index>(size, 60));
  const double beta = as_vector(defect).norm();
  Eigen::MatrixXd basis(size, most + 1), H = Eigen::MatrixXd::Zero(most + 1, most);
  basis.col(0) = as_vector(defect) / beta;
  Vector solution;
  double rest = 1.0;
  Parts direction(defect.size()), image(defect.size());
  int k = 0;
  for (; k < most && rest > 1e-10; ++k) {
    as_vector(&direction) = basis.col(k);
    response_.find_change(direction.data(), dlambda_.data());
    ++*iterations;
    laws_.apply_derivative(parallel, lambda_.data(), dlambda_.data(), image.data());
    Vector w = basis.col(k) - as_vector(image);
    for (int pass = 0; pass < 2; ++pass) {
      for (int j = 0; j <= k; ++j) {
        const double h = basis.col(j).dot(w);
        H(j, k) += h;
        w -= h * basis.col(j);
      }
    }
    H(k + 1, k) = w.norm();
    Vector right = Vector::Zero(k + 2);
    right(0) = beta;
    const auto hessenberg = H.topLeftCorner(k + 2, k + 1);
    solution = hessenberg.colPivHouseholderQr().solve(right);
    rest = (right - hessenberg * solution).norm() / beta;
    if (H(k + 1, k) <= 1e-14) {
      ++k;
      break;
    }
    basis.col(k + 1) = w / H(k + 1, k);
  }
  step->resize(defect.size());
  as_vector(step) = basis.leftCols(k) * solution;
  return rest;
}

FixedPoint::Result FixedPoint::solve_by_newton(const Parallel& parallel, double* lambda, double wanted) {
  constexpr int most_steps = 20;
  Parts &x = x_, &image = image_;
  Parts defect(x.size()), step;
  laws_.evaluate(parallel, lambda, x.data());
  Result result;
  int solves_of_steps = 0;
  double before = std::numeric_limits<double>::infinity();
  constexpr int patience = 6;
  double best = before;
  int since_best = 0;
  for (; result.iterations <= most_steps; ++result.iterations) {
    evaluate(parallel, x, &image);
    as_vector(&defect) = as_vector(image) - as_vector(x);
    const double distance = largest(defect);
    if (!std::isfinite(distance)) return result;
    result.change = ratio(distance, largest(image));
    const bool stalls = result.change <= 1e-9 && !(distance < 0.5 * before);
    if (result.change <= wanted || stalls) {
      result.has_converged = true;
      break;
    }
    before = distance;
    // It may go round in circles between the signs of normal forces.
    since_best = distance < 0.5 * best ? 0 : since_best + 1;
    best = std::min(best, distance);
    if (since_best > patience) break;
    if (!(find_newton_step(parallel, defect, &step, &solves_of_steps) < 0.5)) break;
    as_vector(&x) += as_vector(step);
  }
  std::copy(lambda_.begin(), lambda_.end(), lambda);
  return result;
}

}  // namespace tanor
