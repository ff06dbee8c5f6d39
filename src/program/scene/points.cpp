#include "scene/points.hpp"

#include <fmt/format.h>

#include "scene/parts.hpp"

namespace tanor::scene {
namespace {

/// Reads the table of {"file": …}, which has a known width.
std::vector<double> read_file(const Cursor& value, std::size_t columns, const Context& context) {
  const Cursor file = value.object({"file"})["file"];
  NumberTable table = context.number_table(file);
  if (table.rows > 0 && table.columns != columns)
    file.fail(fmt::format("a file of {} column{}, this one has {}", columns, columns > 1 ? "s" : "", table.columns));
  return std::move(table.values);
}

/// Reads n x 3 numbers, point by point.
std::vector<double> read_vectors(const Cursor& value, const Context& context) {
  if (value.is_object()) return read_file(value, 3, context);
  std::vector<double> vectors;
  for (const Cursor row : value.list(R"(a list of vectors [x, y, z] or {"file": "…"})")) {
    const Vector3 vector = row.vector3();
    vectors.insert(vectors.end(), vector.begin(), vector.end());
  }
  return vectors;
}

/// Reads one number for all points, or n of them.
std::vector<double> read_masses(const Cursor& value, std::size_t num_points, const Context& context) {
  if (!value || value.is_number()) return std::vector<double>(num_points, value.number(1.0));
  if (value.is_object()) return read_file(value, 1, context);
  std::vector<double> masses;
  for (const Cursor entry : value.list(R"(a number, a list of numbers or {"file": "…"})"))
    masses.push_back(entry.number());
  return masses;
}

void check_count(const Cursor& value, std::size_t found, std::size_t wanted) {
  if (found != wanted) value.complain(fmt::format("found {} of them, wanted {}, one a point", found, wanted));
}

}  // namespace

Cursor find_point_source(const Cursor& root) {
  const Cursor points = root["points"];
  Cursor source = points;
  for (const char* key : {"generate", "import"}) {
    const Cursor other = root[key];
    if (other && source)
      other.complain(fmt::format("found beside {}, wanted one of points, generate, import", source.pointer()));
    if (other) source = other;
  }
  if (!source) points.fail("one of points, generate, import");
  return source;
}

PointSet read_point_source(const Cursor& root, const Context& context) {
  const Cursor source = find_point_source(root);
  if (root["generate"]) return read_generate(source, context);
  if (root["import"]) return read_import(source, context);
  return read_points(source, context);
}

PointSet read_points(const Cursor& points, const Context& context) {
  points.object(keys_of("points"));
  PointSet set;
  set.source = "inline";
  set.positions = read_vectors(points["positions"], context);
  const std::size_t num_points = set.positions.size() / 3;
  if (num_points == 0) points["positions"].fail("at least one point");

  const Cursor velocities = points["velocities"], masses = points["masses"];
  if (velocities) {
    set.velocities = read_vectors(velocities, context);
    // An empty list is the default, "velocities 0".
    if (!set.velocities.empty()) check_count(velocities, set.velocities.size() / 3, num_points);
  }
  set.masses = read_masses(masses, num_points, context);
  check_count(masses, set.masses.size(), num_points);
  return set;
}

}  // namespace tanor::scene
