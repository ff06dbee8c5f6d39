#include "schur/path_series.hpp"

#include <algorithm>
#include <cstring>
#include <variant>

#include "base/index_ranges.hpp"
#include "base/instruction_sets.hpp"
#include "schur/lane_points.hpp"
#include "schur/needed_terms.hpp"
#include "schur/path_lanes.hpp"

namespace tanor::detail {

namespace {

using Pieces = PathLanes<RodLanes::most, true>;
using Paths = PathLanes<RodLanes::most, false>;
using FewPaths = PathLanes<RodLanes::few, false>;

/// Moves the points of a group into and out of the system's arrays.
template <class Lanes>
using Places = LanePoints<Lanes::width>;

template <class Lanes>
using Terms = TermCounter<Lanes::width, Lanes::are_one_path>;
template <class Lanes>
using Weights = TermWeights<Lanes::width>;

/// Reads r_0, r_1 and r_2. If terms are counted, `weights` [point] has the absolute errors that are allowed, and gets
/// the weights.
template <class Lanes>
void begin(const Lanes& lanes, const Places<Lanes>& places, std::span<double* const, 3> coefficients,
           const Terms<Lanes>& terms, Weights<Lanes>* weights) {
  dispatch([=, &lanes, &places, &terms] {
    const auto at = [&](std::size_t i) __attribute__((always_inline))->auto& {
      return lanes.points[i].r;
    };
    for (std::size_t k = 0; k <= 2; ++k) {
      places.load_from(coefficients[k], at);
      lanes.take_coefficient(k);
      for (std::size_t i = 0; i <= lanes.length && terms.is_counting(); ++i) {
        if (k == 0) weights[i].position = terms.weigh(at(i), weights[i].position);
        if (k == 1) weights[i].velocity = terms.weigh(at(i), weights[i].velocity);
      }
    }
    lanes.begin();
  });
}
/// Computes order k + 2. Returns true if no more are needed.
template <class Lanes>
bool advance(const Lanes& lanes, int k, int passes, const Places<Lanes>& places, double* to,
             const Weights<Lanes>* weights, Terms<Lanes>* terms) {
  const bool is_counting = terms->is_counting();
  const auto largest = dispatch([=, &lanes, &places] {
    const auto at = [&](std::size_t i) __attribute__((always_inline))->const auto& {
      return lanes.points[i].r;
    };
    lanes.advance(
        k, passes, [&](std::size_t i) __attribute__((always_inline)) { places.store_inner(i, to, at); });
    places.store_ends(to, at);
    typename Terms<Lanes>::Largest result;
    for (std::size_t i = 0; i <= lanes.length && is_counting; ++i) result.include(at(i), weights[i]);
    return result;
  });
  return is_counting && terms->note(k + 2, largest);
}

/// The arrays of a thread. The caches keep them from one group to the next.
template <std::size_t width>
struct Room {
  using Numbers = PathNumbers<width>;

  void hold(std::size_t length, std::size_t stride) {
    rods.resize(std::max(rods.size(), length));
    points.resize(std::max(points.size(), length + 1));
    weights.resize(points.size());
    series.resize(std::max(series.size(), length * stride));
  }

  std::vector<typename Numbers::Rod> rods;            // [rod]
  std::vector<typename Numbers::Point> points;        // [point]
  std::vector<typename Numbers::Coefficient> series;  // [rod][order]
  std::vector<TermWeights<width>> weights;            // [point]
  std::array<double, width> separator_l{}, separator_inverse_pivot{};
};

/// Returns the points of each path that move.
std::vector<IndexRanges> moving_points(const RodLanes& given, std::span<const double> inverse_mass) {
  std::vector<std::vector<Index>> points(given.is_cut ? 1 : given.width);
  for (std::size_t at = 0; at < given.points.size(); ++at) {
    const Index point = given.points[at];
    if (point >= 0 && inverse_mass[static_cast<std::size_t>(point)] > 0.0)
      points[at % given.width % points.size()].push_back(point);
  }
  std::vector<IndexRanges> result(points.size());
  for (std::size_t path = 0; path < points.size(); ++path) {
    std::ranges::sort(points[path]);
    points[path].erase(std::ranges::unique(points[path]).begin(), points[path].end());
    for (const Index point : points[path]) result[path].append(static_cast<std::size_t>(point));
  }
  return result;
}

/// The contents of the lanes of one PathLanes.
template <std::size_t lanes_wide, bool is_cut>
class Group {
 public:
  static constexpr std::size_t width = lanes_wide;
  using Lanes = PathLanes<width, is_cut>;
  using Lane = typename Lanes::Lane;
  using Vector = typename Lanes::Vector;

  Group(RodLanes given, std::span<const Vec3> offsets, std::span<const double> inverse_mass)
      : given_(std::move(given)),
        places_(given_.points),
        points_(moving_points(given_, inverse_mass)),
        is_there_(given_.rows.size()),
        inverse_mass_(given_.points.size()) {
    for (std::size_t at = 0; at < given_.points.size(); ++at) {
      const Index point = given_.points[at];
      if (point >= 0) inverse_mass_[at] = inverse_mass[static_cast<std::size_t>(point)];
    }
    if (!offsets.empty()) offsets_.resize(given_.length);
    for (std::size_t at = 0; at < given_.rows.size(); ++at) {
      const Index row = given_.rows[at];
      is_there_[at] = row < 0 ? 0.0 : 1.0;
      if (row < 0 || offsets.empty()) continue;
      const double sign = given_.flipped[at] != 0 ? -1.0 : 1.0;
      put(&offsets_[at / width], at % width, sign * offsets[static_cast<std::size_t>(row)]);
    }
  }

  std::size_t length() const { return given_.length; }

  /// Computes the terms that are needed, and sets the others to 0. Returns the longest step for which paths with fewer
  /// terms serve.
  double expand(std::span<double* const> coefficients, const double* lambda, int passes, std::size_t stride,
                const NeededTerms& needed, std::span<std::uint8_t> last_term, Room<width>* room) const {
    const auto take = [](const std::vector<double>& from, std::size_t i, Lane* to) {
      std::memcpy(to, from.data() + i * width, sizeof(Lane));
    };
    for (std::size_t i = 0; i < given_.length; ++i) take(is_there_, i, &room->rods[i].is_there);
    for (std::size_t i = 0; i <= given_.length; ++i) take(inverse_mass_, i, &room->points[i].inverse_mass);
    for (std::size_t at = 0; at < given_.rows.size(); ++at) {
      const Index row = given_.rows[at];
      room->series[at / width * stride].mu[at % width] = row < 0 ? 0.0 : lambda[row];
    }
    const Lanes lanes{given_.length,       stride,
                      room->rods.data(),   room->points.data(),
                      room->series.data(), offsets_.empty() ? nullptr : offsets_.data(),
                      &room->separator_l,  &room->separator_inverse_pivot};
    detail::Terms<Lanes> terms(needed);
    TermWeights<width>* const weights = room->weights.data();
    for (std::size_t at = 0; at < given_.points.size() && terms.is_counting(); ++at)
      terms.read_atol(needed, given_.points[at], at % width, &weights[at / width]);
    detail::begin(lanes, places_, coefficients.first<3>(), terms, weights);
    const int order = static_cast<int>(coefficients.size()) - 1;
    int reached = 2;
    for (bool are_enough = false; !are_enough && reached < order;) {
      const int k = reached++ - 1;
      are_enough = detail::advance(lanes, k, passes, places_, coefficients[reached], weights, &terms);
    }
    double longest = any_length;
    for (std::size_t path = 0; path < points_.size(); ++path) {
      const FoundTerms found = terms.found(path, order);
      longest = std::min(longest, found.longest);
      points_[path].for_each(
          [&](std::size_t begin, std::size_t end) { end_series(found, reached, begin, end, coefficients, last_term); });
    }
    return longest;
  }

 private:
  static void put(Vector* to, std::size_t lane, Vec3 a) {
    to->x[lane] = a.x;
    to->y[lane] = a.y;
    to->z[lane] = a.z;
  }

  RodLanes given_;
  LanePoints<width> places_;
  std::vector<IndexRanges> points_;   // [path] those that move
  std::vector<double> is_there_;      // [rod][lane] 1 or 0
  std::vector<double> inverse_mass_;  // [point][lane]
  std::vector<Vector> offsets_;       // [rod] part of a_0; empty if there are none
};

}  // namespace

struct PathSeries::AnyGroup {
  std::variant<Group<RodLanes::most, true>, Group<RodLanes::most, false>, Group<RodLanes::few, false>> group;
};

struct PathSeries::Rooms {
  Room<RodLanes::most> most;
  Room<RodLanes::few> few;

  Room<RodLanes::most>& of_width(std::integral_constant<std::size_t, RodLanes::most>) { return most; }
  Room<RodLanes::few>& of_width(std::integral_constant<std::size_t, RodLanes::few>) { return few; }
};

PathSeries::~PathSeries() = default;

std::size_t PathSeries::num_groups() const {
  return groups_.size();
}

PathSeries::PathSeries(const RodRows& rods, const Numbering& numbering, std::span<const double> inverse_mass,
                       std::vector<Index>* islands) {
  for (RodLanes& given : lay_rods(rods, numbering, islands)) {
    if (given.is_cut) {
      groups_.push_back({Group<RodLanes::most, true>(std::move(given), rods.offset, inverse_mass)});
    } else if (given.width == RodLanes::most) {
      groups_.push_back({Group<RodLanes::most, false>(std::move(given), rods.offset, inverse_mass)});
    } else {
      groups_.push_back({Group<RodLanes::few, false>(std::move(given), rods.offset, inverse_mass)});
    }
  }
}

double PathSeries::expand(const Parallel& parallel, std::span<double* const> coefficients, const double* lambda,
                          int passes, const NeededTerms& needed, std::span<std::uint8_t> last_term) {
  const std::size_t stride =
      coefficients.size() | 1;  // with a power of 2, rods would meet in the same few lines of the caches
  rooms_.resize(static_cast<std::size_t>(parallel.threads()));
  const auto with_room = [&](Rooms* rooms, const AnyGroup& any, const auto& visit) {
    std::visit(
        [&](const auto& group) {
          using Width = std::integral_constant<std::size_t, std::decay_t<decltype(group)>::width>;
          visit(group, &rooms->of_width(Width()));
        },
        any.group);
  };
  for (Rooms& rooms : rooms_) {
    for (const AnyGroup& any : groups_)
      with_room(&rooms, any, [&](const auto& group, auto* room) { room->hold(group.length(), stride); });
  }
  longest_.assign(groups_.size(), 0.0);
  parallel.for_tasks(groups_.size(), [&](std::size_t g, std::size_t thread) {
    with_room(&rooms_[thread], groups_[g], [&](const auto& group, auto* room) {
      longest_[g] = group.expand(coefficients, lambda, passes, stride, needed, last_term, room);
    });
  });
  return std::ranges::min(longest_);
}

}  // namespace tanor::detail
