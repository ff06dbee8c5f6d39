#include "schur/path_rows.hpp"

#include <algorithm>

#include "plan/thresholds.hpp"

namespace tanor::detail {

PathRows::PathRows(const SchurProblem& problem, std::vector<Index>* islands) : inverse_mass(problem.inverse_mass) {
  const Numbering& numbering = problem.numbering;
  RodRows rods(problem.constraints, numbering.num_rows());
  sign.assign(numbering.num_rows(), 1);
  std::erase_if(*islands, [&](Index island) {
    const std::optional<RodPath> path = find_path(rods.ends, numbering, island);
    if (!path) return false;
    for (std::size_t row = path->first; row < path->first + path->num_rows(); ++row)
      sign[row] = rods.ends[row][0] == static_cast<Index>(path->left_point(row)) ? 1 : -1;
    cut(*path);
    return true;
  });
  if (paths.empty()) return;
  read_offsets(rods.offset);
  length.resize(sign.size());
  lengths.resize(num_slots);
  for (std::size_t row = 0; row < length.size(); ++row) set_length(row, rods.constant_length[row]);
  moving_lengths = std::move(rods.lengths);
  find_signs(rods);
}

/// Cuts the rods between moving points into pieces of nearly the same length. A few rods are left over; those and the
/// ones at supports are alone.
void PathRows::cut(const RodPath& path) {
  Cut result{path, pieces.size(), 0, num_separators, 0, alone.size(), 0};
  const std::size_t begin = path.first + (path.left_support >= 0 ? 1 : 0),
                    end = std::max(begin, path.end - (path.right_support >= 0 ? 1 : 0));
  const std::size_t num_between = end - begin;
  const std::size_t in_lanes = num_between < plan::fewest_rods_in_lanes ? 0 : num_between / num_lanes;  // rods a lane
  const std::size_t count = (in_lanes + plan::most_rods_of_piece - 1) / plan::most_rods_of_piece;
  const auto add_alone = [&](std::size_t first, std::size_t last) {
    for (std::size_t row = first; row < last; ++row) alone.push_back({row, num_separators++});
  };
  add_alone(path.first, begin);
  std::size_t row = begin;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t rods = in_lanes * (k + 1) / count - in_lanes * k / count;
    pieces.push_back({row, path.left_point(row), rods, num_slots, num_separators});
    row += num_lanes * rods;
    num_slots += rods + 1;
    num_separators += num_lanes;
    most_rods = std::max(most_rods, rods);
  }
  add_alone(row, path.first + path.num_rows());
  result.end_pieces = pieces.size();
  result.end_separator = num_separators;
  result.end_alone = alone.size();
  if (path.is_ring) ++num_rings;
  paths.push_back(result);
}

void PathRows::find_signs(const RodRows& rods) {
  first_block_ = rods.block[0];
  const std::size_t num_rows = sign.size();
  for (std::size_t row = 0; row < num_rows && block_numbers_.empty(); ++row) {
    if (rods.block[row] != first_block_ + row) block_numbers_ = rods.block;
  }
  const bool have_one_sign = std::ranges::count(sign, sign[0]) == std::ssize(sign);
  if (have_one_sign && block_numbers_.empty()) {
    common_sign_ = sign[0];
    return;
  }
  places_.resize(num_slots * num_lanes);
  for (const PathPieces& of : pieces) {
    for (std::size_t k = 0; k < of.length * num_lanes; ++k) {
      const std::size_t row = of.first_row + k % num_lanes * of.length + k / num_lanes;
      const auto own = static_cast<Index>(block(row));
      places_[of.first_slot * num_lanes + k] = sign[row] > 0 ? own : ~own;
    }
  }
}

void PathRows::read_offsets(std::span<const Vec3> offsets) {
  offset.assign(offsets.begin(), offsets.end());
  for (std::size_t row = 0; row < offset.size(); ++row) offset[row] = sign[row] * offset[row];
}

void PathRows::set_length(std::size_t row, double value) {
  length[row] = value;
  const auto after = std::ranges::upper_bound(pieces, row, {}, &PathPieces::first_row);
  if (after == pieces.begin()) return;
  const PathPieces& of = *std::prev(after);
  const std::size_t place = row - of.first_row;
  if (place < of.num_points()) lengths.data()[of.first_slot + place % of.length][place / of.length] = value;
}

void PathRows::take_lengths() {
  for (const auto& [row, moving] : moving_lengths) set_length(row, moving->value);
}

// ---- one rod ----

Vec3 PathRows::distance(const RodPath& path, std::size_t row, const double* r) const {
  const Vec3 a = load(r, path.right_point(row)) - load(r, path.left_point(row));
  return offset.empty() ? a : a + offset[row];
}

double PathRows::length_change(std::size_t row, double MovingScalar::*part) const {
  const auto found = std::ranges::lower_bound(moving_lengths, row, {}, [](const auto& each) { return each.first; });
  return found != moving_lengths.end() && found->first == row ? found->second->*part : 0.0;
}

// ---- the rods of pieces ----

void PathRows::read_directions(const PathPieces& of, const double* blocks, Pack3<>* u) const {
  if (!places_.empty()) return gather_blocks(blocks, &places_[of.first_slot * num_lanes], of.length, u);
  gather_sequences(blocks, of.sequences(first_block_ + of.first_row, of.length, common_sign_), 3, &u->x);
}

void PathRows::write_directions(const PathPieces& of, const Pack3<>* u, double* blocks) const {
  if (!places_.empty()) return scatter_blocks(u, &places_[of.first_slot * num_lanes], of.length, blocks);
  scatter_sequences(&u->x, of.sequences(first_block_ + of.first_row, of.length, common_sign_), 3, blocks);
}

bool PathRows::read_length_changes(const PathPieces& of, double MovingScalar::*part, Pack<>* to) const {
  if (moving_lengths.empty()) return false;
  std::fill_n(to, of.length, Pack<>{});
  const std::size_t end = of.first_row + of.num_points();
  for (auto l = std::ranges::lower_bound(moving_lengths, of.first_row, {}, [](const auto& each) { return each.first; });
       l != moving_lengths.end() && l->first < end; ++l) {
    const std::size_t place = l->first - of.first_row;
    to[place % of.length][place / of.length] = l->second->*part;
  }
  return true;
}

}  // namespace tanor::detail
