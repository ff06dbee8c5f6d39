#include "host/row_sums.hpp"

#include <algorithm>
#include <cmath>

namespace tanor::detail {

namespace {

constexpr std::size_t num_parts = 64;  // partial sums, whatever the number of threads

std::size_t largest_of(const std::vector<double>& rows, const auto& size) {
  std::size_t worst = 0;
  double largest = -1.0;
  for (std::size_t a = 0; a < rows.size(); ++a) {
    const double own = size(a);
    if (!(own <= largest)) {
      worst = a;
      largest = own;
    }
    if (std::isnan(own)) break;
  }
  return worst;
}

}  // namespace

std::vector<RodRow> list_rods(const Workspace& work) {
  const Model& model = work.model();
  std::vector<RodRow> result;
  std::vector<Index> first_of_block(work.constraints.num_blocks(), -1);
  for (const Incidence& incidence : model.incidences) {
    if (incidence.sign < 0.0) first_of_block[static_cast<std::size_t>(incidence.block)] = incidence.point;
  }
  for (const Incidence& incidence : model.incidences) {
    const Index first = first_of_block[static_cast<std::size_t>(incidence.block)];
    if (first >= 0 && incidence.sign > 0.0) result.push_back({incidence.row, incidence.block, first, incidence.point});
  }
  return result;
}

RowSums::RowSums(const Workspace& work)
    : work_(work), model_(work.model()), rods_(list_rods(work)), lengths_(model_.num_rows(), 1.0) {
  std::vector<char> is_rod(model_.num_rows(), 0);
  for (const RodRow& rod : rods_) is_rod[static_cast<std::size_t>(rod.row)] = 1;
  others_ = Groups<End>(model_.num_rows(), [&](const auto& add) {
    for (const Incidence& incidence : model_.incidences) {
      if (is_rod[static_cast<std::size_t>(incidence.row)] == 0)
        add(incidence.row, End{incidence.point, incidence.block, incidence.sign});
    }
  });
  for (std::size_t a = 0; a < model_.num_rows(); ++a) {
    if (is_rod[a] == 0) other_rows_.push_back(static_cast<Index>(a));
  }
}

const std::vector<double>& RowSums::lengths() {
  if (!knows_lengths_) work_.constraints.write_lengths(lengths_.data());
  knows_lengths_ = !work_.constraints.depends_on_time();
  return lengths_;
}

/// Sums lambda L u (x) u over some rods. The tensor is symmetric, and its lower half stays 0, which halves the work.
Block3 RowSums::sum_rod_virials(std::span<const RodRow> rods, const double* lambda, double factor,
                                const double* blocks) const {
  Vec3 first{}, second{}, third{};  // its rows, as far as they are summed
  for (const RodRow& rod : rods) {
    const Vec3 u = load(blocks, rod.block);
    const Vec3 force = (factor * lambda[rod.row] * lengths_[static_cast<std::size_t>(rod.row)]) * u;
    first = first + force.x * u;
    second = second + force.y * Vec3{0.0, u.y, u.z};
    third.z += force.z * u.z;
  }
  return {{first.x, first.y, first.z, 0.0, second.y, second.z, 0.0, 0.0, third.z}};
}

/// Calls add(point, its part of the row's virial).
template <class Add>
void RowSums::split_row(std::size_t row, double lambda, const double* blocks, const double* r, const Add& add) const {
  const std::span<const End> ends = others_[row];
  const double part = 1.0 / static_cast<double>(ends.size());
  Vec3 centroid{}, sum{};
  for (const End& end : ends) {
    centroid = centroid + part * load(r, end.point);
    sum = sum + (lambda * end.sign) * load(blocks, end.block);
  }
  for (const End& end : ends) {
    Block3 own;
    own.add_product(1.0, load(r, end.point) - centroid, (lambda * end.sign) * load(blocks, end.block));
    own.add_product(part, centroid, sum);
    add(end.point, own);
  }
}

std::array<double, 6> RowSums::virial(const double* lambda, double factor, const double* blocks, const double* r) {
  (void)lengths();
  std::array<Block3, num_parts> parts;
  const std::size_t num_rods = rods_.size(), num_others = other_rows_.size(), count = num_rods + num_others;
  const auto add = [](const Block3& b, Block3* to) {
    for (std::size_t k = 0; k < 9; ++k) to->entries[k] += b.entries[k];
  };
  const auto add_parts = [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const std::span rods(rods_.begin() + num_rods * p / num_parts, rods_.begin() + num_rods * (p + 1) / num_parts);
      Block3 sum = sum_rod_virials(rods, lambda, factor, blocks);
      for (std::size_t k = num_others * p / num_parts; k < num_others * (p + 1) / num_parts; ++k) {
        const auto row = static_cast<std::size_t>(other_rows_[k]);
        split_row(row, factor * lambda[row], blocks, r, [&](Index, const Block3& own) { add(own, &sum); });
      }
      parts[p] = sum;
    }
  };
  model_.parallel.for_ranges(num_parts, add_parts, std::max<std::size_t>(1, num_parts * 2048 / (count + 1)));
  Block3 all;
  for (const Block3& part : parts) add(part, &all);
  return {all(0, 0), all(1, 1), all(2, 2), all(0, 1), all(0, 2), all(1, 2)};
}

void RowSums::share_virial(const double* lambda, double factor, const double* blocks, const double* r, double* stress) {
  (void)lengths();
  std::fill(stress, stress + 9 * model_.num_points(), 0.0);
  const auto add = [&](Index point, double part, const Block3& own) {
    for (std::size_t k = 0; k < 9; ++k) stress[9 * static_cast<std::size_t>(point) + k] += part * own.entries[k];
  };
  for (const RodRow& rod : rods_) {
    const Vec3 u = load(blocks, rod.block);
    Block3 own;
    own.add_product(factor * lambda[rod.row] * lengths_[static_cast<std::size_t>(rod.row)], u, u);
    add(rod.i, 0.5, own);
    add(rod.j, 0.5, own);
  }
  for (const Index row : other_rows_) {
    split_row(static_cast<std::size_t>(row), factor * lambda[row], blocks, r,
              [&](Index point, const Block3& own) { add(point, 1.0, own); });
  }
}

double RowSums::largest_turn(const double* blocks, const double* r_old, const double* r,
                             std::span<const Constraints::RowOffset> changes) {
  (void)lengths();
  const auto change = [&](Index row) {
    const auto found =
        std::ranges::lower_bound(changes, static_cast<std::size_t>(row), {}, &Constraints::RowOffset::row);
    return found != changes.end() && found->row == static_cast<std::size_t>(row) ? found->offset : Vec3{};
  };
  return model_.parallel.max_over_ranges(rods_.size(), [&](std::size_t begin, std::size_t end) {
    double largest = 0.0, tangent = 0.0;
    for (std::size_t k = begin; k < end; ++k) {
      const auto& [row, block, i, j] = rods_[k];
      const Vec3 u = load(blocks, block);
      Vec3 move = (load(r, j) - load(r_old, j)) - (load(r, i) - load(r_old, i));
      if (!changes.empty()) move = move + change(row);
      const double along = dot(u, move), ahead = lengths_[static_cast<std::size_t>(row)] + along;
      const Vec3 across = move - along * u;
      const double square = dot(across, across);
      if (ahead > 0.0 && square <= tangent * tangent * ahead * ahead) continue;
      const double angle = std::atan2(std::sqrt(square), ahead);
      largest = larger(largest, angle);
      if (ahead > 0.0) tangent = std::max(tangent, std::sqrt(square) / ahead);
    }
    return largest;
  });
}

std::size_t RowSums::worst_position_row(const std::vector<double>& rows) {
  (void)lengths();
  return largest_of(rows, [&](std::size_t a) { return std::abs(rows[a]) / lengths_[a]; });
}

std::size_t RowSums::worst_row(const std::vector<double>& rows) {
  return largest_of(rows, [&](std::size_t a) { return std::abs(rows[a]); });
}

}  // namespace tanor::detail
