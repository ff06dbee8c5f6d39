#include "picture/legend.hpp"

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <vector>

#include "base/with_unit.hpp"
#include "picture/canvas.hpp"

namespace tanor::picture {

using detail::with_unit;

namespace {

constexpr double bar_columns = 7.0;  // width in letters, beside the motion
constexpr double head_rows = 2.2;    // height in letters, above and below the motion

struct Destroy {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_t* context) const { cairo_destroy(context); }
};

/// Returns a number with at most four digits.
std::string words(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", number);
  std::snprintf(text, sizeof text, "%.5g", std::strtod(text, nullptr));  // 16000, not 1.6e+04
  return text;
}

void set_colour(cairo_t* c, Rgb colour) {
  cairo_set_source_rgb(c, colour.r, colour.g, colour.b);
}

void write(cairo_t* c, double x, double y, const std::string& text) {
  cairo_move_to(c, x, y);
  cairo_show_text(c, text.c_str());
}

/// Returns the numbers beside a bar, N: both ends, and multiples of 1, 2 or 5 times a power of ten that keep `room`
/// away from them.
std::vector<double> choose_ticks(const report::TensionScale& tensions, double room) {
  const auto [least, most] = tensions;
  const double rough = (most - least) / 4.0, unit = std::pow(10.0, std::floor(std::log10(rough)));
  double tick = 10.0 * unit;
  for (const double factor : {5.0, 2.0, 1.0})
    if (factor * unit >= rough) tick = factor * unit;
  std::vector<double> ticks{least, most};
  for (double k = std::ceil((least + room) / tick); k * tick <= most - room; ++k)
    ticks.push_back(k * tick + 0.0);  // not -0
  return ticks;
}

void draw_bar(cairo_t* c, const Layout& layout, const Key& key) {
  const double font = layout.font, x = layout.motion.left + layout.motion.width + 0.7 * font;
  const double top = layout.motion.top + 0.16 * layout.motion.height, height = 0.68 * layout.motion.height;
  const auto [least, most] = key.tensions;
  const double width = 0.9 * font, range = most - least;
  const int rows = std::max(1, static_cast<int>(std::lround(height)));
  for (int k = 0; k < rows; ++k) {
    set_colour(c, colour_of(most - range * (k + 0.5) / rows, key.tensions.end()));
    cairo_rectangle(c, x, std::round(top) + k, width, 1.0);
    cairo_fill(c);
  }
  set_colour(c, ink);
  cairo_set_line_width(c, std::max(1.0, 0.05 * font));
  cairo_rectangle(c, x, std::round(top), width, rows);
  cairo_stroke(c);
  const std::string what = key.force_unit.empty() ? "tension" : "tension, " + key.force_unit;
  cairo_text_extents_t extents;
  cairo_text_extents(c, what.c_str(), &extents);
  const double edge = layout.motion.left + layout.motion.width + (bar_columns - 0.3) * font;
  write(c, std::min(x - 0.2 * font, edge - extents.x_advance), top - 0.9 * font, what);
  for (const double tick : choose_ticks(key.tensions, 1.2 * font / height * range)) {
    const double y = top + height * (most - tick) / range;
    cairo_move_to(c, x + width, y);
    cairo_line_to(c, x + width + 0.25 * font, y);
    cairo_stroke(c);
    const char* const beyond = key.has_less && tick == least ? "< " : key.has_more && tick == most ? "> " : "";
    write(c, x + width + 0.45 * font, y + 0.35 * font, beyond + words(tick));
  }
}

/// Draws a dashed rod below the bar, with its words.
void draw_unknown(cairo_t* c, const Layout& layout) {
  const double font = layout.font, x = layout.motion.left + layout.motion.width + 0.7 * font;
  const double y = layout.motion.top + 0.84 * layout.motion.height + 1.1 * font, piece = 0.3 * font;
  set_colour(c, unknown_colour);
  cairo_set_line_width(c, 0.4 * font);
  cairo_set_dash(c, &piece, 1, 0.0);
  cairo_move_to(c, x, y);
  cairo_line_to(c, x, y + 5.0 * piece);
  cairo_stroke(c);
  cairo_set_dash(c, nullptr, 0, 0.0);
  set_colour(c, ink);
  write(c, x + 0.5 * font, y + 2.5 * piece + 0.35 * font, "not known");
}

/// Draws an arrow with its words and returns where these end.
double draw_arrow(cairo_t* c, double x, double y, const Layout& layout, const Key& key, Rgb colour,
                  const std::string& what) {
  const double font = layout.font, head = std::min(0.6 * font, 0.5 * key.arrow_pixels);
  set_colour(c, colour);
  cairo_set_line_width(c, 0.16 * font);
  cairo_move_to(c, x, y);
  cairo_line_to(c, x + key.arrow_pixels - head, y);
  cairo_stroke(c);
  cairo_move_to(c, x + key.arrow_pixels, y);
  cairo_line_to(c, x + key.arrow_pixels - head, y - 0.45 * head);
  cairo_line_to(c, x + key.arrow_pixels - head, y + 0.45 * head);
  cairo_close_path(c);
  cairo_fill(c);
  set_colour(c, ink);
  write(c, x + key.arrow_pixels + 0.5 * font, y + 0.35 * font, what);
  cairo_text_extents_t extents;
  cairo_text_extents(c, what.c_str(), &extents);
  return x + key.arrow_pixels + 0.5 * font + extents.x_advance;
}

void draw_arrows(cairo_t* c, double y, const Layout& layout, const Key& key) {
  const std::string size = with_unit(words(key.arrow), key.force_unit) + ", ";
  double x = layout.font;
  if (key.has_normal)
    x = 1.5 * layout.font + draw_arrow(c, x, y, layout, key, normal_colour, size + "from guides and supports");
  if (key.has_tangent) draw_arrow(c, x, y, layout, key, tangent_colour, size + "friction");
}

cairo_status_t take_bytes(void* text, const unsigned char* bytes, unsigned size) {
  static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(bytes), size);
  return CAIRO_STATUS_SUCCESS;
}

void require(cairo_status_t status) {
  if (status != CAIRO_STATUS_SUCCESS) throw std::runtime_error(cairo_status_to_string(status));
}

}  // namespace

Layout arrange(const Picture& picture, bool has_colours) {
  const Style& style = picture.style;
  Layout layout;
  // Small pictures have larger letters in proportion, so that they stay readable at half the size.
  const double side = std::min<double>(style.height, 0.8 * style.width);
  layout.font = std::max({9.0, 0.024 * side, std::min(16.0, 0.042 * side)});
  const double edge = style.shows_legend ? head_rows * layout.font : 0.0;
  layout.motion = {0.0, edge, static_cast<double>(style.width), style.height - 2.0 * edge};
  if (style.shows_legend && has_colours) layout.motion.width -= bar_columns * layout.font;
  layout.motion.width = std::max(8.0, layout.motion.width);
  layout.motion.height = std::max(8.0, layout.motion.height);
  return layout;
}

std::string finish_picture(const Picture& picture, const Layout& layout, const Key& key,
                           std::vector<std::uint32_t>* pixels) {
  const int width = picture.style.width, height = picture.style.height;
  const std::unique_ptr<cairo_surface_t, Destroy> surface(cairo_image_surface_create_for_data(
      reinterpret_cast<unsigned char*>(pixels->data()), CAIRO_FORMAT_RGB24, width, height, 4 * width));
  const std::unique_ptr<cairo_t, Destroy> context(cairo_create(surface.get()));
  cairo_t* const c = context.get();
  if (picture.style.shows_legend) {
    const double font = layout.font;
    // A system without fonts makes cairo complain; its own letters, which are ASCII, serve there.
    const char* const family = std::filesystem::exists("/etc/fonts/fonts.conf") ? "sans-serif" : "@cairo:";
    cairo_select_font_face(c, family, CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(c, font);
    set_colour(c, ink);
    if (!std::isnan(picture.frame.time))
      write(c, font, 1.6 * font, "t = " + with_unit(words(picture.frame.time), picture.frame.time_unit));
    if (key.tensions.end() > 0.0) draw_bar(c, layout, key);
    if (key.has_unknown) draw_unknown(c, layout);
    if (key.arrow > 0.0) draw_arrows(c, height - 1.2 * font, layout, key);
  }
  require(cairo_status(c));
  cairo_surface_flush(surface.get());
  std::string png;
  require(cairo_surface_write_to_png_stream(surface.get(), take_bytes, &png));
  return png;
}

}  // namespace tanor::picture
