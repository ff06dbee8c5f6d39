#include "friction/mode_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/dense.hpp"
#include "friction/range.hpp"

namespace tanor::detail {

namespace {

using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using std::numbers::pi;

constexpr double rank_rounding = 1e-11, smallest_sector = 1e-6;

}  // namespace

bool ModeSearch::Sector::has(const Vector2d& direction) const {
  if (is_any() || direction.norm() <= equal) return true;
  return std::abs(std::remainder(std::atan2(direction(1), direction(0)) - middle, 2.0 * pi)) <= half + equal;
}

ModeSearch::ModeSearch(const ContactProblem& problem, std::size_t most_work)
    : problem_(problem), most_work_(most_work) {
  set_contacts();
}

void ModeSearch::set_contacts() {
  const Eigen::Index k = problem_.size();
  double unit = 0.0;
  for (std::size_t c = 0; c < problem_.contacts.size(); ++c)
    unit = std::max(unit, problem_.contacts[c].mu * problem_.N0.segment<3>(3 * static_cast<Eigen::Index>(c)).norm());
  // The least friction with which all contacts would rest is used, since a point that hardly moves would need more by
  // itself.
  if (k > 0) {
    const VectorXd all_at_rest = dense::solve_least_squares(problem_.A, problem_.a0, rank_rounding);
    unit = std::max(unit, all_at_rest.lpNorm<Eigen::Infinity>());
  }
  unit_ = unit > 0.0 ? unit : 1.0;
  const double largest = std::max(problem_.a0.lpNorm<Eigen::Infinity>(), unit_ * problem_.A.lpNorm<Eigen::Infinity>());
  const double scale = largest > 0.0 ? largest : 1.0;
  // Rounding in A would move points if forces are large, so that it is removed.
  const Range range(problem_.A * (unit_ / scale), rank_rounding);
  A_ = range.vectors * range.values.asDiagonal() * range.vectors.transpose();
  a0_ = problem_.a0 / scale;
  for (std::size_t c = 0; c < problem_.contacts.size(); ++c) {
    const auto& [first, dimension, moves, mu] = problem_.contacts[c];
    const auto row = 3 * static_cast<Eigen::Index>(c);
    MatrixXd all(3, k + 1);
    all << problem_.N0.segment<3>(row) / unit_, problem_.W.middleRows<3>(row);
    const auto [sigma, U, V] = dense::find_singular_values_and_U(all);
    const auto is_zero = [&sigma = sigma, mu = mu](Eigen::Index i) {
      return sigma.size() <= i || mu * sigma(i) <= rank_rounding * std::max(1.0, mu * sigma(0));
    };
    turns_in_space_ = turns_in_space_ || !is_zero(2);
    Contact contact{
        first, dimension, moves, !is_zero(0), mu, is_zero(1) ? 1 : 2, Vector2d::Zero(), Eigen::Matrix2Xd::Zero(2, k)};
    for (Eigen::Index i = 0; i < contact.num_normals; ++i) {
      contact.nu0(i) = U.col(i).dot(all.col(0));
      contact.V.row(i) = U.col(i).transpose() * all.rightCols(k);
    }
    if (problem_.is_one_sided(c)) contact.outward = U.col(0).dot(problem_.outward[c]);
    contacts_.push_back(contact);
  }
}

void ModeSearch::run() {
  if (turns_in_space_) {
    reason = "reactions that turn in space are not searched";
    return;
  }
  // Rest comes first. It costs least, and where it is possible a run goes on with it.
  for (std::size_t subset = std::size_t{1} << contacts_.size(); subset-- > 0;) {
    if (work >= most_work_) {
      reason = "modes of stick and slip are too many to try";
      return;
    }
    if (stick(subset)) search();
  }
  if (!open_.empty() && !is_finished_) reason = "modes of stick and slip are too many to try";
}

/// Eliminates the contacts that stick. Returns false if others are then at rest, too, or if nothing lets these rest.
bool ModeSearch::stick(std::size_t subset) {
  const Eigen::Index k = problem_.size();
  stick_.clear();
  slide_.clear();
  free_.clear();
  std::vector<Eigen::Index> held;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const bool sticks = (subset >> c) & 1;
    if (sticks && (contacts_[c].moves || !contacts_[c].is_rough)) return false;
    if (!contacts_[c].is_rough) continue;  // x_c = 0
    (sticks ? stick_ : slide_).push_back(c);
    for (Eigen::Index i = 0; i < contacts_[c].dimension; ++i) (sticks ? held : free_).push_back(contacts_[c].first + i);
  }
  const auto q = static_cast<Eigen::Index>(free_.size());
  // A_SS x_S + A_SJ x_J + a0_S = 0
  p_ = VectorXd::Zero(k);
  E_ = MatrixXd::Zero(k, q);
  for (Eigen::Index j = 0; j < q; ++j) E_(free_[static_cast<std::size_t>(j)], j) = 1.0;
  Eigen::Index num_shares = 0;
  if (!held.empty()) {
    const MatrixXd A_SS = A_(held, held), A_SJ = A_(held, free_);
    const VectorXd a0_S = a0_(held);
    work += held.size() * held.size();
    const Range range(A_SS, rank_rounding, A_.diagonal().maxCoeff());
    num_shares = range.null.cols();
    const MatrixXd inverse = range.vectors * range.values.cwiseInverse().asDiagonal() * range.vectors.transpose();
    p_(held) = -inverse * a0_S;
    if ((a0_S - A_SS * (inverse * a0_S)).lpNorm<Eigen::Infinity>() > equal) return false;
    E_.conservativeResize(Eigen::NoChange, q + num_shares);
    E_.rightCols(num_shares).setZero();
    E_(held, Eigen::seqN(0, q)) = -inverse * A_SJ;
    E_(held, Eigen::seqN(q, num_shares)) = range.null;
  }
  a_p_ = a0_ + A_ * p_;
  A_E_ = A_ * E_;
  A_E_.rightCols(num_shares).setZero();  // A F = 0
  motion_needs_share_ = false;
  for (const std::size_t c : slide_) {
    const Contact& contact = contacts_[c];
    motion_needs_share_ = motion_needs_share_ || contact.mu * (contact.V * E_.rightCols(num_shares)).norm() > equal;
    if (contact.moves) continue;
    const double own = A_E_.middleRows(contact.first, contact.dimension).lpNorm<Eigen::Infinity>();
    const bool is_locked = own <= 10.0 * rank_rounding * A_.diagonal().maxCoeff();
    if (is_locked && a_p_.segment(contact.first, contact.dimension).lpNorm<Eigen::Infinity>() <= equal) return false;
  }
  return true;
}

void ModeSearch::search() {
  is_finished_ = false;
  Node whole(contacts_.size());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (contacts_[c].moves) whole[c].direction = {pi, 0.0};  // x_c = mu |nu_c|, against an acceleration along -1
    if (contacts_[c].outward != 0.0) whole[c].normal = {contacts_[c].outward > 0.0 ? 0.0 : pi, 0.0};
  }
  open_.assign(1, whole);
  while (!open_.empty() && !is_finished_ && work < most_work_) {
    const Node node = std::move(open_.back());
    open_.pop_back();
    visit(node);
  }
}

void ModeSearch::visit(const Node& node) {
  // The last unknown t is maximized: the accelerations of sliding, or else what contacts at rest have to spare.
  LinearProgram program = make_program(node);
  VectorXd u;
  const VectorXd objective = VectorXd::Unit(E_.cols() + 1, E_.cols());
  const auto one_program = static_cast<std::size_t>(objective.size() * objective.size());
  constexpr int most_cuts = 40;
  for (int cut = 0; cut < most_cuts; ++cut) {
    work += one_program;
    if (program.maximize(objective, &u) == LinearProgram::Status::Infeasible) return;
    prefer_small_shares(program, &u);
    if (!cut_discs(node, complete(u), &program)) break;
  }
  const bool something_begins =
      std::any_of(slide_.begin(), slide_.end(), [&](std::size_t c) { return !contacts_[c].moves; });
  const double t = u(E_.cols());
  if ((something_begins && t < equal) || (slide_.empty() && t < -equal)) return;
  // Senses are chosen first.
  for (const std::size_t c : slide_) {
    if (contacts_[c].dimension == 1 && node[c].direction.is_any()) return cut(node, c, &Piece::direction, true);
  }
  VectorXd x = complete(u);
  if (slide_.empty()) {
    // Any share is sufficient.
    if (verify(node, p_) == Verdict::Obeys) x = p_;
    if (verify(node, x) == Verdict::Obeys) {
      found.push_back(unit_ * come_near(node, x));
      is_finished_ = true;
      return;
    }
  } else {
    VectorXd root = x;
    const bool is_regular_here = is_regular(node, program);
    if (find_root(node, &root) && is_inside(node, root)) {
      const Verdict verdict = verify(node, root);
      if (verdict == Verdict::Obeys) {
        found.push_back(unit_ * (motion_needs_share_ ? root : come_near(node, root)));
        if (motion_needs_share_) {
          reason = "contacts that stick share their load in many ways, and the motion of others depends on the share";
          is_finished_ = true;
          return;
        }
      }
      const bool may_share = E_.cols() > static_cast<Eigen::Index>(free_.size());
      if (is_regular_here && !(verdict == Verdict::HoldsTooMuch && may_share)) return;
    }
  }
  if (!branch(node, x)) reason = "two modes of stick and slip are too near to be told apart";
}

/// Moves a solution u of the program to one whose shares are of the size of the load, if there is one. A wedge holds
/// with shares of any size, and rounding of large ones moves points.
void ModeSearch::prefer_small_shares(LinearProgram program, VectorXd* u) {
  constexpr double small = 10.0;
  const Eigen::Index size = u->size(), first = static_cast<Eigen::Index>(free_.size());
  if (first == size - 1) return;
  for (Eigen::Index i = first; i < size - 1; ++i) {
    for (const double sign : {-1.0, 1.0}) program.add(sign * RowVectorXd::Unit(size, i), small);
  }
  work += static_cast<std::size_t>(size * size);
  VectorXd smaller;
  if (program.maximize(VectorXd::Unit(size, size - 1), &smaller) == LinearProgram::Status::Optimal) *u = smaller;
}

/// Moves a share of a load that obeys the law towards the least share, as far as it obeys it.
VectorXd ModeSearch::come_near(const Node& node, VectorXd x) const {
  const Eigen::Index n = E_.cols() - static_cast<Eigen::Index>(free_.size());
  const auto F = E_.rightCols(n);
  const VectorXd change = F * (F.transpose() * x);
  constexpr int most_halvings = 20;
  for (double kept = 0.0; n > 0 && kept<1.0; kept = kept> 0.0 ? 2.0 * kept : std::exp2(-most_halvings)) {
    const VectorXd near = x - (1.0 - kept) * change;
    if (verify(node, near) == Verdict::Obeys) return near;
  }
  return x;
}

// ---- branching ----

/// Cuts the sector in which x misses the law most, or the widest one. Returns false if all are too small.
bool ModeSearch::branch(const Node& node, const VectorXd& x) {
  const VectorXd a = a0_ + A_ * x;
  struct Cut {
    double badness = -1.0;
    std::size_t contact = 0;
    Sector Piece::*which = nullptr;
  } worst;
  const auto see = [&](double badness, std::size_t c, Sector Piece::*which) {
    const Sector& sector = node[c].*which;
    const bool is_whole = which == &Piece::normal && contacts_[c].num_normals == 1 && !sector.is_any();
    if (is_whole || (!sector.is_any() && sector.half < smallest_sector) || badness <= worst.badness) return;
    worst = {badness, c, which};
  };
  const auto width = [](const Sector& sector) { return sector.is_any() ? pi : sector.half; };
  constexpr double rounding = 1e-10;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Contact& contact = contacts_[c];
    const Vector2d own = contact.part(x);
    const double size = own.norm(), limit = contact.mu * reaction(c, x).norm();
    const bool sticks = this->sticks(c);
    const double missed = (sticks ? std::max(0.0, size - limit) : std::abs(size - limit)) / (size + limit + 1e-3);
    // If the law is met, sliding contacts may still have another root.
    const double by_width = 1e-3 * rounding;
    if (missed > rounding || !sticks) see(std::max(missed, by_width * width(node[c].normal)), c, &Piece::normal);
    if (sticks || contact.dimension == 1) continue;
    const Vector2d towards = contact.part(a);
    const double turned = size > 0.0 && towards.norm() > 0.0 ? (own / size + towards.normalized()).norm() : 0.0;
    if (node[c].normal.is_any()) see(5.0, c, &Piece::normal);
    const Sector& direction = node[c].direction;
    see(direction.is_any() ? 10.0 : std::max(turned, by_width * width(direction)), c, &Piece::direction);
  }
  if (worst.badness < 0.0) return false;
  cut(node, worst.contact, worst.which, worst.which == &Piece::normal && contacts_[worst.contact].num_normals == 1);
  return true;
}

/// Opens the parts of a node whose sector is cut: the two senses of a line, or quarters, or halves.
void ModeSearch::cut(const Node& node, std::size_t c, Sector Piece::*which, bool is_line) {
  const Sector& whole = node[c].*which;
  const int count = whole.is_any() && !is_line ? 4 : 2;
  for (int i = 0; i < count; ++i) {
    Node child = node;
    child[c].*which = !whole.is_any() ? Sector{whole.middle + (i - 0.5) * whole.half, 0.5 * whole.half}
                      : is_line       ? Sector{i * pi, 0.0}
                                      : Sector{(0.5 * i + 0.25) * pi, 0.25 * pi};
    open_.push_back(std::move(child));
  }
}

}  // namespace tanor::detail
