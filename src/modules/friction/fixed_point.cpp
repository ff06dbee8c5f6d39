#include "friction/fixed_point.hpp"

#include <Eigen/Jacobi>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/instruction_sets.hpp"

namespace tanor::detail {

namespace {

using Vector = Eigen::VectorXd;

Eigen::Map<const Vector> as_vector(const std::vector<double>& x) {
  return {x.data(), static_cast<Eigen::Index>(x.size())};
}
Eigen::Map<Vector> as_vector(std::vector<double>* x) {
  return {x->data(), static_cast<Eigen::Index>(x->size())};
}

double ratio(double part, double whole) {
  return part == 0.0 ? 0.0 : part / std::max(whole, std::numeric_limits<double>::min());
}

/// max |F - x| (NaN if any number is) and max |F|.
struct Distance {
  double change, size;
};

Distance measure(const double* image, const double* x, std::size_t size) {
  return dispatch([=]() -> Distance {
    double worst = 0.0, largest_image = 0.0, sum = 0.0;
#pragma omp simd reduction(max : worst, largest_image) reduction(+ : sum)
    for (std::size_t k = 0; k < size; ++k) {
      const double g = image[k] - x[k];
      worst = std::max(worst, std::abs(g));
      largest_image = std::max(largest_image, std::abs(image[k]));
      sum += g;
    }
    return {std::isfinite(sum) ? worst : std::numeric_limits<double>::quiet_NaN(), largest_image};
  });
}

double dot(const float* a, const float* b, std::size_t size) {
  return dispatch([=] {
    double sum = 0.0;
#pragma omp simd reduction(+ : sum)
    for (std::size_t k = 0; k < size; ++k) sum += static_cast<double>(a[k]) * static_cast<double>(b[k]);
    return sum;
  });
}

/// Writes dg = (f - x) - (f_last - x_last) and df = f - f_last; returns dg.(f - x).
double subtract(const double* f, const double* x, const double* f_last, const double* x_last, std::size_t size,
                float* dg, float* df) {
  return dispatch([=] {
    double along = 0.0;
#pragma omp simd reduction(+ : along)
    for (std::size_t k = 0; k < size; ++k) {
      const double g = f[k] - x[k];
      dg[k] = static_cast<float>(g - (f_last[k] - x_last[k]));
      df[k] = static_cast<float>(f[k] - f_last[k]);
      along += static_cast<double>(dg[k]) * g;
    }
    return along;
  });
}

/// Computes y = x - sum of weights_j d_j.
void subtract_scaled(const double* x, std::size_t count, const double* weights, const float* const* d, std::size_t size,
                     double* y) {
  dispatch([=] {
    constexpr std::size_t width = 16;  // numbers that stay in registers
    std::size_t begin = 0;
    for (; begin + width <= size; begin += width) {
      double sum[width];
      for (std::size_t k = 0; k < width; ++k) sum[k] = x[begin + k];
      for (std::size_t j = 0; j < count; ++j) {
        for (std::size_t k = 0; k < width; ++k) sum[k] -= weights[j] * static_cast<double>(d[j][begin + k]);
      }
      for (std::size_t k = 0; k < width; ++k) y[begin + k] = sum[k];
    }
    for (std::size_t k = begin; k < size; ++k) {
      y[k] = x[k];
      for (std::size_t j = 0; j < count; ++j) y[k] -= weights[j] * static_cast<double>(d[j][k]);
    }
  });
}

}  // namespace

/// Anderson's method keeps the last differences of g = F(x) - x and of F(x) in a ring, with the products of the former.
/// They are in single precision, which halves what an iteration reads, since they only steer and the answer does not
/// depend on them.
class FixedPoint::History {
 public:
  explicit History(std::size_t size) : size_(size), image_(size), x_(size) {}

  /// Forgets everything and uses the last `depth` steps from now on.
  void start(int depth);
  /// Sets x := F - dF gamma, where gamma minimizes |g - dG gamma|, at F = `image` (Walker and Ni, SIAM J. Numer. Anal.
  /// 49, 2011). Keeps both arrays and puts others in their place.
  void advance(Parts* image, Parts* x);

 private:
  static constexpr std::size_t chunk = 512;  // numbers of each array at a time, which stay in the nearest cache
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_depth, most_depth>;
  using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_depth, 1>;
  void add(const Parts& image, const Parts& x);

  std::size_t size_, depth_ = 0, count_ = 0, next_ = 0;
  bool has_last_ = false;
  std::array<std::vector<float>, most_depth> dg_, df_;
  Square products_;  // dG'dG
  Column along_;     // dG'g
  Parts image_, x_;  // the last image and x
};

void FixedPoint::History::start(int depth) {
  depth_ = static_cast<std::size_t>(depth);
  for (std::size_t k = 0; k < depth_; ++k) {
    dg_[k].resize(size_);
    df_[k].resize(size_);
  }
  products_.setZero(depth, depth);
  along_.setZero(depth);
  count_ = next_ = 0;
  has_last_ = false;
}

void FixedPoint::History::add(const Parts& image, const Parts& x) {
  const std::size_t place = next_;
  next_ = (next_ + 1) % depth_;
  count_ = std::min(count_ + 1, depth_);
  std::array<double, most_depth> products{};
  double along = 0.0;
  for (std::size_t begin = 0; begin < size_; begin += chunk) {
    const std::size_t length = std::min(chunk, size_ - begin);
    float* const dg = dg_[place].data() + begin;
    along += subtract(image.data() + begin, x.data() + begin, image_.data() + begin, x_.data() + begin, length, dg,
                      df_[place].data() + begin);
    for (std::size_t j = 0; j < count_; ++j) products[j] += dot(dg_[j].data() + begin, dg, length);
  }
  // dG'g, with g changed by dg
  for (std::size_t j = 0; j < count_; ++j) {
    const auto row = static_cast<Eigen::Index>(place), column = static_cast<Eigen::Index>(j);
    products_(row, column) = products_(column, row) = products[j];
    along_(column) += products[j];
  }
  along_(static_cast<Eigen::Index>(place)) = along;
}

void FixedPoint::History::advance(Parts* image, Parts* x) {
  if (has_last_) add(*image, *x);
  has_last_ = true;
  std::swap(image_, *image);
  std::swap(x_, *x);
  const auto count = static_cast<Eigen::Index>(count_);
  Column gamma;
  if (count > 0) gamma = Square(products_.topLeftCorner(count, count)).colPivHouseholderQr().solve(along_.head(count));
  std::array<const float*, most_depth> df{};
  for (std::size_t j = 0; j < count_; ++j) df[j] = df_[j].data();
  subtract_scaled(image_.data(), count_, gamma.data(), df.data(), size_, x->data());
}

// ---- scales ----

double largest_of(const std::vector<double>& x) {
  double worst = 0.0;
  for (const double each : x) worst = larger(worst, std::abs(each));
  return worst;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) worst = larger(worst, std::abs(a[k] - b[k]));
  return worst;
}

FrictionScales::FrictionScales(const Workspace& work, const FrictionLaws& laws)
    : work_(work), model_(work.model()), laws_(laws) {
  const Tangents& tangents = work.constraints.tangents();
  std::vector<Index> group_of(work.scales.size(), -1);
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const std::size_t own = work.scales.of_point(static_cast<std::size_t>(tangents[c].point));
    if (group_of[own] < 0) {
      group_of[own] = static_cast<Index>(neighbourhoods_.size());
      neighbourhoods_.push_back(own);
    }
    group_of_part_.insert(group_of_part_.end(), laws.end_part(c) - laws.first_part(c), group_of[own]);
  }
  least_.assign(neighbourhoods_.size(), 0.0);
}

void FrictionScales::set_accelerations(const std::vector<double>& accelerations) {
  // The rounding of forces is eps m a, so forces below 1e-4 m a have fewer digits than the tolerance of the iterations.
  constexpr double part = 1e-4;
  const Tangents& tangents = work_.constraints.tangents();
  std::fill(least_.begin(), least_.end(), 0.0);
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const auto group = static_cast<std::size_t>(group_of_part_[laws_.first_part(c)]);
    const double mass = model_.mass[static_cast<std::size_t>(tangents[c].point)];
    least_[group] = std::max(least_[group], part * mass * accelerations[neighbourhoods_[group]]);
  }
}

double FrictionScales::relative_change(const std::vector<double>& x, const std::vector<double>& before) {
  constexpr double smallest_number = std::numeric_limits<double>::min();
  if (!are_several()) return largest_difference(x, before) / std::max(largest_of(x), smallest_number);
  largest_ = least_;
  largest_change_.assign(least_.size(), 0.0);
  for (std::size_t p = 0; p < x.size(); ++p) {
    const auto group = static_cast<std::size_t>(group_of_part_[p]);
    largest_[group] = larger(largest_[group], std::abs(x[p]));
    largest_change_[group] = larger(largest_change_[group], std::abs(x[p] - before[p]));
  }
  double worst = 0.0;
  for (std::size_t k = 0; k < largest_.size(); ++k)
    worst = larger(worst, largest_change_[k] / std::max(largest_[k], smallest_number));
  return worst;
}

// ---- iterations ----

FixedPoint::FixedPoint(const FrictionLaws& laws, const FrictionScales& scales, Response& response, std::size_t num_rows)
    : laws_(laws),
      scales_(scales),
      response_(response),
      x_(laws.num_parts()),
      image_(x_),
      plain_(x_),
      dlambda_(num_rows) {}
FixedPoint::~FixedPoint() = default;

/// Evaluates F(x), the laws at the multipliers that follow from x.
void FixedPoint::evaluate(const Parallel& parallel, const Parts& x, double* lambda, Parts* image) {
  response_.find_multipliers(in_newtons(x.data()), lambda);
  laws_.evaluate(parallel, lambda, image->data());
  for (std::size_t p = 0; p < inverse_unit_.size(); ++p) (*image)[p] *= inverse_unit_[p];
}

const double* FixedPoint::in_newtons(const double* x) {
  if (inverse_unit_.empty()) return x;
  for (std::size_t p = 0; p < plain_.size(); ++p) plain_[p] = x[p] / inverse_unit_[p];
  return plain_.data();
}

/// Changes the units from N to the friction of each group, so that one number measures all groups.
void FixedPoint::choose_units(Parts* x, Parts* image) {
  if (!scales_.are_several()) return;
  const std::vector<Index>& group_of_part = scales_.group_of_part();
  units_ = scales_.least();
  for (std::size_t p = 0; p < x->size(); ++p) {
    double& unit = units_[static_cast<std::size_t>(group_of_part[p])];
    unit = std::max({unit, std::abs((*x)[p]), std::abs((*image)[p])});
  }
  inverse_unit_.resize(x->size());
  for (std::size_t p = 0; p < x->size(); ++p) {
    const double unit = units_[static_cast<std::size_t>(group_of_part[p])];
    inverse_unit_[p] = unit > 0.0 && std::isfinite(unit) ? 1.0 / unit : 1.0;
    (*x)[p] *= inverse_unit_[p];
    (*image)[p] *= inverse_unit_[p];
  }
}

FixedPoint::Result FixedPoint::iterate(const Parallel& parallel, int depth, double* lambda, double poor) {
  constexpr int patience = 12;  // iterations without progress
  const int most_iterations = depth > 0 ? 100 : 500;
  Parts &x = x_, &image = image_;
  inverse_unit_.clear();
  laws_.evaluate(parallel, lambda, x.data());
  if (depth > 0 && history_ == nullptr) history_ = std::make_unique<History>(x.size());
  if (depth > 0) history_->start(depth);
  Result result;
  double distance_before = 0.0, best = std::numeric_limits<double>::infinity();
  int since_best = 0;
  while (result.iterations < most_iterations) {
    evaluate(parallel, x, lambda, &image);
    if (result.iterations == 0) choose_units(&x, &image);
    ++result.iterations;
    const auto [distance, size] = measure(image.data(), x.data(), x.size());
    if (!std::isfinite(distance)) return result;
    result.change = ratio(distance, size);
    if (depth == 0 || result.iterations == 2)
      result.contraction = std::max(result.contraction, ratio(distance, distance_before));
    if (result.iterations == 1) result.contraction = 0.0;
    distance_before = distance;
    if (result.change <= tolerance) {
      result.has_converged = true;
      break;
    }
    if (result.contraction > poor) break;
    // Rounding of an ill-conditioned S may prevent further progress.
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
    history_->advance(&image, &x);
  }
  return result;
}

/// The arrays of GMRES for one step of Newton's method.
struct FixedPoint::Krylov {
  static constexpr Eigen::Index most = 60;

  explicit Krylov(std::size_t size) : image(size), H(most + 1, most), rotations(most), solution(most + 1) {}

  Vector defect, step, w;     // [parts]
  std::vector<Vector> basis;  // [parts] each, as many as were needed so far
  Parts image;
  Eigen::MatrixXd H;                                     // Hessenberg matrix, whose upper part becomes R of H = Q R
  std::vector<Eigen::JacobiRotation<double>> rotations;  // Q'
  Vector solution;                                       // Q' (beta, 0, …), then the solution y of R y = that
};

/// Computes F'(x) dx at the multipliers lambda.
void FixedPoint::apply_derivative(const Parallel& parallel, const double* lambda, const double* dx, Parts* image) {
  response_.find_change(in_newtons(dx), dlambda_.data());
  laws_.apply_derivative(parallel, lambda, dlambda_.data(), image->data());
  for (std::size_t p = 0; p < inverse_unit_.size(); ++p) (*image)[p] *= inverse_unit_[p];
}

/// Solves (I - F') step = defect by GMRES (Saad and Schultz 1986) at the last x. Each product with F' = -dx/d lambda
/// S^-1 K'M^-1 costs one solve. Returns the remaining part of the defect.
double FixedPoint::find_newton_step(const Parallel& parallel, const double* lambda) {
  Vector &defect = krylov_->defect, &step = krylov_->step, &w = krylov_->w, &y = krylov_->solution;
  std::vector<Vector>& basis = krylov_->basis;
  Parts& image = krylov_->image;
  Eigen::MatrixXd& H = krylov_->H;
  auto& rotations = krylov_->rotations;
  const Eigen::Index most = std::min<Eigen::Index>(defect.size(), Krylov::most);
  const double beta = defect.norm();
  const auto direction = [&](Eigen::Index k) -> Vector& {
    if (basis.size() <= static_cast<std::size_t>(k)) basis.emplace_back(defect.size());
    return basis[static_cast<std::size_t>(k)];
  };
  H.setZero();
  direction(0) = defect / beta;
  y.setZero();
  y(0) = beta;
  double rest = 1.0;
  Eigen::Index k = 0;
  for (; k < most && rest > 1e-10; ++k) {
    apply_derivative(parallel, lambda, direction(k).data(), &image);
    w = direction(k) - as_vector(image);
    for (int pass = 0; pass < 2; ++pass) {
      for (Eigen::Index j = 0; j <= k; ++j) {
        const double h = direction(j).dot(w);
        H(j, k) += h;
        w -= h * direction(j);
      }
    }
    const double next = w.norm();
    H(k + 1, k) = next;
    auto column = H.col(k);
    for (Eigen::Index j = 0; j < k; ++j)
      column.applyOnTheLeft(j, j + 1, rotations[static_cast<std::size_t>(j)].adjoint());
    auto& rotation = rotations[static_cast<std::size_t>(k)];
    rotation.makeGivens(column(k), column(k + 1));
    column.applyOnTheLeft(k, k + 1, rotation.adjoint());
    y.applyOnTheLeft(k, k + 1, rotation.adjoint());
    rest = std::abs(y(k + 1)) / beta;
    if (next <= 1e-14) {
      ++k;
      break;
    }
    direction(k + 1) = w / next;
  }
  // A direction in which the matrix is singular to rounding is left out.
  step.setZero(defect.size());
  const double largest = H.topLeftCorner(k, k).diagonal().lpNorm<Eigen::Infinity>();
  for (Eigen::Index j = k; j-- > 0;) {
    y(j) = std::abs(H(j, j)) > 1e-14 * largest ? y(j) / H(j, j) : 0.0;
    y.head(j) -= y(j) * H.col(j).head(j);
    step += y(j) * direction(j);
  }
  return rest;
}

FixedPoint::Result FixedPoint::solve_by_newton(const Parallel& parallel, double* lambda, double wanted) {
  constexpr int most_steps = 20;
  Parts &x = x_, &image = image_;
  inverse_unit_.clear();
  if (krylov_ == nullptr) krylov_ = std::make_unique<Krylov>(x.size());
  laws_.evaluate(parallel, lambda, x.data());
  Result result;
  double before = std::numeric_limits<double>::infinity();
  constexpr int patience = 6;
  double best = before;
  int since_best = 0;
  for (; result.iterations <= most_steps; ++result.iterations) {
    evaluate(parallel, x, lambda, &image);
    if (result.iterations == 0) choose_units(&x, &image);
    krylov_->defect = as_vector(image) - as_vector(x);
    const auto [distance, size] = measure(image.data(), x.data(), x.size());
    if (!std::isfinite(distance)) return result;
    result.change = ratio(distance, size);
    const bool stalls = result.change <= 1e-9 && !(distance < 0.5 * before);
    if (result.change <= wanted || stalls) {
      result.has_converged = true;
      break;
    }
    before = distance;
    // The iteration may cycle between the signs of normal forces.
    since_best = distance < 0.5 * best ? 0 : since_best + 1;
    best = std::min(best, distance);
    if (since_best > patience) break;
    if (!(find_newton_step(parallel, lambda) < 0.5)) break;
    as_vector(&x) += krylov_->step;
  }
  return result;
}

}  // namespace tanor::detail
