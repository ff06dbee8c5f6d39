#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>

#include <tanor/error.hpp>

#include "scene/imported.hpp"
#include "scene/name_list.hpp"
#include "scene/text_file.hpp"

namespace tanor::scene {
namespace {

/// A type of numbers: its two names, its size in a binary file, and what its bytes mean on this machine.
struct Type {
  std::string_view name, other_name;
  std::size_t size;
  double (*decode)(const unsigned char* bytes);
};
template <class Number>
constexpr Type type_of(std::string_view name, std::string_view other_name) {
  return {name, other_name, sizeof(Number), [](const unsigned char* bytes) {
            Number number;
            std::memcpy(&number, bytes, sizeof number);
            return static_cast<double>(number);
          }};
}
constexpr Type types[] = {type_of<std::int8_t>("char", "int8"),    type_of<std::uint8_t>("uchar", "uint8"),
                          type_of<std::int16_t>("short", "int16"), type_of<std::uint16_t>("ushort", "uint16"),
                          type_of<std::int32_t>("int", "int32"),   type_of<std::uint32_t>("uint", "uint32"),
                          type_of<float>("float", "float32"),      type_of<double>("double", "float64")};

struct Property {
  std::string_view name;
  Type type;
  std::optional<Type> count;  ///< type of the count of a list
};

struct Element {
  std::string_view name;
  std::size_t count;
  std::vector<Property> properties;
};

enum class Encoding { Ascii, LittleEndian, BigEndian };

/// The numbers after the header, one by one.
class Numbers {
 public:
  Numbers(Encoding encoding, std::string_view bytes, std::size_t line)
      : encoding_(encoding), rest_(bytes), line_(line) {}

  /// Returns nothing at the end of the data, or if the next word is not a finite number.
  std::optional<double> next(const Type& type) {
    if (is_ascii()) return parse_number(next_word());
    if (rest_.size() < type.size) return {};
    std::array<unsigned char, 8> bytes;
    std::memcpy(bytes.data(), rest_.data(), type.size);
    rest_.remove_prefix(type.size);
    if ((encoding_ == Encoding::LittleEndian) != (std::endian::native == std::endian::little))
      std::reverse(bytes.begin(), bytes.begin() + type.size);
    const double number = type.decode(bytes.data());
    return std::isfinite(number) ? std::optional(number) : std::nullopt;
  }
  /// Passes over a number of which nothing is wanted, which may be none. Returns false at the end of the data.
  bool skip(const Type& type) {
    if (is_ascii()) return !next_word().empty();
    const bool is_there = rest_.size() >= type.size;
    rest_.remove_prefix(is_there ? type.size : 0);
    return is_there;
  }
  /// Returns true if nothing but blanks is left.
  bool is_at_end() const { return rest_.find_first_not_of(" \t\r\n") == std::string_view::npos; }

  /// Returns an upper bound of the numbers that the rest can hold; a word takes a digit and a blank.
  std::size_t room(std::size_t size) const {
    return encoding_ == Encoding::Ascii ? rest_.size() / 2 + 1 : rest_.size() / size;
  }
  bool is_ascii() const { return encoding_ == Encoding::Ascii; }
  std::size_t line() const { return line_; }

 private:
  std::string_view next_word() {
    std::size_t k = 0;
    for (; k < rest_.size() && std::string_view(" \t\r\n").find(rest_[k]) != std::string_view::npos; ++k)
      line_ += rest_[k] == '\n' || (rest_[k] == '\r' && !rest_.substr(k + 1).starts_with('\n'));
    rest_.remove_prefix(k);
    const std::string_view word = rest_.substr(0, rest_.find_first_of(" \t\r\n"));
    rest_.remove_prefix(word.size());
    return word;
  }

  Encoding encoding_;
  std::string_view rest_;
  std::size_t line_;  ///< line of the text
};

/// Reads one file; the driver is `read`.
class PlyReader {
 public:
  PlyReader(const std::string& name, std::string_view text) : name_(name), lines_(name, text) {}

  Imported read() {
    const Encoding encoding = read_header();
    Numbers numbers(encoding, lines_.rest(), lines_.number() + 1);
    for (const Element& element : elements_) read_element(element, &numbers);
    check_edges();
    if (!numbers.is_at_end()) data_.unread.emplace_back("what stands behind the last element");
    data_.bonds = edges_.take();
    return std::move(data_);
  }

 private:
  Encoding read_header() {
    if (!lines_.next() || trim(lines_.line()) != "ply")
      lines_.complain("wanted \"ply\", the first line of such a file");
    std::optional<Encoding> encoding;
    while (lines_.next()) {
      const std::vector<std::string_view> words = split_words(lines_.line());
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") {
        if (!encoding) lines_.complain("missing the line \"format …\" above");
        return *encoding;
      }
      if (words[0] == "format" && words.size() == 3)
        encoding = read_encoding(words[1]);
      else if (words[0] == "element" && words.size() == 3)
        elements_.push_back({words[1], read_count(words[2]), {}});
      else if (words[0] == "property" && words.size() >= 3 && !elements_.empty())
        elements_.back().properties.push_back(read_property(words));
      else
        lines_.fail(lines_.line(), "format, element, property, comment or end_header");
    }
    lines_.complain("missing end_header");
  }

  Encoding read_encoding(std::string_view word) const {
    if (word == "ascii") return Encoding::Ascii;
    if (word == "binary_little_endian") return Encoding::LittleEndian;
    if (word == "binary_big_endian") return Encoding::BigEndian;
    lines_.fail(word, "ascii, binary_little_endian or binary_big_endian");
  }

  std::size_t read_count(std::string_view word) const {
    const auto count = parse_integer(word);
    if (!count || *count < 0 || *count > std::numeric_limits<std::int32_t>::max())
      lines_.fail(word, fmt::format("a count from 0 to {}", std::numeric_limits<std::int32_t>::max()));
    return static_cast<std::size_t>(*count);
  }

  Type read_type(std::string_view word) const {
    const auto* found =
        std::ranges::find_if(types, [&](const Type& each) { return each.name == word || each.other_name == word; });
    if (found == std::end(types)) lines_.fail(word, "a type: char, uchar, short, ushort, int, uint, float, double");
    return *found;
  }

  Property read_property(const std::vector<std::string_view>& words) const {
    if (words[1] != "list" && words.size() == 3) return {words[2], read_type(words[1]), {}};
    if (words[1] == "list" && words.size() == 5) return {words[4], read_type(words[3]), read_type(words[2])};
    lines_.fail(lines_.line(), "property TYPE NAME or property list TYPE TYPE NAME");
  }

  [[noreturn]] void complain(const Numbers& numbers, const std::string& what) const {
    if (numbers.is_ascii()) throw InputError("", fmt::format("{}, line {}: {}", name_, numbers.line(), what));
    throw InputError("", fmt::format("{}: {}", name_, what));
  }

  /// Refuses counts that exceed what the rest of the file can hold.
  void check_room(const Numbers& numbers, double count, std::size_t size, const std::string& what) const {
    if (size == 0 || count > static_cast<double>(numbers.room(size)))
      complain(numbers, fmt::format("found {}, wanted no more than the rest of the file holds", what));
  }

  double next(const Element& element, std::size_t index, const Property& property, const Type& type,
              Numbers* numbers) const {
    if (const auto number = numbers->next(type)) return *number;
    complain(*numbers, fmt::format("found no finite number for {} of {} {}", property.name, element.name, index));
  }

  void read_element(const Element& element, Numbers* numbers) {
    const bool is_vertex = element.name == "vertex", is_edge = element.name == "edge";
    std::size_t size = 0;
    for (const Property& each : element.properties) size += each.count.value_or(each.type).size;
    if (element.count > 0)
      check_room(*numbers, static_cast<double>(element.count), size,
                 fmt::format("{} elements {}", element.count, element.name));
    if (is_vertex) check_vertex(element, *numbers);
    name_unread(element);
    for (std::size_t k = 0; k < element.count; ++k) {
      if (is_vertex) data_.positions.emplace_back();
      edge_ = {-1.0, -1.0};
      for (const Property& property : element.properties) {
        if (property.count)
          read_list(element, k, property, numbers);
        else if (is_read(element, property))
          read_number(property, next(element, k, property, property.type, numbers));
        else
          skip(element, k, property, numbers);
      }
      if (is_edge) add_edge(element, k, edge_[0], edge_[1], *numbers);
    }
  }

  /// Returns true if the points or rods come from this property.
  static bool is_read(const Element& element, const Property& property) {
    if (element.name == "vertex") return is_axis(property);
    if (element.name == "edge") return !property.count && (property.name == "vertex1" || property.name == "vertex2");
    const bool is_surface = element.name == "face" || element.name == "tristrips";
    return is_surface && property.count && (property.name == "vertex_indices" || property.name == "vertex_index");
  }
  void name_unread(const Element& element) {
    NameList names;
    for (const Property& each : element.properties)
      if (!is_read(element, each)) names.add(each.name);
    if (element.count == 0 || names.empty()) return;
    data_.unread.push_back(
        fmt::format("what stands in properties {} of element {}", names.quote_all(), quote(element.name)));
  }

  void read_number(const Property& property, double number) {
    if (is_axis(property))
      data_.positions.back()[property.name[0] - 'x'] = number;
    else
      edge_[property.name == "vertex2"] = number;
  }
  void skip(const Element& element, std::size_t index, const Property& property, Numbers* numbers) const {
    if (!numbers->skip(property.type))
      complain(*numbers, fmt::format("found no number for {} of {} {}", property.name, element.name, index));
  }

  static bool is_axis(const Property& property) {
    return !property.count && (property.name == "x" || property.name == "y" || property.name == "z");
  }
  void check_vertex(const Element& element, const Numbers& numbers) const {
    if (std::ranges::count_if(element.properties, is_axis) != 3)
      complain(numbers, "found vertices without x, y and z, wanted these properties once each");
  }

  void read_list(const Element& element, std::size_t index, const Property& property, Numbers* numbers) {
    const double count = next(element, index, property, *property.count, numbers);
    if (!(count >= 0.0) || count != std::floor(count))
      complain(*numbers,
               fmt::format("found a list of {} entries in {} {}, wanted a count", count, element.name, index));
    check_room(*numbers, count, property.type.size,
               fmt::format("a list of {} entries in {} {}", count, element.name, index));
    std::vector<double> entries;
    const bool is_wanted = is_read(element, property);
    for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) {
      if (is_wanted)
        entries.push_back(next(element, index, property, property.type, numbers));
      else
        skip(element, index, property, numbers);
    }
    if (element.name == "tristrips")
      add_strips(element, index, entries, *numbers);
    else
      add_face(element, index, entries, *numbers);
  }

  void add_face(const Element& element, std::size_t index, std::span<const double> corners, const Numbers& numbers) {
    for (std::size_t k = 0; k < corners.size() && corners.size() > 1; ++k)
      add_edge(element, index, corners[k], corners[(k + 1) % corners.size()], numbers);
  }

  /// Adds strips of triangles, which -1 parts: every three vertices in sequence are one. A triangle that names a vertex
  /// twice has no area and only turns the strip.
  void add_strips(const Element& element, std::size_t index, std::span<const double> vertices, const Numbers& numbers) {
    while (!vertices.empty()) {
      const auto end = static_cast<std::size_t>(std::ranges::find(vertices, -1.0) - vertices.begin());
      if (end == 1 || end == 2)
        complain(numbers,
                 fmt::format("found a strip of {} vertices in {} {}, wanted 3 or more", end, element.name, index));
      for (std::size_t k = 2; k < end; ++k) {
        const std::span<const double> triangle = vertices.subspan(k - 2, 3);
        if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0])
          add_face(element, index, triangle, numbers);
      }
      vertices = vertices.subspan(std::min(end + 1, vertices.size()));
    }
  }

  void add_edge(const Element& element, std::size_t index, double i, double j, const Numbers& numbers) {
    for (const double vertex : {i, j}) {
      if (!(vertex >= 0.0) || vertex != std::floor(vertex) || vertex > std::numeric_limits<std::int32_t>::max() - 1)
        complain(numbers, fmt::format("found vertex {} in {} {}, wanted one from 0 on", vertex, element.name, index));
    }
    if (i == j)
      complain(numbers, fmt::format("found vertex {} twice in sequence in {} {}, wanted vertices that differ", i,
                                    element.name, index));
    largest_ = std::max({largest_, i, j});
    edges_.add(static_cast<std::int32_t>(i), static_cast<std::int32_t>(j));
  }

  /// Checks the vertices of edges at the end, because edges may precede the vertices.
  void check_edges() const {
    if (largest_ >= static_cast<double>(data_.positions.size()))
      throw InputError("", fmt::format("{}: found vertex {} in an edge or face, wanted one from 0 to {}", name_,
                                       largest_, static_cast<std::int64_t>(data_.positions.size()) - 1));
  }

  const std::string name_;
  LineReader lines_;
  std::vector<Element> elements_;
  std::array<double, 2> edge_{};
  double largest_ = -1.0;  ///< largest vertex that was used
  Edges edges_;
  Imported data_;
};

}  // namespace

Imported read_ply(const std::string& name, std::string_view text) {
  return PlyReader(name, text).read();
}

}  // namespace tanor::scene
