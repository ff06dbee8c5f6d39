#include "mpi/program/division.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "mpi/program/together.hpp"
#include "report/checkpoint.hpp"
#include "report/shared_parts.hpp"
#include "report/words.hpp"
#include "system/members.hpp"

namespace tanor::mpi {
using namespace detail;

namespace {

/// The mark of several scenes has the fingerprint of each, with an empty line between them.
constexpr std::string_view between_scenes = "\n\n";

std::vector<std::string_view> list_scenes(std::string_view mark) {
  std::vector<std::string_view> scenes;
  for (std::size_t end = 0; end != mark.npos;) {
    end = mark.find(between_scenes);
    scenes.push_back(mark.substr(0, end));
    if (end != mark.npos) mark.remove_prefix(end + between_scenes.size());
  }
  return scenes;
}

std::string mark_of(const scene::Scene& scene) {
  return report::make_fingerprint(scene.files, scene.system, scene.motion);
}

std::size_t count_islands(const System& system) {
  std::vector<Index> root(system.num_points());
  std::iota(root.begin(), root.end(), 0);
  const std::vector<char> is_support = find_supports(system);
  std::vector<char> has_rows(root.size(), 0);
  for_each_member(system, [&](std::span<const Index> points, int) {
    Index first = -1;
    for (const Index point : points) {
      if (is_support[static_cast<std::size_t>(point)] != 0) continue;
      has_rows[static_cast<std::size_t>(point)] = 1;
      if (first < 0) first = point;
      join_sets(root.data(), first, point);
    }
  });
  std::size_t count = 0;
  for (std::size_t i = 0; i < root.size(); ++i) count += has_rows[i] != 0 && root[i] == static_cast<Index>(i) ? 1 : 0;
  return count;
}

Counts count(const System& system) {
  Counts counts{.points = system.num_points(),
                .equations = num_equations(system),
                .islands = count_islands(system),
                .contacts = report::count_contacts(system)};
  for (const Support& support : system.supports) counts.supports += support.points.size();
  return counts;
}

Counts sum(MpiRanks& ranks, const Counts& own) {
  std::array<double, 5> numbers{};
  const std::array counts{own.points, own.supports, own.equations, own.islands, own.contacts};
  std::ranges::copy(counts, numbers.begin());
  ranks.sum(numbers);
  const auto at = [&](std::size_t k) { return static_cast<std::size_t>(numbers[k]); };
  return {.points = at(0), .supports = at(1), .equations = at(2), .islands = at(3), .contacts = at(4)};
}

}  // namespace

Division Division::divide(MpiRanks& ranks, scene::Scene scene) {
  Division division(ranks, std::move(scene));
  const System& whole = division.scene_.system;
  division.mark_ = mark_of(division.scene_);
  division.counts_ = count(whole);
  const Islands islands = wants_whole_islands(division.scene_.motion, whole) ? Islands::AreWhole : Islands::MayBeCut;
  division.part_ = take_part(whole, assign_owners(whole, ranks.size(), islands), ranks);
  return division;
}

Division Division::join(MpiRanks& ranks, scene::Scene own) {
  Division division(ranks, std::move(own));
  scene::Scene& scene = division.scene_;
  std::string own_mark;
  do_together(ranks, [&] { own_mark = mark_of(scene); });
  division.mark_ = fmt::format("{}", fmt::join(gather_texts(ranks, own_mark), "\n"));
  division.counts_ = sum(ranks, count(scene.system));
  division.part_ = join_parts(std::move(scene.system), ranks);
  division.has_whole_ = false;
  return division;
}

std::string Division::name_difference(std::string_view before) const {
  const auto old_scenes = list_scenes(before), scenes = list_scenes(mark_);
  if (old_scenes.size() != scenes.size())
    return fmt::format("is of a run of {}, not of {}", report::count_in_words(old_scenes.size(), "scene"),
                       scenes.size());
  std::size_t first = 0;
  while (first + 1 < scenes.size() && old_scenes[first] == scenes[first]) ++first;
  return report::name_difference(old_scenes[first], scenes[first]);
}

void Division::write_checkpoint(const std::filesystem::path& name, const Simulation& simulation) const {
  if (has_whole_)
    tanor::write_checkpoint(ranks_, name, part_, scene_.system, simulation, mark_);
  else
    tanor::write_checkpoint(ranks_, name, part_, simulation, mark_);
}

void Division::read_checkpoint(const std::filesystem::path& name, Simulation* simulation) const {
  if (has_whole_)
    tanor::read_checkpoint(ranks_, name, part_, scene_.system, simulation);
  else
    tanor::read_checkpoint(ranks_, name, part_, simulation);
}

}  // namespace tanor::mpi
