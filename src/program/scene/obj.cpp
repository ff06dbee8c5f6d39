#include <limits>
#include <utility>

#include <fmt/format.h>

#include <tanor/error.hpp>

#include "base/text.hpp"
#include "scene/imported.hpp"
#include "scene/name_list.hpp"
#include "scene/text_file.hpp"

namespace tanor::scene {
namespace {

constexpr std::size_t most_vertices = std::numeric_limits<std::int32_t>::max();

/// Reads one file; the driver is `read`.
class ObjReader {
 public:
  ObjReader(const std::string& name, std::string_view text) : name_(name), lines_(name, text) {}

  Imported read() {
    while (lines_.next()) {
      const std::vector<std::string_view> words = split_words(join_continued());
      if (words.empty()) continue;
      if (words[0] == "v")
        read_vertex(words);
      else if (words[0] == "l")
        read_path(words, 2, false);
      else if (words[0] == "f")
        read_path(words, 3, true);
      else
        unread_.add(words[0]);
    }
    check_latest();
    if (!unread_.empty()) data_.unread.push_back("what stands in lines " + unread_.quote_all());
    if (has_more_numbers_) data_.unread.emplace_back("what stands behind x, y and z in lines \"v\"");
    data_.bonds = edges_.take();
    return std::move(data_);
  }

 private:
  /// Returns the content of the current line, with that of the lines which a backslash at its end appends to it.
  std::string_view join_continued() {
    std::string_view line = lines_.content();
    if (!line.ends_with('\\')) return line;
    joined_.clear();
    for (; line.ends_with('\\'); line = lines_.content()) {
      joined_ += line.substr(0, line.size() - 1);
      joined_ += ' ';
      if (!lines_.next()) return joined_;
    }
    return joined_ += line;
  }

  void read_vertex(const std::vector<std::string_view>& words) {
    if (words.size() < 4)
      lines_.complain(
          fmt::format("found a vertex of {}, wanted x, y and z", detail::text_of_count(words.size() - 1, "number")));
    has_more_numbers_ |= words.size() > 4;
    if (data_.positions.size() == most_vertices) lines_.complain("found more vertices than can be numbered");
    Vector3& position = data_.positions.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) position[k] = lines_.read_number(words[k + 1]);
  }

  /// Reads the edges of a line, or of a face, which is closed.
  void read_path(const std::vector<std::string_view>& words, std::size_t least, bool is_closed) {
    if (words.size() <= least)
      lines_.complain(fmt::format("found {} vertices, wanted {} or more", words.size() - 1, least));
    std::int32_t before = read_index(is_closed ? words.back() : words[1]);
    for (std::size_t k = is_closed ? 1 : 2; k < words.size(); ++k) {
      const std::int32_t vertex = read_index(words[k]);
      if (vertex == before) lines_.fail(words[k], "vertices in sequence that differ");
      edges_.add(before, vertex);
      before = vertex;
    }
  }

  /// Reads an index: "7", "7/2", "7//3" and "7/2/3" name vertex 7, and -1 the last one so far.
  std::int32_t read_index(std::string_view word) {
    const auto index = parse_integer(word.substr(0, word.find('/')));
    const auto count = static_cast<std::int64_t>(data_.positions.size());
    if (!index || *index == 0 || *index < -count || *index > static_cast<std::int64_t>(most_vertices))
      lines_.fail(word, fmt::format("a vertex: from 1 on, or from -{} to -1", count));
    if (*index < 0) return static_cast<std::int32_t>(count + *index);
    if (*index > latest_.first) latest_ = {*index, lines_.number()};
    return static_cast<std::int32_t>(*index - 1);
  }

  /// Checks the indices at the end, because faces may name later vertices.
  void check_latest() const {
    const auto [index, line] = latest_;
    if (index > static_cast<std::int64_t>(data_.positions.size()))
      throw InputError("", fmt::format("{}, line {}: found vertex {}, wanted one from 1 to {}", name_, line, index,
                                       data_.positions.size()));
  }

  const std::string name_;
  LineReader lines_;
  std::string joined_;
  std::pair<std::int64_t, std::size_t> latest_;  ///< largest index that was used, and its line
  Edges edges_;
  NameList unread_;                ///< first words of lines
  bool has_more_numbers_ = false;  ///< a vertex has a weight or a colour
  Imported data_;
};

}  // namespace

Imported read_obj(const std::string& name, std::string_view text) {
  return ObjReader(name, text).read();
}

}  // namespace tanor::scene
