#include "report/stored_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include <tanor/error.hpp>

#include "report/html_page.hpp"
#include "report/json_text.hpp"
#include "report/modes.hpp"
#include "report/summary.hpp"
#include "report/vtp_frame.hpp"

namespace tanor::report {

namespace fs = std::filesystem;

namespace {

std::vector<double> mix(const std::vector<double>& a, const std::vector<double>& b, double part) {
  std::vector<double> mixed(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) mixed[k] = (1.0 - part) * a[k] + part * b[k];
  return mixed;
}

/// Interpolates each row by r(s) = (1 + 2s)(1 - s)^2 r_0 + s(1 - s)^2 h v_0 + s^2(3 - 2s) r_1 - s^2(1 - s) h v_1, with
/// s from 0 to 1 and h the seconds from a to b.
std::vector<double> follow_hermite(const StoredFrame& a, const StoredFrame& b, double h, double s) {
  const double u = 1.0 - s;
  std::vector<double> r(a.positions.size());
  for (std::size_t k = 0; k < r.size(); ++k)
    r[k] = (1.0 + 2.0 * s) * u * u * a.positions[k] + s * u * u * h * a.velocities[k] +
           s * s * (3.0 - 2.0 * s) * b.positions[k] - s * s * u * h * b.velocities[k];
  return r;
}

/// Interpolates guides between two frames; guides that are not the same in both stay.
std::vector<Guide> mix_guides(std::vector<Guide> guides, const std::vector<Guide>& later, double part) {
  for (std::size_t k = 0; k < std::min(guides.size(), later.size()); ++k)
    if (guides[k].kind == later[k].kind && guides[k].numbers.size() == later[k].numbers.size())
      guides[k] = {guides[k].kind, guides[k].name, mix(guides[k].numbers, later[k].numbers, part), later[k].gone};
  return guides;
}

Json read_summary(const fs::path& directory) {
  std::ifstream file(directory / summary_name);
  const Json summary = Json::parse(file, nullptr, false);
  return summary.is_object() ? summary : Json::object();
}

/// Returns the colours that the page has, which a run renews on its way, or that the summary tells, if there is one.
std::optional<TensionScale> read_colours(const fs::path& directory) {
  std::ifstream page(directory / html_page_name, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(page), {}};
  const std::size_t key = text.find(html_colours_key);
  Json ends;
  if (key != std::string::npos) {
    const std::size_t begin = key + html_colours_key.size();
    ends = Json::parse(text.substr(begin, text.find(']', begin) + 1 - begin), nullptr, false);
  } else {
    ends = read_summary(directory).value(tension_colours_key, Json());
  }
  if (!ends.is_array() || ends.size() != 2) return std::nullopt;
  const auto number = [&](std::size_t k) { return ends[k].is_number() ? ends[k].get<double>() : NAN; };
  const TensionScale scale{.least = number(0), .most = number(1)};
  return scale.least <= 0.0 && scale.most >= 0.0 ? std::optional(scale) : std::nullopt;
}

}  // namespace

std::string read_stop(const fs::path& directory) {
  const Json why = read_summary(directory).value("stopped_by", Json());
  return why.is_string() ? why.get<std::string>() : "";
}

StoredMotion::StoredMotion(const fs::path& directory, int mode) : directory_(directory) {
  const std::string list_name =
      mode > 0 ? name_mode(static_cast<std::size_t>(mode)) + ".pvd" : VtpTrajectory::list_name;
  const fs::path list = directory / list_name;
  const std::string name = directory.string();
  if (!fs::exists(directory)) throw InputError(name, "there is no such folder");
  if (!fs::is_directory(directory)) throw InputError(name, "is a file; wanted the folder of a run, such as net.out");
  if (const Json modes = mode > 0 ? read_summary(directory).value("modes", Json()) : Json(); modes.is_object()) {
    const int count = modes.value("count", 0);
    if (count > 0 && mode > count)
      throw InputError("--mode", fmt::format("there is no mode {} in {}; there {}", mode, name,
                                             count > 1 ? fmt::format("are modes 1 to {}", count) : "is mode 1 alone"));
  }
  if (!fs::exists(list)) {
    throw InputError(name, fmt::format("there is no {}; tanor {} makes it", list_name,
                                       mode > 0 ? "modes SCENE --pictures --out " + name
                                                : "run SCENE --out " + name + " --trajectory xyz,vtp"));
  }
  frames_ = read_frame_list(list);
  if (!frames_.empty()) return;
  const std::string why = read_stop(directory);
  throw InputError(list.string(), "names no frames" + (why.empty() ? why : ", since the motion did not start: " + why));
}

StoredMotion::Instant StoredMotion::at(double time) const {
  // A time printed with some digits must still find its frame.
  const double rounding = 1e-9 * (end() - begin());
  const auto after =
      std::ranges::lower_bound(frames_.begin(), frames_.end() - 1, time - rounding, {}, &ListedFrame::time);
  const auto before = after == frames_.begin() || after->time <= time + rounding ? after : after - 1;
  StoredFrame first = read_vtp(before->file);
  if (before == after) {
    leave_out_gone(&first);
    return {std::move(first), before->time, before->time};
  }
  const StoredFrame last = read_vtp(after->file);
  if (last.positions.size() != first.positions.size() || last.rods != first.rods ||
      last.guide_forces.size() != first.guide_forces.size() ||
      last.friction_forces.size() != first.friction_forces.size())
    throw InputError(after->file.string(), "holds other points or rods than the frame before");
  const double distance = after->time - before->time, part = (time - before->time) / distance;
  StoredFrame frame = first;
  frame.time = time;
  frame.positions = follow_hermite(first, last, distance, part);
  if (std::ranges::any_of(frame.positions, [](double x) { return !(std::abs(x) <= largest_place); }))
    throw InputError(after->file.string(), "holds velocities that lead too far away, or is damaged");
  frame.tensions = mix(first.tensions, last.tensions, part);
  frame.guide_forces = mix(first.guide_forces, last.guide_forces, part);
  frame.friction_forces = mix(first.friction_forces, last.friction_forces, part);
  frame.guides = mix_guides(std::move(first.guides), last.guides, part);
  for (std::size_t k = 0; k < frame.tensions.size(); ++k)
    if (std::isnan(last.tensions[k])) frame.tensions[k] = first.tensions[k];  // it goes on the way
  frame.rods_gone = last.rods_gone;
  frame.supports_gone = last.supports_gone;
  leave_out_gone(&frame);
  return {std::move(frame), before->time, after->time};
}

MotionExtent StoredMotion::measure(bool with_guides) const {
  constexpr double most_points = 5e5;
  constexpr std::size_t least_frames = 12, most_frames = 400;
  const auto read = [&](std::size_t k) {
    StoredFrame frame = read_vtp(frames_[k].file);
    leave_out_gone(&frame);
    return frame;
  };
  std::vector<StoredFrame> frames{read(0)};
  const auto affordable = static_cast<std::size_t>(most_points / static_cast<double>(frames[0].num_points()));
  const std::size_t count = std::min(frames_.size(), std::clamp(affordable, least_frames, most_frames));
  for (std::size_t k = 1; k < count; ++k) frames.push_back(read(k * (frames_.size() - 1) / (count - 1)));
  if (!with_guides)
    for (StoredFrame& frame : frames) frame.guides.clear();
  MotionExtent extent = measure_motion(frames);
  if (const auto of_page = read_colours(directory_)) extent.tensions = *of_page;
  return extent;
}

}  // namespace tanor::report
