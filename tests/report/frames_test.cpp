#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <sstream>
#include <tuple>

#include <gtest/gtest.h>

#include "report/reading.hpp"
#include "report/shown_parts.hpp"
#include "report/text_formats.hpp"
#include "report/vtp_frame.hpp"
#include "report/vtp_reader.hpp"

namespace tanor::report {
namespace {

/// Makes a chain of four beads and a free bead 4 on a line (rows 0 and 1), with rods at rows 2, 3, 4.
///
///     X--o--o--o     o
///     0  1  2  3     4
System make_scene() {
  System system = scenes::make_chain(3);
  system.positions.insert(system.positions.end(), {1.0, 0.0, 0.0});
  system.velocities.resize(15);
  system.masses.push_back(0.1);
  system.constraints.insert(system.constraints.begin(),
                            Lines{.name = "rail", .points = {4}, .origin = {}, .direction = {}});
  return system;
}

std::vector<double> count_up(std::size_t size, double first) {
  std::vector<double> numbers(size);
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

TEST(ShownPartsTest, WithoutAChoiceEverythingIsShown) {
  const ShownParts shown = choose_parts(make_scene(), {});

  EXPECT_EQ(shown.points, (std::vector<Index>{0, 1, 2, 3, 4}));
  EXPECT_EQ(shown.is_support, (std::vector<bool>{true, false, false, false, false}));
  EXPECT_EQ(shown.rods, (std::vector<std::array<std::int32_t, 2>>{{0, 1}, {1, 2}, {2, 3}}));
  EXPECT_EQ(shown.rod_rows, (std::vector<std::size_t>{2, 3, 4}));
  ASSERT_EQ(shown.rod_groups.size(), 1u);
  EXPECT_EQ(shown.rod_groups[0].name, "rods");
  EXPECT_TRUE(shown.rod_groups[0].members.empty());
  EXPECT_EQ(shown.loose_points, (std::vector<std::int32_t>{4}));
}

TEST(ShownPartsTest, RodsAreShownWhenBothEndsAre) {
  const ShownParts shown = choose_parts(make_scene(), std::vector<Index>{3, 2, 0});

  EXPECT_EQ(shown.is_support, (std::vector<bool>{false, false, true}));
  EXPECT_EQ(shown.rods, (std::vector<std::array<std::int32_t, 2>>{{1, 0}}));
  EXPECT_EQ(shown.rod_rows, (std::vector<std::size_t>{4}));
  ASSERT_EQ(shown.rod_groups.size(), 1u);
  EXPECT_EQ(shown.rod_groups[0].first, 0u);
  EXPECT_EQ(shown.rod_groups[0].members, (std::vector<std::size_t>{2}));
  EXPECT_EQ(shown.loose_points, (std::vector<std::int32_t>{2}));
  std::vector<double> rows;
  gather_points(shown, count_up(15, 0.0), &rows);
  EXPECT_EQ(rows, (std::vector<double>{9, 10, 11, 6, 7, 8, 0, 1, 2}));
}

TEST(XyzTest, FramesReadBackToTenDigits) {
  const Folder folder;
  const ShownParts shown = choose_parts(make_scene(), {});
  std::vector<double> positions = count_up(15, 0.1);
  positions[4] = -1.0 / 3.0 * 1e-20;
  const std::vector<double> velocities = count_up(15, 1.0 / 7.0);

  const std::unique_ptr<FrameFile> file = open_xyz({.path = folder / "x.xyz", .shown = &shown});
  file->write({.time = 0.0, .positions = positions, .velocities = velocities});
  file->write({.time = 0.1 + 0.2, .positions = velocities, .velocities = positions});

  // The file is still open: a frame is complete as soon as it is written.
  const std::vector<XyzFrame> frames = read_xyz(folder / "x.xyz");
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1].time, 0.1 + 0.2);
  EXPECT_EQ(frames[0].species, (std::vector<std::string>{"X", "C", "C", "C", "C"}));
  for (std::size_t k = 0; k < 15; ++k) {
    EXPECT_NEAR(frames[0].positions[k], positions[k], 5e-10 * std::abs(positions[k]));
    EXPECT_NEAR(frames[0].velocities[k], velocities[k], 5e-10 * std::abs(velocities[k]));
  }
  EXPECT_EQ(file->mark(), std::filesystem::file_size(folder / "x.xyz"));
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Returns the text between the quotes of name="…".
std::string attribute(const std::string& line, const std::string& name) {
  const std::size_t begin = line.find(name + "=\"") + name.size() + 2;
  return line.substr(begin, line.find('"', begin) - begin);
}

/// The parts of a .vtp file: each array by its element and name, "Lines/offsets", as its bytes.
class VtpFile {
 public:
  explicit VtpFile(const std::string& text) : text_(text), header_(text.substr(0, text.find("<AppendedData"))) {
    const std::string start = "<AppendedData encoding=\"raw\">\n_";
    std::size_t expected = 0;
    std::string element;
    std::istringstream lines(header_);
    for (std::string line; std::getline(lines, line);) {
      if (!contains(line, " offset=")) {
        element = line.substr(1, line.find_first_of(" >") - 1);
        continue;
      }
      const std::size_t offset = std::stoul(attribute(line, "offset"));
      EXPECT_EQ(offset, expected) << "arrays follow each other";
      const std::size_t place = text_.find(start) + start.size() + offset;
      std::uint64_t size = 0;
      std::memcpy(&size, &text_[place], sizeof size);
      arrays_[element + "/" + attribute(line, "Name")] = text_.substr(place + sizeof size, size);
      expected += sizeof size + size;
    }
    EXPECT_EQ(text_.substr(text_.find(start) + start.size() + expected), "\n</AppendedData>\n</VTKFile>\n");
  }

  const std::string& header() const { return header_; }

  template <class Number>
  std::vector<Number> array(const std::string& name) const {
    const std::string& bytes = arrays_.at(name);
    std::vector<Number> numbers(bytes.size() / sizeof(Number));
    if (!bytes.empty()) std::memcpy(numbers.data(), bytes.data(), bytes.size());
    return numbers;
  }

 private:
  std::string text_, header_;
  std::map<std::string, std::string> arrays_;
};

TEST(VtpTest, ArraysDecodeToTheSameNumbers) {
  const Folder folder;
  const ShownParts shown = choose_parts(make_scene(), {});
  const std::vector<double> r = count_up(15, 0.1), v = count_up(15, 1.0 / 3.0), w = count_up(15, -7.7);
  const std::vector<double> T{-12.0, 13.0, -14.0};

  write_vtp(folder / "x.vtp", shown, {.time = 0.3, .positions = r, .velocities = v, .accelerations = w, .tensions = T});

  const VtpFile file(read_text(folder / "x.vtp"));
  EXPECT_EQ(file.array<double>("Points/position"), r);
  EXPECT_EQ(file.array<double>("PointData/velocity"), v);
  EXPECT_EQ(file.array<double>("PointData/acceleration"), w);
  EXPECT_EQ(file.array<std::int32_t>("Verts/connectivity"), (std::vector<std::int32_t>{4}));
  EXPECT_EQ(file.array<std::int32_t>("Verts/offsets"), (std::vector<std::int32_t>{1}));
  EXPECT_EQ(file.array<std::int32_t>("Lines/connectivity"), (std::vector<std::int32_t>{0, 1, 1, 2, 2, 3}));
  EXPECT_EQ(file.array<std::int32_t>("Lines/offsets"), (std::vector<std::int32_t>{2, 4, 6}));
  // Each cell has one number, vertices first: the loose bead has no tension.
  const auto tension = file.array<double>("CellData/tension");
  ASSERT_EQ(tension.size(), 4u);
  EXPECT_TRUE(std::isnan(tension[0]));
  EXPECT_EQ(std::vector<double>(tension.begin() + 1, tension.end()), (std::vector<double>{-12.0, 13.0, -14.0}));
}

// A ring of three beads has a period of 0.3 m along x: its last rod leads to the image of bead 0, not back through
// all.
//
//     o--o--o--(o)
//     0  1  2   0 + 0.3
TEST(VtpTest, ARodToAPeriodicImageIsDrawnBesideItsPoint) {
  const Folder folder;
  System system = scenes::make_chain(2);
  auto& rods = std::get<Rods>(system.constraints[0]);
  rods.pairs.push_back({2, 0});
  rods.offsets = {{}, {}, {0.3, 0.0, 0.0}};
  const ShownParts shown = choose_parts(system, {});
  const std::vector<double> v = count_up(9, 1.0), T{-1.0, -2.0, -3.0};

  write_vtp(folder / "x.vtp", shown,
            {.positions = system.positions, .velocities = v, .accelerations = v, .tensions = T});

  const VtpFile file(read_text(folder / "x.vtp"));
  EXPECT_TRUE(contains(file.header(), R"(NumberOfPoints="4")"));
  EXPECT_EQ(file.array<std::int32_t>("Lines/connectivity"), (std::vector<std::int32_t>{0, 1, 1, 2, 2, 3}));
  EXPECT_EQ(file.array<double>("Points/position"),
            (std::vector<double>{0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.2, 0.0, 0.0, 0.3, 0.0, 0.0}));
  const auto velocities = file.array<double>("PointData/velocity");
  EXPECT_EQ(std::vector<double>(velocities.end() - 3, velocities.end()), (std::vector<double>{1.0, 2.0, 3.0}));
  EXPECT_EQ(file.array<double>("CellData/tension"), (std::vector<double>{-1.0, -2.0, -3.0}));
}

TEST(VtpTest, HeaderSaysWhatVtkWantsToKnow) {
  const Folder folder;
  const ShownParts shown = choose_parts(scenes::make_chain(2), {});
  const std::vector<double> numbers = count_up(9, 0.0), T{1.0, 2.0};

  write_vtp(folder / "x.vtp", shown,
            {.time = 0.1 + 0.2, .positions = numbers, .velocities = numbers, .accelerations = numbers, .tensions = T});

  const std::string header = VtpFile(read_text(folder / "x.vtp")).header();
  for (const char* part : {R"(<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">)",
                           R"(Name="TimeValue" NumberOfTuples="1" format="ascii">0.30000000000000004</DataArray>)",
                           R"(<Piece NumberOfPoints="3" NumberOfVerts="0" NumberOfLines="2" NumberOfStrips="0")"}) {
    EXPECT_TRUE(contains(header, part)) << part << " is missing in\n" << header;
  }
}

/// Writes a frame with numbers of some kind, changed by change(&frame), and reads it back.
template <class Change>
StoredFrame write_and_read(const ShownParts& shown, const Change& change) {
  const std::vector<double> numbers = count_up(15, 0.1), tensions(3, 1.0);
  Frame frame{.positions = numbers, .velocities = numbers, .accelerations = numbers, .tensions = tensions};
  change(&frame);
  const Folder folder;
  write_vtp(folder / "x.vtp", shown, frame);
  return read_vtp(folder / "x.vtp");
}

/// A support and a plane have one name, and one of them goes.
TEST(VtpTest, WhatIsGoneIsToldByItsPlaceAndNotByItsName) {
  System system = make_scene();
  system.supports[0].name = "rods";
  system.constraints[0] = Planes{.name = "rods", .points = {4}, .normal = Vector3{0, 0, 1}};
  const ShownParts shown = choose_parts(system, {});
  const auto write = [&](const std::string& place) {
    const std::vector<Passage> passages{{.time = 0.5, .member = "rods[0]", .taken = place}};
    return write_and_read(shown, [&](Frame* frame) {
      frame->time = 1.0;
      frame->guides = place_guides(system, 0.0, 1.0, passages);
      frame->gone = find_gone(shown, passages);
    });
  };
  const double holds = NAN, goes = 0.5;
  for (const auto& [place, support, guide, rod] : {std::tuple("supports/0", goes, holds, holds),
                                                   {"supports/0/0", goes, holds, holds},
                                                   {"constraints/0/0", holds, goes, holds},
                                                   {"constraints/1/0", holds, holds, goes}}) {
    const StoredFrame frame = write(place);
    const auto expect = [&](double found, double wanted) {
      EXPECT_TRUE(found == wanted || (std::isnan(found) && std::isnan(wanted))) << place << ": " << found;
    };
    ASSERT_EQ(frame.supports_gone.size(), 5u);
    expect(frame.supports_gone[0], support);
    expect(frame.supports_gone[1], holds);
    ASSERT_EQ(frame.rods_gone.size(), 3u);
    expect(frame.rods_gone[0], rod);
    expect(frame.rods_gone[1], holds);
    ASSERT_EQ(frame.guides.size(), 1u);
    expect(frame.guides[0].gone, guide);
    EXPECT_EQ(frame.is_support[0], std::isnan(support));
  }
}

TEST(VtpTest, AStateOfRestHasNoTime) {
  const ShownParts shown = choose_parts(make_scene(), {});
  for (const bool is_at_rest : {false, true}) {
    const auto rest = [&](Frame* frame) {
      frame->time = 0.5;
      frame->is_at_rest = is_at_rest;
    };
    const double time = write_and_read(shown, rest).time;
    EXPECT_TRUE(is_at_rest ? std::isnan(time) : time == 0.5) << time;
  }
}

}  // namespace
}  // namespace tanor::report
