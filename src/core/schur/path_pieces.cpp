#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "plan/thresholds.hpp"
#include "schur/lane_plan.hpp"

namespace tanor::detail {

namespace {

/// Cuts paths. The rods between moving points are in pieces of nearly the same length, eight a group. A few rods are
/// left over; those and the ones at supports are pieces by themselves, which short paths put into groups together.
class PathCutter {
 public:
  explicit PathCutter(LanePlan* plan) : plan_(*plan) {}

  void add(const RodPath& path) {
    constexpr std::size_t rods_of_grove = num_lanes * plan::most_rods_of_piece;
    if (num_rods_ > 0 && num_rods_ + path.num_rows() > rods_of_grove) end_grove();
    num_rods_ += path.num_rows();
    plan_.num_rods += path.num_rows();
    plan_.islands.push_back({path.first_point, path.end_point});
    const auto is_own = [&](Index point) { return point >= path.first_point && point < path.end_point; };

    const std::size_t begin = is_own(path.points.front()) ? 0 : 1,
                      at_end = !path.is_ring && is_own(path.points.back()) ? 0 : 1,
                      end = std::max(begin, path.num_rows() - at_end), num_between = end - begin;
    const std::size_t in_lanes = num_between < plan::fewest_rods_in_lanes ? 0 : num_between / num_lanes;  // rods a lane
    const std::size_t count = (in_lanes + plan::most_rods_of_piece - 1) / plan::most_rods_of_piece;
    const std::size_t first_separator = plan_.separators.size();
    std::size_t row = 0;
    const auto next = [&](std::size_t length) {
      const auto first = path.points.begin() + static_cast<std::ptrdiff_t>(row);
      Piece piece{path.first_row + static_cast<Index>(row),
                  static_cast<Index>(plan_.islands.size()) - 1,
                  plan_.separators.size(),
                  {first, first + length + 1}};
      plan_.separators.push_back(-1);
      row += length;
      Index &front = piece.points.front(), &back = piece.points.back();
      piece.has_support = !is_own(front) || !is_own(back);
      if (!is_own(front)) front = ~front;
      // The end of an open path is no other piece's.
      if (row < path.num_rows() || path.is_ring || !is_own(back)) back = ~back;
      return piece;
    };
    while (row < begin) alone_.push_back(next(1));
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t length = in_lanes * (k + 1) / count - in_lanes * k / count;
      std::vector<Piece> pieces;
      while (pieces.size() < num_lanes) pieces.push_back(next(length));
      add_group(pieces, length);
    }
    while (row < path.num_rows()) alone_.push_back(next(1));
    const std::size_t end_separator = plan_.separators.size();
    plan_.paths.push_back({first_separator, end_separator, path.is_ring});
    // Each separator of a ring has a product with the closing rod.
    ++plan_.factor.parts;
    plan_.factor.pattern_nonzeros += 2 * path.num_rows() - (path.is_ring ? 0 : 1);
    plan_.factor.factor_nonzeros += 2 * path.num_rows() - 1 + (path.is_ring ? end_separator - first_separator : 0);
    plan_.factor.flops += flops_a_rod * static_cast<double>(path.num_rows());
  }
  void end_grove() {
    for (std::size_t k = 0; k < alone_.size(); k += num_lanes)
      add_group(std::span(alone_).subspan(k, std::min(num_lanes, alone_.size() - k)), 1);
    alone_.clear();
    num_rods_ = 0;
    for (std::size_t path = plan_.island_start.back(); path < plan_.paths.size(); ++path) {
      const auto [first, last, is_ring] = plan_.paths[path];
      for (std::size_t q = first; q < last; ++q) {
        const auto slot = static_cast<std::size_t>(plan_.separators[q]);
        plan_.groups[slot / num_lanes].behind[slot % num_lanes] = q + 1 < last ? plan_.separators[q + 1]
                                                                  : is_ring    ? plan_.separators[first]
                                                                               : -1;
      }
    }
    plan_.end_level();
    plan_.end_grove();
  }

 private:
  static constexpr std::size_t packs_of_factor = 3;  // see lanes::PathFactor
  static constexpr double flops_a_rod = 9.0;

  struct Piece {
    Index first_row, island;
    std::size_t separator;
    std::vector<Index> points;  // as in LanePlan
    bool has_support = false;
  };

  void add_group(std::span<const Piece> pieces, std::size_t length) {
    LaneGroup& group = plan_.add({.num_rods = length,
                                  .num_places = length + 1,
                                  .num_members = pieces.size(),
                                  .is_padded = pieces.size() < num_lanes,
                                  .stands_alone = false},
                                 length * packs_of_factor);
    for (std::size_t lane = 0; lane < num_lanes; ++lane) {
      const bool is_there = lane < pieces.size();
      const Piece& piece = is_there ? pieces[lane] : pieces.back();
      const std::size_t first_place = num_lanes * group.first_place + lane,
                        first_rod = num_lanes * group.first_rod + lane;
      const Index front = piece.points.front();
      for (std::size_t k = 0; k <= length; ++k)
        plan_.point[first_place + num_lanes * k] = is_there ? piece.points[k] : front < 0 ? front : ~front;
      for (std::size_t k = 0; is_there && k < length; ++k)
        plan_.row[first_rod + num_lanes * k] = piece.first_row + static_cast<Index>(k);
      group.island[lane] = piece.island;
      group.has_supports = group.has_supports || piece.has_support;
      if (is_there)
        plan_.separators[piece.separator] = static_cast<Index>(num_lanes * (plan_.groups.size() - 1) + lane);
    }
  }

  LanePlan& plan_;
  std::vector<Piece> alone_;
  std::size_t num_rods_ = 0;  // of the grove so far
};

}  // namespace

LanePlan take_paths(const RodRows& rods, const Numbering& numbering, bool, std::vector<Index>* islands) {
  LanePlan result;
  result.program = Program::Paths;
  PathCutter cutter(&result);
  std::erase_if(*islands, [&](Index island) {
    const std::optional<RodPath> path = find_path(rods.ends, numbering, island);
    if (path) cutter.add(*path);
    return path.has_value();
  });
  if (result.num_rods > 0) cutter.end_grove();
  const auto add = [&](std::ptrdiff_t count, const std::string& what) {
    if (count == 0) return;
    result.reason += (result.reason.empty() ? "" : ", ") +
                     (count == 1 ? "one " + what : std::to_string(count) + " " + what + "s") + " of rods";
  };
  const std::ptrdiff_t num_rings = std::ranges::count_if(result.paths, &LanePlan::Path::is_ring);
  add(std::ssize(result.paths) - num_rings, "path");
  add(num_rings, "ring");
  return result;
}

}  // namespace tanor::detail
