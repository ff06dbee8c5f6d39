#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/text.hpp"
#include "cli/command_line.hpp"
#include "cli/messages.hpp"
#include "picture/draw.hpp"
#include "report/modes.hpp"
#include "report/module.hpp"
#include "report/output_file.hpp"
#include "report/stored_motion.hpp"
#include "report/words.hpp"

namespace tanor::cli {
using namespace detail;
using report::with_unit;

namespace {

picture::Drawn draw(const picture::Picture& picture) {
  const auto function = reinterpret_cast<picture::DrawFunction*>(report::load_function(
      "tanor_picture", picture::draw_symbol,
      "this tanor was built without cairo and draws no pictures; trajectory.pvd opens in ParaView"));
  picture::Drawn drawn;
  std::string trouble;
  function(picture, &drawn, &trouble);
  if (!trouble.empty()) throw std::runtime_error("no picture could be drawn: " + trouble);
  return drawn;
}

/// Returns the time that is asked for, or else the last one, of a mode that of its largest moves.
double choose_time(const Options& options, const report::StoredMotion& motion) {
  const double begin = motion.begin(), end = motion.end(),
               time = options.instant.time.value_or(options.instant.mode > 0 ? begin : end);
  // A time may have been printed with few digits.
  const double rounding = 1e-9 * (end - begin);
  if (!(time >= begin - rounding && time <= end + rounding)) {
    const std::string unit = motion.at(end).frame.time_unit;
    const auto [first, last, given] = texts_apart(std::array{begin, end, time});
    throw InputError("--time", fmt::format("must be between {} and {}, the frames of {}, not {}", first,
                                           with_unit(last, unit), options.folder.string(), given));
  }
  return std::min(std::max(time, begin), end);
}

}  // namespace

ExitCode execute_picture(const Options& options) {
  if (options.out && options.out->extension() != ".png")
    throw InputError("--out", fmt::format("found {}, wanted a name that ends in .png", options.out->string()));
  const report::StoredMotion motion(options.folder, options.instant.mode);
  const report::StoredMotion::Instant instant = motion.at(choose_time(options, motion));
  const std::filesystem::path file = options.out.value_or(
      options.folder / (options.instant.mode > 0
                            ? report::name_mode(static_cast<std::size_t>(options.instant.mode)) + ".png"
                            : report::picture_name));
  const picture::Drawn drawn =
      draw({.frame = instant.frame, .extent = motion.measure(options.style.shows_guides), .style = options.style});
  report::replace_file(file, [&](report::OutputFile* png) { png->write(std::string_view(drawn.png)); });

  std::vector<std::string> without_picture;
  std::size_t left_out = drawn.left_out;
  for (const report::Guide& guide : instant.frame.guides) {
    if (report::has_picture(guide)) continue;
    without_picture.push_back(report::name_guide(guide));
    left_out += report::count_of(guide);
  }
  const bool is_frame = instant.before == instant.after;
  if (options.json) {
    const auto or_null = [](double number) { return number > 0.0 ? nlohmann::ordered_json(number) : nullptr; };
    print_json({{"file", file.string()},
                {"t", instant.frame.time},
                {"frames", {instant.before, instant.after}},
                {"width", options.style.width},
                {"height", options.style.height},
                {"tension_scale", or_null(drawn.tension_scale)},
                {"arrow", or_null(drawn.arrow)},
                {"guides_left_out", left_out}});
  } else if (!options.quiet) {
    const auto [time, before, after] = texts_apart(std::array{instant.frame.time, instant.before, instant.after});
    const std::string& unit = instant.frame.time_unit;
    print_message(fmt::format(
        "{} in {}{}", std::isnan(instant.frame.time) ? "at rest" : "t = " + with_unit(time, unit), typed(file),
        is_frame ? ""
                 : fmt::format(", between the frames at {} and {}", with_unit(before, unit), with_unit(after, unit))));
    if (drawn.left_out > 0)
      print_message(fmt::format("left out: {}; guides before cover the picture, or take too long",
                                report::count_in_words(drawn.left_out, "guide")));
    if (!without_picture.empty()) print_message(fmt::format("not drawn: {}", fmt::join(without_picture, ", ")));
  }
  return ExitCode::Done;
}

}  // namespace tanor::cli
