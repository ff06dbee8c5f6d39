#include "report/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

#include <tanor/enum_names.hpp>

#include "base/checksum.hpp"
#include "report/output_file.hpp"
#include "report/words.hpp"
#include "scene/text_file.hpp"

namespace tanor::report {
using namespace detail;

namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

constexpr int format = 15;

fs::path path_in(const fs::path& directory) {
  return directory / checkpoint_name;
}

constexpr std::string_view first_words = "tanor checkpoint ";
std::string first_line() {
  return fmt::format("{}{}\n", first_words, format);
}

/// Calls visit(name, number) for every number of the head, to write and to read it.
template <class Checkpoint, class Visit>
void for_each_number(Checkpoint& checkpoint, const Visit& visit) {
  visit("time", checkpoint.time);
  visit("t_end", checkpoint.t_end);
  visit("frames", checkpoint.trajectory.frames);
  visit("wall_total", checkpoint.wall.total);
  visit("wall_setup", checkpoint.wall.setup);
  visit("wall_output", checkpoint.wall.output);
}

void read_number(const ordered_json& value, const char* name, double& number) {
  if (!value.is_number()) throw InputError("", fmt::format("/{} is {}, not a number", name, value.dump()));
  number = value.get<double>();
  if (!std::isfinite(number)) throw InputError("", fmt::format("/{} is {}, not a number", name, in_words(number)));
}

/// Reads a count. The JSON library would convert -1 and 1.5 to counts without complaint.
void read_number(const ordered_json& value, const char* name, std::uint64_t& number) {
  if (!value.is_number_unsigned()) throw InputError("", fmt::format("/{} is {}, not a count", name, value.dump()));
  number = value.get<std::uint64_t>();
}

/// Requires that numbers which are never negative are at least 0.
void require_sound(const Checkpoint& checkpoint) {
  const WallTimes& wall = checkpoint.wall;
  for (const auto& [name, size] :
       {std::pair{"wall_total", wall.total}, {"wall_setup", wall.setup}, {"wall_output", wall.output}}) {
    if (!(size >= 0.0)) throw InputError("", fmt::format("/{} is {}, not 0 or more", name, in_words(size)));
  }
  const TrajectoryMark& mark = checkpoint.trajectory;
  if (mark.frames == 0) throw InputError("", "/frames is 0");
  for (const auto& [name, size] : mark.files) {
    if (mark.frames > size)
      throw InputError("", fmt::format("/frames is {}, of which {} has {}", mark.frames, name, size));
  }
}

/// Returns the lines and bytes between the first line and the last. Throws InputError if any byte differs from what was
/// written.
std::string_view open_content(std::string_view text) {
  std::string_view content;
  switch (open_sealed(text, first_line(), &content)) {
    case Seal::Sound:
      break;
    case Seal::OtherFormat: {
      const bool is_other = text.starts_with(first_words) || text.starts_with("{\n  \"tanor_checkpoint\"");
      throw InputError("",
                       is_other ? "is of another version of tanor; run without --resume" : "is no checkpoint of tanor");
    }
    case Seal::Damaged:
      throw InputError("", "is damaged: its checksum is another one; run without --resume");
  }
  return content;
}

constexpr std::string_view start_of_points = "the start of its points", options_place = "/motion/";

/// Splits a line into a value without blanks and the name of what has this value.
std::pair<std::string_view, std::string_view> split_line(std::string_view line) {
  const std::size_t end = std::min(line.find(' '), line.size());
  return {line.substr(0, end), line.substr(std::min(end + 1, line.size()))};
}

/// Returns the names of the files in a fingerprint: "net.json, drive.csv".
std::string list_files(std::string_view fingerprint) {
  std::string list;
  for (scene::LineReader lines("", fingerprint); lines.next();) {
    const std::string_view name = split_line(lines.line()).second;
    if (name == start_of_points) break;
    list += fmt::format("{}{}", list.empty() ? "" : ", ", name);
  }
  return list;
}

Checkpoint read_content(std::string_view content, const std::string& fingerprint) {
  const std::size_t end_of_head = std::min(content.find('\n'), content.size());
  Checkpoint checkpoint;
  try {
    const ordered_json head = ordered_json::parse(content.substr(0, end_of_head));
    checkpoint.scene = head.at("scene").get<std::string>();
    for_each_number(checkpoint, [&](const char* key, auto& number) { read_number(head.at(key), key, number); });
    for (const auto& [name, size] : head.at("files").items())
      read_number(size, name.c_str(), checkpoint.trajectory.files[name]);
  } catch (const ordered_json::exception& error) {
    throw InputError("", fmt::format("cannot be read: {}", error.what()));
  }
  if (checkpoint.scene != fingerprint)
    throw InputError("", name_difference(checkpoint.scene, fingerprint) + "; run without --resume");
  require_sound(checkpoint);
  const auto state = std::as_bytes(std::span(content.substr(std::min(end_of_head + 1, content.size()))));
  checkpoint.state.assign(state.begin(), state.end());
  return checkpoint;
}

/// Returns a line "<checksum> <name>" for each file and for the start of a motion.
std::string describe_sources(std::span<const fs::path> files, const System& system) {
  std::string lines;
  for (const fs::path& file : files) {
    Checksum sum;
    sum.add(scene::read_text(file));
    lines += fmt::format("{} {}\n", sum.text(), file.filename().string());
  }
  Checksum sum;
  for (const auto* numbers : {&system.positions, &system.velocities, &system.masses})
    sum.add(std::span<const double>(*numbers));
  return lines + fmt::format("{} {}\n", sum.text(), start_of_points);
}

}  // namespace

std::string name_difference(std::string_view before, std::string_view now) {
  std::string changed;
  const std::string their = list_files(before), our = list_files(now);
  std::string strangers = their.empty() || our.empty()
                              ? "belongs to another scene"
                              : fmt::format("belongs to another scene, of {}, not of {}", their, our);
  scene::LineReader old_lines("", before), new_lines("", now);
  while (old_lines.next() && new_lines.next()) {
    const auto [old_value, old_name] = split_line(old_lines.line());
    const auto [value, name] = split_line(new_lines.line());
    if (name.empty() || name != old_name) return strangers;
    if (!changed.empty() || value == old_value) continue;
    changed = name.starts_with(options_place)
                  ? fmt::format("is of a run with {} {}, not {}", name, old_value, value)
                  : fmt::format("is of an earlier version of the scene: {} was changed", name);
  }
  return changed.empty() ? strangers : changed;
}

std::string make_scene_checksum(std::string_view fingerprint) {
  Checksum sum;
  for (scene::LineReader lines("", fingerprint); lines.next();) {
    sum.add(fmt::format("{}\n", lines.line()));
    if (split_line(lines.line()).second == start_of_points) break;
  }
  return sum.text();
}

std::string make_fingerprint(std::span<const fs::path> files, const System& system, const MotionOptions& motion) {
  std::string lines = describe_sources(files, system);
  lines += fmt::format("{} {}method\n", name_of(motion.method), options_place);
  for (const auto& [name, number] :
       {std::pair{"step", motion.step}, {"max_step", motion.max_step}, {"rtol", motion.rtol}, {"atol", motion.atol}})
    lines += fmt::format("{} {}{}\n", number, options_place, name);
  return lines;
}

void write_checkpoint(const fs::path& directory, const Checkpoint& checkpoint, Wait wait) {
  ordered_json head{{"scene", checkpoint.scene}};
  for_each_number(checkpoint, [&](const char* name, const auto& number) { head[name] = number; });
  head["files"] = checkpoint.trajectory.files;
  write_sealed(path_in(directory), wait, first_line(),
               {head.dump(), "\n",
                std::string_view(reinterpret_cast<const char*>(checkpoint.state.data()), checkpoint.state.size())});
}

std::optional<Checkpoint> read_checkpoint(const fs::path& directory, const std::string& fingerprint) {
  const std::string name = path_in(directory).string();
  if (!fs::exists(name)) return std::nullopt;
  const std::string text = scene::read_text(name);
  try {
    return read_content(open_content(text), fingerprint);
  } catch (const InputError& error) {
    throw InputError(error.where().empty() ? name : fmt::format("{}: {}", name, error.where()), error.what());
  }
}

}  // namespace tanor::report
