#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <tanor/error.hpp>

#include "base/text.hpp"
#include "scene/imported.hpp"

namespace tanor::scene {
using namespace detail;
namespace {

constexpr double slack = 0.45, least = 0.4;  // angstrom
constexpr std::size_t most_partners = 24;    // more are no molecule, but wrong units or coinciding atoms

/// Bins of atoms, no narrower than the longest bond, over the cell, or over a box around all atoms in directions
/// without periods. Atoms without an element are in no bin.
class Bins {
 public:
  Bins(const Imported& data, double reach) : data_(&data) {
    const std::vector<Vector3>& positions = data.positions;
    Cell cell = data.cell;
    Vector3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (const Vector3& r : positions) {
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], r[k]);
        high[k] = std::max(high[k], r[k]);
      }
    }
    // An edge that is not periodic has room for the whole reach beside it, so that no bond passes it.
    is_periodic_ = {cell.xx > 0.0, cell.yy > 0.0, cell.zz > 0.0};
    if (!is_periodic_[0]) cell.xx = high[0] - low[0] + 3.0 * reach;
    if (!is_periodic_[1]) cell.yy = high[1] - low[1] + 3.0 * reach;
    if (!is_periodic_[2]) cell.zz = high[2] - low[2] + 3.0 * reach;
    cell_ = cell;
    // These are the heights of the cell over its faces.
    const double xy = cell.xy / cell.yy, xz = (cell.xy * cell.yz / cell.yy - cell.xz) / cell.zz, yz = cell.yz / cell.zz;
    const Vector3 heights{cell.xx / std::sqrt(1.0 + xy * xy + xz * xz), cell.yy / std::hypot(1.0, yz), cell.zz};
    // Bins are as narrow as possible, even if some atoms are far from the others, because empty bins cost nothing.
    constexpr double most = 1 << 20;
    for (std::size_t k = 0; k < 3; ++k)
      counts_[k] = static_cast<std::int64_t>(std::clamp(std::floor(heights[k] / reach), 1.0, most));
    sort_atoms();
  }

  /// Calls visit(j, distance) once for all atoms j near i.
  template <class Visit>
  void for_each_near(std::size_t i, const Visit& visit) const {
    const auto home = find_bin(data_->positions[i]);
    // Visit the bins on both sides too; a row of one or two bins has fewer.
    const auto last = [&](std::size_t k) { return std::min<std::int64_t>(counts_[k], 3) - 1; };
    for (std::int64_t x = 0; x <= last(0); ++x)
      for (std::int64_t y = 0; y <= last(1); ++y)
        for (std::int64_t z = 0; z <= last(2); ++z) {
          const std::int64_t bin = number_of({home[0] + x - 1, home[1] + y - 1, home[2] + z - 1});
          auto atom = std::ranges::lower_bound(atoms_, bin, {}, &Binned::bin);
          for (; atom != atoms_.end() && atom->bin == bin; ++atom) visit(atom->number, distance(i, atom->number));
        }
  }

 private:
  double distance(std::size_t i, std::size_t j) const {
    const Vector3 &a = data_->positions[i], &b = data_->positions[j];
    Vector3 d{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const Vector3 shift = shift_of(cell_, nearest_images(cell_, d));
    return std::hypot(d[0] - shift[0], d[1] - shift[1], d[2] - shift[2]);
  }

  std::array<std::int64_t, 3> find_bin(const Vector3& r) const {
    // These are the coordinates in units of the edges.
    const double c = r[2] / cell_.zz, b = (r[1] - c * cell_.yz) / cell_.yy,
                 a = (r[0] - b * cell_.xy - c * cell_.xz) / cell_.xx;
    std::array<std::int64_t, 3> bin;
    const Vector3 fractions{a, b, c};
    for (std::size_t k = 0; k < 3; ++k) {
      const double inside = fractions[k] - std::floor(fractions[k]);
      if (!std::isfinite(inside))
        throw InputError("", fmt::format("found an atom at ({}, {}, {}), wanted coordinates of the size of the box",
                                         detail::text(r[0]), detail::text(r[1]), detail::text(r[2])));
      bin[k] = std::min(static_cast<std::int64_t>(inside * static_cast<double>(counts_[k])), counts_[k] - 1);
    }
    return bin;
  }
  std::int64_t number_of(std::array<std::int64_t, 3> bin) const {
    for (std::size_t k = 0; k < 3; ++k) bin[k] = (bin[k] + counts_[k]) % counts_[k];
    return (bin[0] * counts_[1] + bin[1]) * counts_[2] + bin[2];
  }

  void sort_atoms() {
    for (std::size_t i = 0; i < data_->positions.size(); ++i)
      if (data_->elements[i]) atoms_.push_back({number_of(find_bin(data_->positions[i])), i});
    std::ranges::sort(atoms_, {}, [](const Binned& atom) { return std::pair(atom.bin, atom.number); });
  }

  struct Binned {
    std::int64_t bin;
    std::size_t number;
  };
  const Imported* data_;
  Cell cell_;
  std::array<bool, 3> is_periodic_{};
  std::array<std::int64_t, 3> counts_{};
  std::vector<Binned> atoms_;  ///< sorted by bin
};

}  // namespace

std::vector<Imported::Bond> find_bonds_by_distance(const Imported& data) {
  double largest = 0.0;
  for (const Element* element : data.elements)
    if (element) largest = std::max(largest, element->covalent_radius);
  if (largest == 0.0) return {};
  const Bins bins(data, data.angstrom * (2.0 * largest + slack));

  std::vector<Imported::Bond> bonds;
  std::vector<std::int32_t> partners;
  for (std::size_t i = 0; i < data.positions.size(); ++i) {
    if (!data.elements[i]) continue;
    partners.clear();
    std::size_t near = 0;
    bins.for_each_near(i, [&](std::size_t j, double distance) {
      const double most = data.elements[i]->covalent_radius + data.elements[j]->covalent_radius + slack;
      if (j == i || !(distance < data.angstrom * most)) return;
      // If many atoms are at one position, already the first one meets them all.
      if (++near > most_partners)
        throw InputError("", fmt::format("found point {} within bonding distance of more than {} others, wanted at "
                                         "most {}",
                                         i, most_partners, most_partners));
      if (j > i && distance > data.angstrom * least) partners.push_back(static_cast<std::int32_t>(j));
    });
    std::ranges::sort(partners);
    for (const std::int32_t j : partners) bonds.push_back({1, {static_cast<std::int32_t>(i), j}});
  }
  return bonds;
}

}  // namespace tanor::scene
