/// The words and numbers of a legend, letter by letter: cairo draws each once more, and it is looked for in the
/// picture.

#include <cairo.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "picture/canvas.hpp"
#include "picture/decoded.hpp"
#include "picture/draw.hpp"
#include "picture/legend.hpp"
#include "report/motion_extent.hpp"

namespace tanor::picture {
namespace {

/// Returns a text in ink on white, with half a letter of white before and behind it.
Decoded write_text(const std::string& text, double font) {
  const int edge = static_cast<int>(0.5 * font);
  const auto surface = [](int width, int height) {
    return std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>(
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height), &cairo_surface_destroy);
  };
  const auto with = [&](cairo_surface_t* on, const auto& use) {
    const std::unique_ptr<cairo_t, decltype(&cairo_destroy)> c(cairo_create(on), &cairo_destroy);
    const bool has_fonts = std::filesystem::exists("/etc/fonts/fonts.conf");
    cairo_select_font_face(c.get(), has_fonts ? "sans-serif" : "@cairo:", CAIRO_FONT_SLANT_NORMAL,
                           CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(c.get(), font);
    use(c.get());
  };
  cairo_text_extents_t extents;
  with(surface(1, 1).get(), [&](cairo_t* c) { cairo_text_extents(c, text.c_str(), &extents); });
  const int left = static_cast<int>(std::floor(extents.x_bearing)),
            top = static_cast<int>(std::floor(extents.y_bearing));
  Decoded written{
      static_cast<int>(std::ceil(extents.width)) + 2 * edge + 1, static_cast<int>(std::ceil(extents.height)) + 1, {}};
  const auto page = surface(written.width, written.height);
  with(page.get(), [&](cairo_t* c) {
    cairo_set_source_rgb(c, 1, 1, 1);
    cairo_paint(c);
    cairo_set_source_rgb(c, ink.r, ink.g, ink.b);
    cairo_move_to(c, edge - left, -top);
    cairo_show_text(c, text.c_str());
  });
  cairo_surface_flush(page.get());
  const unsigned char* bytes = cairo_image_surface_get_data(page.get());
  for (int y = 0; y < written.height; ++y)
    for (int x = 0; x < written.width; ++x)
      for (int k = 2; k >= 0; --k)
        written.bytes.push_back(bytes[y * cairo_image_surface_get_stride(page.get()) + 4 * x + k]);
  return written;
}

/// Returns the height of the middle of a text that stands alone to the right of a column of a picture.
std::optional<double> find_text(const Decoded& picture, const std::string& text, double font, double beyond) {
  const Decoded wanted = write_text(text, font);
  const auto stands_at = [&](int left, int top) {
    for (int y = 0; y < wanted.height; ++y)
      for (int x = 0; x < wanted.width; ++x)
        if (std::abs((left + x > beyond ? picture.at(left + x, top + y)[0] : 255) - wanted.at(x, y)[0]) > 3)
          return false;
    return true;
  };
  const int first = static_cast<int>(beyond) - static_cast<int>(font);
  for (int top = 0; top + wanted.height <= picture.height; ++top)
    for (int left = first; left + wanted.width <= picture.width; ++left)
      if (stands_at(left, top)) return top + 0.5 * wanted.height;
  return {};
}

/// Where words beside the bar begin, and numbers behind their ticks.
struct Columns {
  double words, numbers;
  explicit Columns(const Layout& layout)
      : words(layout.motion.left + layout.motion.width), numbers(words + 1.9 * layout.font) {}
};

/// Two rods from a support, one that pulls with 4.7 and one that pushes with 2.5.
Picture make_pair() {
  report::StoredFrame frame;
  frame.positions = {0, 0, 0, 1, 0, 0, 2, 0, 0};
  frame.velocities.resize(9);
  frame.is_support = {true, false, false};
  frame.rods = {{0, 1}, {1, 2}};
  frame.tensions = {4.7, -2.5};
  frame.force_unit = "N";
  return {frame, report::measure_motion({frame}), {.width = 800, .height = 600}};
}

TEST(LegendTest, TheBarHasItsQuantityItsUnitAndItsEnds) {
  const Picture picture = make_pair();
  const Decoded painted = decode(draw(picture).png);
  const Layout layout = arrange(picture, true);
  const auto find = [&](const std::string& text) {
    const Columns columns(layout);
    return find_text(painted, text, layout.font, text.starts_with("tension") ? columns.words : columns.numbers);
  };
  const double top = layout.motion.top + 0.16 * layout.motion.height, height = 0.68 * layout.motion.height;
  ASSERT_TRUE(find("tension, N"));
  EXPECT_LT(*find("tension, N"), top);
  for (const auto& [text, part] : {std::pair{"4.7", 0.0}, {"0", 0.5}, {"-4.7", 1.0}}) {
    ASSERT_TRUE(find(text)) << text;
    EXPECT_NEAR(*find(text), top + part * height, 2.0) << text;
  }
  for (const char* const other : {"tension", "tension, J", "4.8", "7", "> 4.7", "-2.5"})
    EXPECT_FALSE(find(other)) << other;
}

TEST(LegendTest, ABarWithoutLettersHasItsQuantityAndOneThatIsShorterHasMarks) {
  Picture picture = make_pair();
  picture.frame.force_unit = "";
  picture.style.tension_scale = 2.0;
  const Decoded painted = decode(draw(picture).png);
  const Layout layout = arrange(picture, true);
  const Columns columns(layout);
  for (const char* const text : {"> 2", "< -2"})
    EXPECT_TRUE(find_text(painted, text, layout.font, columns.numbers)) << text;
  for (const char* const text : {"4.7", "2", "-2"})
    EXPECT_FALSE(find_text(painted, text, layout.font, columns.numbers)) << text;
  EXPECT_TRUE(find_text(painted, "tension", layout.font, columns.words));
  EXPECT_FALSE(find_text(painted, "tension, N", layout.font, columns.words));
}

TEST(LegendTest, RodsOfUnknownTensionHaveOneEntry) {
  const auto has_entry = [](const std::vector<double>& tensions) {
    Picture picture = make_pair();
    picture.frame.tensions = tensions;
    picture.extent = report::measure_motion({picture.frame});
    const Decoded painted = decode(draw(picture).png);
    const Layout layout = arrange(picture, true);
    return find_text(painted, "not known", layout.font, Columns(layout).words + 1.1 * layout.font).has_value();
  };
  EXPECT_FALSE(has_entry({4.7, -2.5}));
  EXPECT_TRUE(has_entry({4.7, NAN}));
  EXPECT_TRUE(has_entry({NAN, NAN}));
}

}  // namespace
}  // namespace tanor::picture
