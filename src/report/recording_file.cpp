#include "report/recording_file.hpp"

#include <cstring>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/checksum.hpp"
#include "report/output_file.hpp"
#include "scene/text_file.hpp"

namespace tanor::report {

namespace {

constexpr std::string_view recording_begins = "tanor recording 1\n", recording_sum = "\nchecksum ";

template <class Value>
concept PlainBytes = std::is_arithmetic_v<Value> || std::is_same_v<Value, RecordedStep>;

template <class Frame, class Visit>
void visit_parts(Frame& frame, const Visit& visit) requires std::is_same_v<std::remove_const_t<Frame>, RecordedFrame> {
  visit(frame.time, frame.positions, frame.tensions, frame.normal_reactions, frame.tangent_reactions, frame.guides);
}
template <class List, class Visit>
void visit_parts(List& list, const Visit& visit) requires requires {
  List::visit(list, visit);
}
{ List::visit(list, visit); }

/// Appends numbers, lists and what is made of them to bytes.
struct RecordingWriter {
  std::string* bytes;

  template <class... Values>
  void operator()(const Values&... values) const {
    (put(values), ...);
  }
  template <PlainBytes Value>
  void put(const Value& value) const {
    bytes->append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class Value>
  void put(const Value& value) const {
    visit_parts(value, *this);
  }
  template <class Item>
  void put(const std::vector<Item>& list) const {
    put(list.size());
    for (const Item& item : list) put(item);
  }
};

/// Says that the bytes that are left end too early.
struct CutOff {};

/// Reads back what a RecordingWriter wrote.
struct RecordingReader {
  std::string_view* left;

  template <class... Values>
  void operator()(Values&... values) const {
    (take(values), ...);
  }
  template <PlainBytes Value>
  void take(Value& value) const {
    if (left->size() < sizeof value) throw CutOff();
    std::memcpy(&value, left->data(), sizeof value);
    left->remove_prefix(sizeof value);
  }
  template <class Value>
  void take(Value& value) const {
    visit_parts(value, *this);
  }
  template <class Item>
  void take(std::vector<Item>& list) const {
    std::size_t count = 0;
    take(count);
    constexpr std::size_t least_bytes = PlainBytes<Item> ? sizeof(Item) : sizeof count;
    if (count > left->size() / least_bytes) throw CutOff();
    list.resize(count);
    for (Item& item : list) take(item);
  }
};

/// `visit` of everything in the file but its first line and its last.
template <class Recorded, class Visit>
void visit_recorded(Recorded& recorded, const Visit& visit) {
  visit(recorded.start.time, recorded.start.positions, recorded.frames, recorded.steps, recorded.switches);
}

/// The bytes between the first line and the last; empty where one of them is not what was written.
std::string_view open_recording(std::string_view text) {
  const std::size_t end = text.rfind(recording_sum);
  if (!text.starts_with(recording_begins) || end == std::string_view::npos) return {};
  Checksum sum;
  sum.add(text.substr(0, end));
  if (text.substr(end + recording_sum.size()) != sum.text()) return {};
  return text.substr(recording_begins.size(), end - recording_begins.size());
}

}  // namespace

void write_recording(const std::filesystem::path& directory, const std::string& fingerprint, double time,
                     const Recording& recording) {
  std::string bytes(recording_begins);
  const RecordingWriter write{&bytes};
  write(std::vector<char>(fingerprint.begin(), fingerprint.end()), time);
  visit_recorded(recording.recorded(), write);
  Checksum sum;
  sum.add(bytes);
  replace_file(directory / recording_name, [&](OutputFile* file) {
    file->write(bytes);
    file->write(fmt::format("{}{}", recording_sum, sum.text()));
  });
}

bool read_recording(const std::filesystem::path& directory, const std::string& fingerprint,
                    const Simulation& simulation, Recording* recording) {
  Recorded before;
  if (std::filesystem::exists(directory / recording_name)) {
    const std::string text = scene::read_text(directory / recording_name);
    std::string_view left = open_recording(text);
    std::vector<char> theirs;
    double time = 0.0;
    try {
      const RecordingReader read{&left};
      read(theirs, time);
      visit_recorded(before, read);
    } catch (const CutOff&) {
      before = Recorded();
    }
    if (!left.empty() || time < simulation.time() || std::string(theirs.begin(), theirs.end()) != fingerprint)
      before = Recorded();
  }
  return recording->go_on(std::move(before), simulation);
}

}  // namespace tanor::report
