#include "report/recording_file.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "base/archive.hpp"
#include "report/sealed_file.hpp"
#include "scene/text_file.hpp"

namespace tanor::report {
using namespace detail;

namespace {

constexpr std::string_view first_line_of_recording = "tanor recording 5\n";

/// Accepts any number, because a page draws what there is.
struct CheckNothing {
  template <class Value>
  void operator()(const Value&) const {}
};

/// Writes or reads everything between the first line and the last.
template <class Archive, class Text, class Number, class Recorded>
void exchange(Archive& archive, Text& fingerprint, Number& time, Recorded& recorded) {
  archive(fingerprint, time, recorded.frames, recorded.steps, recorded.switches, recorded.events_before);
}

}  // namespace

void write_recording(const std::filesystem::path& directory, const std::string& fingerprint, double time,
                     const Recording& recording) {
  std::string bytes;
  ByteWriter writer(
      [&](std::span<const std::byte> part) { bytes.append(reinterpret_cast<const char*>(part.data()), part.size()); });
  exchange(writer, fingerprint, time, recording.recorded());
  write_sealed(directory / recording_name, Wait::No, first_line_of_recording, {bytes, "\n"});
}

bool read_recording(const std::filesystem::path& directory, const std::string& fingerprint,
                    const Simulation& simulation, Recording* recording) {
  const std::filesystem::path path = directory / recording_name;
  if (!std::filesystem::exists(path)) return recording->go_on({}, simulation);
  const std::string text = scene::read_text(path);
  std::string_view content;
  if (open_sealed(text, first_line_of_recording, &content) != Seal::Sound) return recording->go_on({}, simulation);
  Recorded before;
  std::string theirs;
  double time = 0.0;
  ByteReader reader(std::as_bytes(std::span(content)), CheckNothing());
  try {
    exchange(reader, theirs, time, before);
  } catch (const EndsTooEarly&) {
    before = Recorded();
  }
  const bool is_ours = reader.num_left() == 1 && time >= simulation.time() && theirs == fingerprint;
  return recording->go_on(is_ours ? std::move(before) : Recorded(), simulation);
}

}  // namespace tanor::report
