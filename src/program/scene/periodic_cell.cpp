#include "scene/periodic_cell.hpp"

#include <cmath>

namespace tanor::scene {
namespace {

Vector3 subtract(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

}  // namespace

Vector3 shift_of(const Cell& cell, const std::array<std::int64_t, 3>& images) {
  const auto a = static_cast<double>(images[0]), b = static_cast<double>(images[1]), c = static_cast<double>(images[2]);
  return {a * cell.xx + b * cell.xy + c * cell.xz, b * cell.yy + c * cell.yz, c * cell.zz};
}

std::array<std::int64_t, 3> nearest_images(const Cell& cell, Vector3 d) {
  const auto nearest = [](double distance, double edge) -> std::int64_t {
    return edge > 0.0 ? std::llround(distance / edge) : 0;
  };
  // Only c reaches along z, and then only b along y, because the cell is lower triangular.
  const std::int64_t c = nearest(d[2], cell.zz);
  const std::int64_t b = nearest(d[1] - static_cast<double>(c) * cell.yz, cell.yy);
  const std::int64_t a = nearest(d[0] - static_cast<double>(c) * cell.xz - static_cast<double>(b) * cell.xy, cell.xx);
  return {a, b, c};
}

Vector3 between(const std::vector<Vector3>& positions, std::int32_t i, std::int32_t j) {
  return subtract(positions[static_cast<std::size_t>(j)], positions[static_cast<std::size_t>(i)]);
}

bool are_side_by_side(const Cell& cell, const std::vector<Vector3>& positions, std::int32_t i, std::int32_t j) {
  return nearest_images(cell, between(positions, i, j)) == std::array<std::int64_t, 3>{};
}

std::vector<Vector3> join_molecules(const Cell& cell, const std::vector<std::array<std::int32_t, 2>>& bonds,
                                    std::vector<Vector3>* positions) {
  // The neighbours of atom i are neighbours[starts[i]] … neighbours[starts[i + 1] - 1].
  const std::size_t num_atoms = positions->size();
  std::vector<std::size_t> starts(num_atoms + 2);
  for (const auto& bond : bonds)
    for (const std::int32_t atom : bond) ++starts[static_cast<std::size_t>(atom) + 2];
  for (std::size_t k = 2; k < starts.size(); ++k) starts[k] += starts[k - 1];
  std::vector<std::int32_t> neighbours(2 * bonds.size());
  for (const auto& [i, j] : bonds) {
    neighbours[starts[static_cast<std::size_t>(i) + 1]++] = j;
    neighbours[starts[static_cast<std::size_t>(j) + 1]++] = i;
  }

  // Returns the shift from the image of `to` nearest to `from`; it is exactly 0 if `to` is that image.
  const auto excess = [&](const Vector3& from, const Vector3& to) {
    return shift_of(cell, nearest_images(cell, subtract(to, from)));
  };
  std::vector<bool> is_placed(num_atoms);
  std::vector<std::size_t> front;
  for (std::size_t root = 0; root < num_atoms; ++root) {
    if (is_placed[root]) continue;
    is_placed[root] = true;
    front.assign(1, root);
    for (std::size_t k = 0; k < front.size(); ++k) {  // breadth first
      const Vector3& here = (*positions)[front[k]];
      for (std::size_t n = starts[front[k]]; n < starts[front[k] + 1]; ++n) {
        const auto next = static_cast<std::size_t>(neighbours[n]);
        if (is_placed[next]) continue;
        (*positions)[next] = subtract((*positions)[next], excess(here, (*positions)[next]));
        is_placed[next] = true;
        front.push_back(next);
      }
    }
  }

  std::vector<Vector3> offsets;
  for (const auto& [i, j] : bonds)
    offsets.push_back(
        subtract({}, excess((*positions)[static_cast<std::size_t>(i)], (*positions)[static_cast<std::size_t>(j)])));
  return offsets;
}

}  // namespace tanor::scene
