#include "scene/trajectory.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace tanor::scene {

std::vector<TrajectoryFormat> read_trajectory_formats(const Cursor& words) {
  if (!words.is_list()) return {words.choice<TrajectoryFormat>()};
  std::vector<TrajectoryFormat> formats;
  for (const Cursor word : words.list("a list of formats")) {
    const auto format = word.choice<TrajectoryFormat>();
    if (std::ranges::find(formats, format) != formats.end())
      word.complain(fmt::format("found {} twice, wanted formats that differ", name_of(format)));
    formats.push_back(format);
  }
  return formats;
}

}  // namespace tanor::scene
