#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include <tanor/error.hpp>

#include "base/text.hpp"
#include "scene/document.hpp"
#include "scene/imported.hpp"
#include "scene/text_file.hpp"

namespace tanor::scene {
namespace {

/// First columns of the residue's name, the atom's name, and the numbers.
constexpr std::size_t residue_column = 6, atom_column = 11, first_number = 21;

/// Reads one file; the driver is `read`.
class GroReader {
 public:
  GroReader(const std::string& name, std::string_view text) : name_(name), lines_(name, text) {}

  Imported read() {
    data_.angstrom = 0.1;
    lines_.next();  // a title
    const std::int64_t count = read_count();
    for (std::int64_t k = 0; k < count; ++k) {
      if (!lines_.next())
        lines_.complain(fmt::format("found {}, wanted {} as line 2 says",
                                    detail::text_of_count(static_cast<std::size_t>(k), "atom"), count));
      read_atom();
    }
    if (!lines_.next()) lines_.complain("missing the line of the box behind the atoms");
    read_box();
    while (lines_.next()) {
      if (trim(lines_.line()).empty()) continue;
      data_.unread.emplace_back("what stands behind the first frame");
      break;
    }
    return std::move(data_);
  }

 private:
  std::int64_t read_count() {
    lines_.next();
    const auto count = parse_integer(trim(lines_.line()));
    if (!count || *count < 0 || *count > std::numeric_limits<std::int32_t>::max())
      lines_.fail(lines_.line(), "the number of atoms");
    return *count;
  }

  /// Returns the width of a number, which is the distance of the first two decimal points: a file may have more digits
  /// than the usual three.
  std::size_t find_width() const {
    const std::size_t point = lines_.line().find('.', first_number - 1);
    const std::size_t next = point == std::string_view::npos ? point : lines_.line().find('.', point + 1);
    if (next == std::string_view::npos) lines_.complain("found no three numbers with decimal points from column 21 on");
    return next - point;
  }

  void read_atom() {
    if (width_ == 0) width_ = find_width();
    const auto vector = [&](std::size_t first) {
      Vector3 numbers;
      for (std::size_t k = 0; k < 3; ++k, first += width_)
        numbers[k] = lines_.read_number(columns(lines_.line(), first, first + width_ - 1));
      return numbers;
    };
    data_.positions.push_back(vector(first_number));
    const std::size_t velocity = first_number + 3 * width_;
    const bool has_velocity = !columns(lines_.line(), velocity, lines_.line().size()).empty();
    if (data_.positions.size() == 1) has_velocities_ = has_velocity;
    if (has_velocity != has_velocities_)
      lines_.complain("found atoms with and without velocities, wanted them of all atoms or of none");
    if (has_velocity) data_.velocities.push_back(vector(velocity));

    const std::string_view atom = columns(lines_.line(), atom_column, atom_column + 4);
    data_.elements.push_back(guess_element(atom, columns(lines_.line(), residue_column, residue_column + 4)));
    if (!data_.elements.back() && data_.without_element.empty())
      data_.without_element = fmt::format("{}, line {}: atom {}", name_, lines_.number(), quote(atom));
  }

  /// Reads the edges a, b, c as a_x b_y c_z and, if the box is not a brick, a_y a_z b_x b_z c_x c_y; an edge 0 is not
  /// periodic.
  void read_box() {
    const auto words = split_words(lines_.line());
    if (words.size() != 3 && words.size() != 9)
      lines_.complain(
          fmt::format("found {}, wanted 3 or 9 for the box", detail::text_of_count(words.size(), "number")));
    const auto is_nan = [](std::string_view word) { return spells_number(word) && !parse_number(word); };
    if (std::ranges::all_of(words, is_nan)) {
      data_.unread.emplace_back("the box, which is not finite,");
      return;
    }
    std::array<double, 9> box{};
    for (std::size_t k = 0; k < words.size(); ++k) box[k] = lines_.read_number(words[k]);
    for (std::size_t k = 0; k < 3; ++k)
      if (box[k] < 0.0) lines_.fail(words[k], "an edge of 0 or more");
    if (box[3] != 0.0 || box[4] != 0.0 || box[6] != 0.0)
      lines_.complain("found a box whose first edge leaves the x axis or whose second leaves the x-y plane");
    data_.cell = {.xx = box[0], .yy = box[1], .zz = box[2], .xy = box[5], .xz = box[7], .yz = box[8]};
  }

  const std::string name_;
  LineReader lines_;
  std::size_t width_ = 0;
  bool has_velocities_ = false;
  Imported data_;
};

}  // namespace

Imported read_gro(const std::string& name, std::string_view text) {
  return GroReader(name, text).read();
}

}  // namespace tanor::scene
