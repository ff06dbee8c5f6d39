#include "report/modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <vector>

#include "report/field_json.hpp"
#include "report/guides.hpp"
#include "report/npy.hpp"
#include "report/output_file.hpp"
#include "report/page.hpp"
#include "report/shown_parts.hpp"
#include "report/trajectory.hpp"
#include "report/vtp_frame.hpp"

namespace tanor::report {

namespace fs = std::filesystem;

namespace {

constexpr const char *shapes_name = "shapes.npy", *imaginary_name = "shapes_imaginary.npy";
constexpr int frames_of_period = 24;
constexpr double largest_move = 0.2;  // relative to half of the scene's size, in pictures

Json frequencies(const Modes& modes) {
  return list_of(modes.omega,
                 [](double omega) { return omega < 0.0 ? Json() : Json(omega / (2.0 * std::numbers::pi)); });
}

/// Returns half of the diagonal of the box around the points, or 1 m if it has no size.
double measure_size(std::span<const double> positions) {
  const double diagonal = measure_diagonal(positions);
  return diagonal > 0.0 ? 0.5 * diagonal : 1.0;
}

double measure_move(std::span<const double> shape) {
  double largest = 0.0;
  for (std::size_t i = 0; i < shape.size(); i += 3)
    largest = std::max(largest, std::hypot(shape[i], shape[i + 1], shape[i + 2]));
  return largest;
}

/// Writes r + a q cos(omega t) over one period, and its derivatives. Of damped modes q is the real part.
void write_picture(const fs::path& directory, const System& system, const ShownParts& shown, const Solution& rest,
                   const Modes& modes, std::size_t mode) {
  const std::string name = name_mode(mode + 1);
  const std::vector<double>& positions = rest.positions;
  make_folder(directory / name);
  const std::span<const double> shape = modes.shape(mode);
  const double size = measure_move(shape), amplitude = size > 0.0 ? largest_move * measure_size(positions) / size : 0.0;
  const double omega = modes.omega[mode] > 0.0 ? modes.omega[mode] : 2.0 * std::numbers::pi;
  std::vector<double> places(positions.size()), velocities(positions.size()), accelerations(positions.size());
  const std::vector<double> tensions = find_tensions(shown, unique_multipliers(modes.multipliers, rest.self_stress));
  const std::vector<Guide> guides =
      list_guides(system, shown, list_guides_without_picture(system, shown, rest.time), rest.time, rest.time);
  std::string list(VtpTrajectory::list_head);
  for (int k = 0; k < frames_of_period; ++k) {
    const double phase = 2.0 * std::numbers::pi * k / frames_of_period, time = phase / omega;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double move = amplitude * shape[i];
      places[i] = positions[i] + move * std::cos(phase);
      velocities[i] = -omega * move * std::sin(phase);
      accelerations[i] = -omega * omega * move * std::cos(phase);
    }
    const std::string frame = fmt::format("{}/frame_{:03}.vtp", name, k);
    write_vtp(directory / frame, shown,
              {.time = time,
               .positions = places,
               .velocities = velocities,
               .accelerations = accelerations,
               .tensions = tensions,
               .guides = guides,
               .gravity = find_gravity(system)});
    list += VtpTrajectory::list_frame(time, frame);
  }
  list += VtpTrajectory::list_tail;
  replace_file(directory / (name + ".pvd"), [&](OutputFile* file) { file->write(std::string_view(list)); });
}

}  // namespace

std::string unit_of_shapes(const Units& units) {
  return units.mass.empty() ? "" : "1/sqrt(" + units.mass + ")";
}

void add_modes(const fs::path& directory, const Units& units, const std::optional<Modes>& modes, JsonObjectFile* json) {
  for (const char* name : {shapes_name, imaginary_name}) remove_file(directory / name);
  if (!modes || !modes->outcome.ok()) return json->add("modes", {});
  const std::size_t count = modes->count(), points = count > 0 ? modes->shapes.size() / (3 * count) : 0;
  const auto write_shapes = [&](const char* name, const std::vector<double>& shapes) {
    replace_file(directory / name, [&](OutputFile* file) { write_npy(file, shapes, {count, points, 3}); });
    json->add_file(name, describe_array({"mode", "point", "x, y, z"}, unit_of_shapes(units)));
  };
  write_shapes(shapes_name, modes->shapes);
  const bool is_damped = !modes->decay.empty();
  if (is_damped) write_shapes(imaginary_name, modes->shapes_imaginary);
  json->begin_object("modes");
  json->add("count", count);
  json->add_numbers("omega", modes->omega);
  json->add("frequency_hz", frequencies(*modes));
  if (is_damped) json->add_numbers("decay", modes->decay);
  using M = Modes;
  json->add_members(
      json_of_members<&M::residual_max, &M::unstable_directions, &M::zero_modes, &M::rigid_zero_modes>(*modes));
  json->add("shapes", shapes_name);
  if (is_damped) json->add("shapes_imaginary", imaginary_name);
  json->end();
}

void write_modes(const fs::path& directory, const scene::Scene& scene, const Modes& modes,
                 std::span<const Observed> observed, const std::optional<Buckling>& buckling) {
  std::size_t supports = 0;
  for (const Support& support : scene.system.supports) supports += support.points.size();
  make_folder(directory);
  replace_file(directory / "summary.json", [&](OutputFile* file) {
    JsonObjectFile json(file);
    json.add_members(describe_head(scene.name, scene.source, scene.system.units, observed));
    json.add("points", scene.system.num_points());
    json.add("supports", supports);
    json.add("equations", modes.multipliers.size());
    json.add("degrees_of_freedom", modes.outcome.ok() ? Json(modes.degrees_of_freedom) : Json());
    add_modes(directory, scene.system.units, modes, &json);
    if (buckling) json.add("buckling_load_factor", buckling->outcome.ok() ? Json(buckling->load_factor) : Json());
    json.add("left_out", modes.left_out);
    json.finish();
  });
}

std::vector<fs::path> list_modes(const fs::path& directory) {
  std::vector<fs::path> files{directory / shapes_name, directory / imaginary_name};
  std::error_code error;  // without a folder there are none
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, error)) {
    const std::string stem = entry.path().stem().string();
    const bool is_numbered =
        stem.starts_with(mode_prefix) && stem.size() > mode_prefix.size() &&
        std::ranges::all_of(stem.substr(mode_prefix.size()), [](unsigned char c) { return std::isdigit(c); });
    const std::string ending = entry.path().extension().string();
    if (!is_numbered || (ending != ".pvd" && ending != ".png")) continue;
    files.push_back(entry.path());
    if (ending == ".pvd")
      std::ranges::copy(list_frames(fs::path(entry.path()).replace_extension()), std::back_inserter(files));
  }
  return files;
}

void write_mode_pictures(const fs::path& directory, const System& system, const Solution& rest, const Modes& modes) {
  const ShownParts shown = choose_parts(system, {});
  for (std::size_t mode = 0; mode < modes.count(); ++mode) write_picture(directory, system, shown, rest, modes, mode);
}

}  // namespace tanor::report
