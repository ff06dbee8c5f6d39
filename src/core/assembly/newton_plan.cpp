#include "assembly/newton_plan.hpp"

#include <algorithm>
#include <complex>

namespace tanor::detail {

NewtonPlan::NewtonPlan(std::span<const double> masses, std::size_t num_rows, std::span<const Coupling> couplings,
                       std::span<const Influence> influences, std::span<const Incidence> incidences,
                       std::span<const Compliance> compliances, bool rows_may_depend)
    : masses_(masses.begin(), masses.end()),
      diagonal_(num_rows),
      compliances_(compliances.begin(), compliances.end()),
      rows_may_depend_(rows_may_depend) {
  list_entries(couplings, influences, incidences);
  make_pattern();
  find_slots();
}

void NewtonPlan::list_entries(std::span<const Coupling> couplings, std::span<const Influence> influences,
                              std::span<const Incidence> incidences) {
  const int num_points = static_cast<int>(masses_.size());
  for (const auto& [i, j] : couplings)
    couplings_.push_back({{i < num_points ? i : -1, j < num_points ? j : -1}, {}, {}});
  for (std::size_t k = 0; k < influences.size(); ++k) {
    if (influences[k].on < num_points && influences[k].of < num_points) influences_.push_back({influences[k], k, {}});
  }
  for (const Incidence& incidence : incidences) {
    if (incidence.point < num_points)
      entries_.push_back({incidence.point, incidence.row, incidence.block, incidence.sign, 0, {}});
  }
}

void NewtonPlan::make_pattern() {
  std::vector<std::vector<int>> columns(static_cast<std::size_t>(first_row()) + diagonal_.size());
  const auto add_block = [&](int i, int j) {
    for (int c = 0; c < 3; ++c) {
      for (int a = 0; a < 3; ++a) columns[static_cast<std::size_t>(3 * j + c)].push_back(3 * i + a);
    }
  };
  for (int i = 0; i < static_cast<int>(masses_.size()); ++i) add_block(i, i);
  for (const CoupledPoints& coupling : couplings_) {
    const auto [i, j] = coupling.points;
    if (i < 0 || j < 0) continue;
    add_block(i, j);
    add_block(j, i);
  }
  for (const InfluencedPoint& influence : influences_) {
    // Both blocks are added, because the factorization orders the points by a symmetric pattern.
    add_block(influence.points.on, influence.points.of);
    add_block(influence.points.of, influence.points.on);
  }
  for (const RowEntry& entry : entries_) {
    const int row = first_row() + entry.row;
    for (int c = 0; c < 3; ++c) {
      columns[static_cast<std::size_t>(row)].push_back(3 * entry.point + c);
      columns[static_cast<std::size_t>(3 * entry.point + c)].push_back(row);
    }
  }
  for (std::size_t row = static_cast<std::size_t>(first_row()); row < columns.size(); ++row)
    columns[row].push_back(static_cast<int>(row));

  start_.push_back(0);
  for (std::vector<int>& column : columns) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
    rows_.insert(rows_.end(), column.begin(), column.end());
    start_.push_back(static_cast<int>(rows_.size()));
  }
}

void NewtonPlan::find_slots() {
  const auto slot = [&](int row, int column) {
    const auto begin = rows_.begin() + start_[static_cast<std::size_t>(column)];
    const auto end = rows_.begin() + start_[static_cast<std::size_t>(column) + 1];
    return static_cast<int>(std::lower_bound(begin, end, row) - rows_.begin());
  };
  const auto block = [&](int i, int j) {
    return Columns{slot(3 * i, 3 * j), slot(3 * i, 3 * j + 1), slot(3 * i, 3 * j + 2)};
  };
  for (int i = 0; i < static_cast<int>(masses_.size()); ++i) own_.push_back(block(i, i));
  for (CoupledPoints& coupling : couplings_) {
    const auto [i, j] = coupling.points;
    if (i < 0 || j < 0) continue;
    coupling.ij = block(i, j);
    coupling.ji = block(j, i);
  }
  for (InfluencedPoint& influence : influences_) influence.at = block(influence.points.on, influence.points.of);
  for (RowEntry& entry : entries_) {
    const int row = first_row() + entry.row, first = 3 * entry.point;
    entry.below = slot(first, row);
    entry.transposed = {slot(row, first), slot(row, first + 1), slot(row, first + 2)};
  }
  for (std::size_t a = 0; a < diagonal_.size(); ++a) {
    const int row = first_row() + static_cast<int>(a);
    diagonal_[a] = slot(row, row);
  }
}

template <class T>
void NewtonPlan::assemble(const Weights<T>& weights, const Values& values, T* entries) const {
  std::fill(entries, entries + rows_.size(), T(0.0));
  // -b B_v - c B_r
  const auto combine = [&](const Block3& by_position, const Block3& by_velocity, std::size_t entry) {
    return -weights.velocity * by_velocity.entries[entry] - weights.position * by_position.entries[entry];
  };
  const auto add = [&](const Columns& columns, double sign, const Block3& by_position, const Block3& by_velocity) {
    for (std::size_t entry = 0; entry < 9; ++entry) {
      entries[columns[entry % 3] + static_cast<int>(entry / 3)] += sign * combine(by_position, by_velocity, entry);
    }
  };
  for (std::size_t i = 0; i < masses_.size(); ++i) {
    add(own_[i], 1.0, values.point_positions[i], values.point_velocities[i]);
    for (int c = 0; c < 3; ++c) entries[own_[i][static_cast<std::size_t>(c)] + c] += weights.mass * masses_[i];
  }
  for (std::size_t k = 0; k < couplings_.size(); ++k) {
    const auto& [points, ij, ji] = couplings_[k];
    const Block3 &by_position = values.coupling_positions[k], &by_velocity = values.coupling_velocities[k];
    if (points.i >= 0) add(own_[static_cast<std::size_t>(points.i)], 1.0, by_position, by_velocity);
    if (points.j >= 0) add(own_[static_cast<std::size_t>(points.j)], 1.0, by_position, by_velocity);
    if (points.i < 0 || points.j < 0) continue;
    add(ij, -1.0, by_position, by_velocity);
    add(ji, -1.0, by_position, by_velocity);
  }
  for (const auto& [points, number, at] : influences_)
    add(at, 1.0, values.influence_positions[number], values.influence_velocities[number]);
  const double compliance = rows_may_depend_ ? 1e-10 : 0.0;  // relative to the diagonal of the row's points
  const std::size_t num_stiff = diagonal_.size() - compliances_.size();
  for (const auto& [point, row, block, sign, below, transposed] : entries_) {
    const Vec3 g = sign * load(values.blocks, block);
    const std::array<double, 3> gradient{g.x, g.y, g.z};
    T trace = 0.0;
    for (int c = 0; c < 3; ++c) {
      const auto at = static_cast<std::size_t>(c);
      entries[below + c] -= gradient[at];
      entries[transposed[at]] += gradient[at];
      trace += entries[own_[static_cast<std::size_t>(point)][at] + c];
    }
    const auto at_row = static_cast<std::size_t>(row);
    if (at_row < num_stiff) entries[diagonal_[at_row]] += 3.0 * compliance * dot(g, g) / std::abs(trace);
  }
  for (std::size_t k = 0; k < compliances_.size(); ++k) {
    entries[diagonal_[num_stiff + k]] =
        1.0 / (weights.velocity * compliances_[k].damping + weights.position * compliances_[k].stiffness);
  }
}

template void NewtonPlan::assemble(const Weights<double>&, const Values&, double*) const;
template void NewtonPlan::assemble(const Weights<std::complex<double>>&, const Values&, std::complex<double>*) const;

void NewtonPlan::add_stiffness(const Values& values, const double* x, double* y) const {
  const auto add = [y](int i, Vec3 force) { store(y, i, load(y, i) + force); };
  for (std::size_t i = 0; i < masses_.size(); ++i) add(static_cast<int>(i), values.point_positions[i] * load(x, i));
  for (std::size_t k = 0; k < couplings_.size(); ++k) {
    const auto [i, j] = couplings_[k].points;
    const Vec3 moved = (j >= 0 ? load(x, j) : Vec3{}) - (i >= 0 ? load(x, i) : Vec3{});
    const Vec3 force = values.coupling_positions[k] * moved;
    if (j >= 0) add(j, force);
    if (i >= 0) add(i, -force);
  }
  for (const auto& [points, number, at] : influences_)
    add(points.on, values.influence_positions[number] * load(x, points.of));
}

}  // namespace tanor::detail
