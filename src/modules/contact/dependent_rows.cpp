#include "contact/dependent_rows.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "base/dense.hpp"
#include "contact/exchange.hpp"

namespace tanor::detail {

namespace {

using Eigen::VectorXd;

constexpr double compliance = 1e-8;      // over the largest number on the diagonal of S
constexpr std::size_t most_rows = 1000;  // S is dense here

}  // namespace

/// The rows of one island that may be closed, signed so that one-sided ones have p >= 0.
struct DependentRows::Island {
  std::vector<std::size_t> row{};                       // of the model
  std::vector<std::optional<std::size_t>> one_sided{};  // its number among these
  Eigen::MatrixXd S{};                                  // with the compliance
  VectorXd b{};

  std::vector<bool> find_open() const;
};

DependentRows::DependentRows(const Model& model, ConstrainedSystem& system, Gaps& gaps)
    : model_(model), system_(system), gaps_(gaps) {
  for (std::size_t row = 0; row < model.num_rows(); ++row)
    island_.push_back(model.numbering.island_of(static_cast<Index>(row)));
}

/// Marks the islands in which rows depend on others and one-sided rows of `which` lie.
std::vector<char> DependentRows::mark_islands(std::span<const char> which) const {
  std::vector<char> depend(model_.numbering.num_islands() + 1, 0), marked(depend);
  const Dependences& redundancy = system_.redundancy();
  for (std::size_t row = 0; row < island_.size(); ++row)
    if (redundancy.is_dependent(row)) depend[island_[row]] = 1;
  for (std::size_t k = 0; k < which.size(); ++k) {
    const std::size_t island = island_[static_cast<std::size_t>(model_.numbering.one_sided[k].row)];
    if (which[k] != 0) marked[island] = depend[island];
  }
  return marked;
}

bool DependentRows::have(std::span<const char> which) const {
  return system_.redundancy().is_found() && std::ranges::count(mark_islands(which), 1) > 0;
}

void DependentRows::set_rates(std::vector<double> b) {
  b_ = std::move(b);
  multipliers_.clear();
  free_w_.clear();
}

void DependentRows::set_accelerations(const double* r, const double* v, const double* w,
                                      std::vector<double> multipliers) {
  multipliers_ = std::move(multipliers);
  free_w_.assign(w, w + 3 * model_.num_points());
  gaps_.measure_right_side(r, v, w, &b_);
}

bool DependentRows::look_ahead(const double* r, const double* v, const double* w, std::span<const char> may_close) {
  constexpr double part = 0.03, at_rest = 0.01;  // of the time in which a row would turn; of the speed reached then
  if (free_w_.empty()) return false;
  struct Moment {
    double time = std::numeric_limits<double>::infinity(), speed = 0.0, fastest = 0.0;
    bool may_come() const { return std::isfinite(time) && speed <= at_rest * time * fastest; }
  };
  const std::vector<char> marked = mark_islands(may_close);
  std::vector<Moment> moments(marked.size());
  for (std::size_t k = 0; k < may_close.size(); ++k) {
    const std::size_t island = island_[static_cast<std::size_t>(model_.numbering.one_sided[k].row)];
    if (may_close[k] == 0 || marked[island] == 0) continue;
    Moment& moment = moments[island];
    for (const Incidence& arm : gaps_.arms()[k]) {
      const double a = norm(load(w, arm.point));
      if (a > 0.0) moment.time = std::min(moment.time, part * std::sqrt(gaps_.length(k) / a));
      moment.fastest = std::max(moment.fastest, a);
      moment.speed = std::max(moment.speed, norm(load(v, arm.point)));
    }
  }
  if (std::ranges::none_of(moments, &Moment::may_come)) return false;
  std::vector<double> later(v, v + 3 * model_.num_points());
  for (const Incidence& each : model_.incidences) {
    const Moment& moment = moments[island_[static_cast<std::size_t>(each.row)]];
    const auto point = static_cast<std::size_t>(each.point);
    if (moment.may_come() && point < model_.num_moving())
      store(later.data(), point, load(v, point) + moment.time * load(w, point));
  }
  gaps_.measure_right_side(r, later.data(), free_w_.data(), &b_);
  return true;
}

std::vector<DependentRows::Island> DependentRows::collect(std::span<const char> may_close) const {
  const Numbering& numbering = model_.numbering;
  std::vector<std::optional<std::size_t>> number(model_.num_rows());
  for (std::size_t k = 0; k < may_close.size(); ++k) number[static_cast<std::size_t>(numbering.one_sided[k].row)] = k;
  const std::vector<char> marked = mark_islands(may_close);
  std::vector<Island> islands;
  std::vector<std::size_t> place(model_.num_rows(), model_.num_rows());  // in its island
  for (std::size_t i = 0; i < numbering.num_islands(); ++i) {
    if (marked[i] == 0) continue;
    Island& island = islands.emplace_back();
    for (auto row = static_cast<std::size_t>(numbering.island_start[i]);
         row < static_cast<std::size_t>(numbering.island_start[i + 1]); ++row) {
      if (number[row] && may_close[*number[row]] == 0) continue;
      place[row] = island.row.size();
      island.row.push_back(row);
      island.one_sided.push_back(number[row]);
    }
  }
  std::erase_if(islands, [](const Island& island) { return island.row.size() > most_rows; });
  std::vector<Island*> island_of(marked.size(), nullptr);
  for (Island& island : islands) {
    const auto n = static_cast<Eigen::Index>(island.row.size());
    island.S.setZero(n, n);
    island_of[island_[island.row.front()]] = &island;
  }
  // S = K'M^-1K, point by point
  struct Arm {
    Eigen::Index row;
    Vec3 gradient;
  };
  std::map<Index, std::pair<Island*, std::vector<Arm>>> points;
  const auto sign = [&](std::size_t row) { return number[row] ? numbering.one_sided[*number[row]].sign : 1.0; };
  for (const Incidence& each : model_.incidences) {
    const auto row = static_cast<std::size_t>(each.row);
    Island* const island = island_of[island_[row]];
    const bool moves = model_.inverse_mass[static_cast<std::size_t>(each.point)] > 0.0;
    if (island == nullptr || place[row] == model_.num_rows() || !moves) continue;
    auto& [own, arms] = points[each.point];
    own = island;
    arms.push_back(
        {static_cast<Eigen::Index>(place[row]), sign(row) * each.sign * load(system_.blocks().data(), each.block)});
  }
  for (const auto& [point, at] : points)
    for (const Arm& i : at.second)
      for (const Arm& j : at.second)
        at.first->S(i.row, j.row) += model_.inverse_mass[static_cast<std::size_t>(point)] * dot(i.gradient, j.gradient);
  for (Island& island : islands) {
    const double c = compliance * island.S.diagonal().maxCoeff();
    island.S.diagonal().array() += c;
    island.b.resize(island.S.rows());
    for (std::size_t i = 0; i < island.row.size(); ++i) {
      const std::size_t row = island.row[i];
      const double held = island.one_sided[i] || multipliers_.empty() ? 0.0 : c * multipliers_[row];
      island.b(static_cast<Eigen::Index>(i)) = sign(row) * b_[row] + held;
    }
  }
  return islands;
}

/// Exchanges closed and open rows until none is wrong. Nothing is open where that fails.
std::vector<bool> DependentRows::Island::find_open() const {
  constexpr double rounding = 1e-4;  // of what the compliance does
  const std::size_t n = row.size();
  std::vector<bool> open(n, false);
  for (Exchange exchange; !exchange.is_stuck();) {
    std::vector<Eigen::Index> closed;
    for (std::size_t i = 0; i < n; ++i)
      if (!open[i]) closed.push_back(static_cast<Eigen::Index>(i));
    VectorXd p = VectorXd::Zero(b.size());
    p(closed) = -dense::Ldlt(S(closed, closed)).solve(b(closed));
    if (!p.allFinite()) break;
    const VectorXd rates = b + S * p;
    const double little = rounding * compliance * p.lpNorm<Eigen::Infinity>();
    std::vector<std::size_t> wrong;
    for (std::size_t k = 0; k < n; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      if (one_sided[k] && (open[k] ? rates(i) < -little * S(i, i) : p(i) < -little)) wrong.push_back(k);
    }
    if (wrong.empty()) return open;
    for (const std::size_t i : exchange.choose(wrong, open)) open[i] = !open[i];
  }
  return std::vector<bool>(n, false);
}

std::vector<char> DependentRows::choose(std::span<const char> may_close) const {
  std::vector<char> closed(may_close.begin(), may_close.end());
  for (const Island& island : collect(may_close)) {
    const std::vector<bool> open = island.find_open();
    for (std::size_t i = 0; i < open.size(); ++i)
      if (island.one_sided[i]) closed[*island.one_sided[i]] = open[i] ? 0 : 1;
  }
  return closed;
}

}  // namespace tanor::detail
