#include "mpi/program/part_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <tanor/enum_names.hpp>

#include "mpi/program/together.hpp"

namespace tanor::mpi {

namespace fs = std::filesystem;

namespace {

/// Returns "melt" of "melt-{rank}.json", without the sign that set the rank apart.
std::string name_run(const fs::path& name) {
  constexpr std::string_view signs = "-_.";
  std::string stem = name.stem().string();
  for (std::size_t at = 0; (at = stem.find(rank_word)) != std::string::npos;) {
    stem.erase(at, std::string_view(rank_word).size());
    if (at > 0 && signs.find(stem[at - 1]) != signs.npos)
      stem.erase(at - 1, 1);
    else if (at == 0 && !stem.empty() && signs.find(stem[0]) != signs.npos)
      stem.erase(0, 1);
  }
  return stem.empty() ? "parts" : stem;
}

/// Returns a line for each option that all ranks must share: its place in a scene and its value.
std::string list_options(const scene::Scene& scene) {
  const MotionOptions& motion = scene.motion;
  std::string lines;
  const auto add = [&](std::string_view name, const auto& value) {
    lines += fmt::format("/motion/{} {}\n", name, value);
  };
  add("method", name_of(motion.method));
  add("step", motion.step);
  add("max_step", motion.max_step);
  add("rtol", motion.rtol);
  add("atol", motion.atol);
  add("stabilisation", name_of(motion.stabilisation));
  add("start", name_of(motion.start));
  add("order", motion.order);
  add("spectral_radius", motion.spectral_radius);
  add("t_start", scene.t_start);
  add("t_end", scene.t_end);
  add("output_every", scene.output_every);
  return lines;
}

/// Throws InputError, the same on every rank, if a rank asks for another motion than the first one.
void require_same_motion(MpiRanks& ranks, const fs::path& name, const scene::Scene& own) {
  const std::vector<std::string> all = gather_texts(ranks, list_options(own));
  for (int rank = 1; rank < ranks.size(); ++rank) {
    std::istringstream first(all[0]), other(all[static_cast<std::size_t>(rank)]);
    for (std::string place, wanted, value; first >> place >> wanted && other >> place >> value;) {
      if (value != wanted)
        throw InputError(name_part(name, rank).string() + ": " + place,
                         fmt::format("is {} on rank {}, but {} on rank 0 ({}); all scenes move in the same way", value,
                                     rank, wanted, name_part(name, 0).string()));
    }
  }
}

/// Returns each line of any rank once, in the order of the ranks.
std::vector<std::string> gather_different(MpiRanks& ranks, const std::vector<std::string>& own) {
  std::vector<std::string> different;
  for (const std::vector<std::string>& lines : gather_lines(ranks, own)) {
    for (const std::string& line : lines) {
      if (std::ranges::find(different, line) == different.end()) different.push_back(line);
    }
  }
  return different;
}

}  // namespace

bool names_parts(const fs::path& name) {
  return name.string().find(rank_word) != std::string::npos;
}

fs::path name_part(const fs::path& name, int rank) {
  std::string part = name.string();
  const std::string number = std::to_string(rank);
  for (std::size_t at = 0; (at = part.find(rank_word, at)) != std::string::npos; at += number.size())
    part.replace(at, std::string_view(rank_word).size(), number);
  return part;
}

void merge_parts(MpiRanks& ranks, const fs::path& name, scene::Scene* own) {
  require_same_motion(ranks, name, *own);
  own->name = name_run(name);
  own->left_out = gather_different(ranks, own->left_out);
  const std::vector<std::string> sources = gather_different(ranks, {own->source});
  own->source = fmt::format("{}", fmt::join(sources, ", "));
}

}  // namespace tanor::mpi
