#include "mpi/program/division.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tanor/enum_names.hpp>
#include <tanor/report_fields.hpp>

#include "base/member_names.hpp"
#include "cli/messages.hpp"
#include "mpi/program/together.hpp"
#include "report/checkpoint.hpp"
#include "report/words.hpp"

namespace tanor::mpi {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view rank_word = "{rank}";  // in the name of scenes of which each rank has its own

/// Returns the name of a rank's scene, "melt-3.json".
fs::path name_part(const fs::path& name, int rank) {
  std::string part = name.string();
  const std::string number = std::to_string(rank);
  for (std::size_t at = 0; (at = part.find(rank_word, at)) != std::string::npos; at += number.size())
    part.replace(at, rank_word.size(), number);
  return part;
}

/// Throws InputError, the same on every rank, if a rank asks for another motion than the first one.
void require_same_motion(MpiRanks& ranks, const fs::path& name, const scene::Scene& own) {
  std::vector<std::string> places, values;
  const auto add = [&]<class Value>(std::string_view place, const Value& value) {
    places.emplace_back(place);
    if constexpr (std::is_enum_v<Value>)
      values.emplace_back(name_of(value));
    else
      values.push_back(fmt::format("{}", value));
  };
  fields_of<MotionOptions>.for_each(
      [&](auto field) { add(detail::name_of_member<field.member>(), own.motion.*field.member); });
  add("t_start", own.t_start);
  add("t_end", own.t_end);
  add("output_every", own.output_every);
  const std::vector<std::vector<std::string>> all = gather(ranks, values);
  for (std::size_t rank = 1; rank < all.size(); ++rank) {
    const auto other = std::ranges::mismatch(all[0], all[rank]);
    if (other.in1 == all[0].end()) continue;
    const fs::path file = name_part(name, static_cast<int>(rank));
    throw InputError(fmt::format("{}: /motion/{}", file.string(), places[other.in1 - all[0].begin()]),
                     fmt::format("is {} on rank {}, but {} on rank 0 ({}); all scenes move in the same way", *other.in2,
                                 rank, *other.in1, name_part(name, 0).string()));
  }
}

/// Returns each line of any rank once, in the order of the ranks.
std::vector<std::string> gather_different(MpiRanks& ranks, const std::vector<std::string>& own) {
  std::vector<std::string> different;
  for (const std::vector<std::string>& lines : gather(ranks, own)) {
    for (const std::string& line : lines)
      if (std::ranges::find(different, line) == different.end()) different.push_back(line);
  }
  return different;
}

/// Makes the scenes of all ranks one run, on this rank: checks that all ask for the same motion, gives the run a name,
/// "melt", and tells the first rank what it does not know of the others' points. Throws InputError on all ranks.
void merge_scenes(MpiRanks& ranks, const fs::path& name, scene::Scene* own) {
  require_same_motion(ranks, name, *own);
  own->name = name_run(name).stem().string();
  own->left_out = gather_different(ranks, own->left_out);
  own->source = fmt::format("{}", fmt::join(gather_different(ranks, {own->source}), ", "));
}

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

}  // namespace

fs::path name_run(const fs::path& name) {
  constexpr std::string_view signs = "-_.";
  std::string stem = name.stem().string();
  for (std::size_t at = 0; (at = stem.find(rank_word)) != std::string::npos;) {
    stem.erase(at, rank_word.size());
    if (at > 0 && signs.find(stem[at - 1]) != signs.npos)
      stem.erase(at - 1, 1);
    else if (at == 0 && !stem.empty() && signs.find(stem[0]) != signs.npos)
      stem.erase(0, 1);
  }
  return (stem.empty() ? "parts" : stem) + ".json";
}

Division::Division(MpiRanks& ranks, const fs::path& name, const ReadScene& read) : ranks_(ranks) {
  has_whole_ = name.string().find(rank_word) == std::string::npos;
  if (has_whole_)
    divide(name, read);
  else
    join(name, read);
  auto count = static_cast<double>(count_to_write(ranks_, part_));
  ranks_.sum({&count, 1});
  num_points_ = static_cast<std::size_t>(count);
}

/// Divides the system of a scene that every rank reads.
void Division::divide(const fs::path& name, const ReadScene& read) {
  scene_ = read(name);
  const System& whole = scene_.system;
  mark_ = mark_of(scene_);
  const Islands islands = wants_whole_islands(scene_.motion, whole) ? Islands::AreWhole : Islands::MayBeCut;
  part_ = take_part(whole, assign_owners(whole, ranks_.size(), islands), ranks_);
}

/// Makes one system of scenes of which each rank reads its own; no rank holds that system.
void Division::join(const fs::path& name, const ReadScene& read) {
  std::string own_mark;
  do_together(ranks_, [&] {
    scene_ = read(name_part(name, ranks_.rank()));
    own_mark = mark_of(scene_);
  });
  merge_scenes(ranks_, name, &scene_);
  mark_ = fmt::format("{}", fmt::join(gather(ranks_, own_mark), "\n"));
  part_ = cli::naming_file(name, [&] { return join_parts(std::move(scene_.system), ranks_); });
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

}  // namespace tanor::mpi
