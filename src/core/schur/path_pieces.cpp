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
    plan_.islands.push_back({static_cast<Index>(path.first_point()), static_cast<Index>(path.end_point())});

    const std::size_t begin = path.first + (path.left_support >= 0 ? 1 : 0),
                      end = std::max(begin, path.end - (path.right_support >= 0 ? 1 : 0)), num_between = end - begin;
    const std::size_t in_lanes = num_between < plan::fewest_rods_in_lanes ? 0 : num_between / num_lanes;  // rods a lane
    const std::size_t count = (in_lanes + plan::most_rods_of_piece - 1) / plan::most_rods_of_piece;
    const std::size_t first_separator = plan_.num_separators();
    std::size_t separator = first_separator;
    std::size_t row = path.first;
    const auto next = [&](std::size_t length) {
      const Piece result{path, row, separator++, static_cast<Index>(plan_.islands.size()) - 1};
      row += length;
      return result;
    };
    while (row < begin) alone_.push_back(next(1));
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t length = in_lanes * (k + 1) / count - in_lanes * k / count;
      std::vector<Piece> pieces;
      while (pieces.size() < num_lanes) pieces.push_back(next(length));
      add_group(pieces, length);
    }
    while (row < path.first + path.num_rows()) alone_.push_back(next(1));
    plan_.paths.push_back({first_separator, separator, path.is_ring});
    // Each separator of a ring has a product with the closing rod.
    ++plan_.factor.parts;
    plan_.factor.pattern_nonzeros += 2 * path.num_rows() - (path.is_ring ? 0 : 1);
    plan_.factor.factor_nonzeros += 2 * path.num_rows() - 1 + (path.is_ring ? separator - first_separator : 0);
    plan_.factor.flops += flops_a_rod * static_cast<double>(path.num_rows());
  }
  void end_grove() {
    for (std::size_t k = 0; k < alone_.size(); k += num_lanes)
      add_group(std::span(alone_).subspan(k, std::min(num_lanes, alone_.size() - k)), 1);
    alone_.clear();
    num_rods_ = 0;
    plan_.end_level();
    plan_.end_grove();
  }

 private:
  static constexpr std::size_t packs_of_factor = 3;  // see lanes::PathFactor
  static constexpr double flops_a_rod = 9.0;

  struct Piece {
    RodPath path;
    std::size_t first_row, separator;
    Index island;
  };

  void add_group(std::span<const Piece> pieces, std::size_t length) {
    LaneGroup& group = plan_.add({.num_rods = length,
                                  .num_places = length + 1,
                                  .num_members = pieces.size(),
                                  .is_padded = pieces.size() < num_lanes,
                                  .stands_alone = false},
                                 length * packs_of_factor);
    for (std::size_t lane = 0; lane < num_lanes; ++lane)
      add_piece(pieces[std::min(lane, pieces.size() - 1)], lane < pieces.size(), lane, &group);
  }

  void add_piece(const Piece& piece, bool is_there, std::size_t lane, LaneGroup* group) {
    const RodPath& path = piece.path;
    const std::size_t length = group->num_rods;
    Index* const point = plan_.point.data() + num_lanes * group->first_place + lane;
    Index* const row = plan_.row.data() + num_lanes * group->first_rod + lane;
    const auto first = static_cast<Index>(path.left_point(piece.first_row));
    const bool begins_at_support = path.begins_at_support(piece.first_row);
    const std::size_t end_row = piece.first_row + length;
    // Says whether the last point is the end of an open path, which no other piece has.
    const bool has_end = !path.is_ring && end_row == path.end && path.right_support < 0;
    point[0] = is_there && !begins_at_support ? first : ~first;
    for (std::size_t k = 1; k <= length; ++k) {
      const auto next = static_cast<Index>(path.right_point(piece.first_row + k - 1));
      point[num_lanes * k] = !is_there ? ~first : k < length || has_end ? next : ~next;
      if (is_there) row[num_lanes * (k - 1)] = static_cast<Index>(piece.first_row + k - 1);
    }
    group->island[lane] = piece.island;
    group->ends_island[lane] = end_row == path.first + path.num_rows();
    group->has_supports = group->has_supports || begins_at_support || path.ends_at_support(end_row - 1);
    if (is_there) group->separator[lane] = piece.separator;
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
