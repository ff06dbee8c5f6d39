#include "scene/scene.hpp"

#include <algorithm>
#include <array>
#include <iterator>

#include <fmt/format.h>

#include "scene/entries.hpp"
#include "scene/parts.hpp"
#include "scene/points.hpp"
#include "scene/text_file.hpp"

namespace tanor::scene {
namespace {

void check_version(const Cursor& version) {
  if (!version.is_number() || version.number() != 1.0) version.fail("1, the version of the scene format");
}

/// Reads the names for formulas. Each name must itself be a valid formula.
Constants read_parameters(const Cursor& parameters) {
  constexpr std::size_t most = 1000;  // every formula is compared with all of them
  Constants constants;
  const std::size_t count = parameters.members("an object of numbers").size();
  if (count > most) parameters.complain(fmt::format("found {} of them, wanted at most {}", count, most));
  for (const auto& [key, value] : parameters.members("an object of numbers")) {
    const std::string name(key);
    const double number = value.number();
    value.locate([&] { return ScalarFunction::formula(name, {{name, number}}); });
    constants.emplace(name, number);
  }
  return constants;
}

/// Names groups by their index in the scene's list, although groups that came with the points come first in the system.
void name_by_scene_index(std::vector<Constraint>* constraints) {
  for (std::size_t k = 0; k < constraints->size(); ++k) {
    const std::string kind(kind_name((*constraints)[k]));
    const auto name = [&](auto& group) {
      if (group.name.empty()) group.name = kind + std::to_string(k);
    };
    std::visit(name, (*constraints)[k]);
  }
}

template <class T>
void append(std::vector<T> tail, std::vector<T>* list) {
  list->insert(list->end(), std::make_move_iterator(tail.begin()), std::make_move_iterator(tail.end()));
}

/// Translates places of `validate` into places of the scene. The former are indices of the system's lists, in which the
/// supports and constraints that came with the points come first, and such forces last.
class PlaceTranslator {
 public:
  PlaceTranslator(const Cursor& root, std::size_t num_own_supports, std::size_t num_own_constraints,
                  std::size_t num_scene_forces)
      : root_(root),
        source_(find_point_source(root)),
        num_own_supports_(num_own_supports),
        num_own_constraints_(num_own_constraints),
        num_scene_forces_(num_scene_forces) {}

  /// Finds a place for a message about it: a missing value has a place, too.
  Cursor find(std::string_view place, std::string_view what) const {
    const Cursor found = find(place);
    const bool is_missing = what.starts_with("is missing") && found.is_object();
    return is_missing ? found[place.substr(place.rfind('/') + 1)] : found;
  }
  /// Finds the value of the scene that a JSON pointer of the system refers to, or the nearest one around it.
  Cursor find(std::string_view place) const {
    std::vector<std::string> steps = split(place);
    if (steps.empty()) return root_;
    if (steps[0] == "points") return follow(source_, steps, 1);
    if (steps[0] == "forces" && steps.size() > 1 && std::stoul(steps[1]) >= num_scene_forces_) return source_;
    const std::size_t num_own = steps[0] == "supports"      ? num_own_supports_
                                : steps[0] == "constraints" ? num_own_constraints_
                                                            : 0;
    if (steps.size() > 1 && num_own > 0) {
      const std::size_t index = std::stoul(steps[1]);
      if (index < num_own) return source_;
      steps[1] = std::to_string(index - num_own);
    }
    return follow(root_, steps, 0);
  }

  /// Returns the message with the places that it names translated.
  std::string translate(std::string_view message) const {
    std::string translated;
    while (!message.empty()) {
      const std::size_t end = std::min(message.find(' '), message.size() - 1) + 1;
      const std::string_view word = message.substr(0, end), place = trim(word);
      const bool is_place = place.starts_with("/supports/") || place.starts_with("/constraints/");
      translated += is_place ? find(place).pointer() : std::string(place);
      translated += word.substr(place.size());
      message.remove_prefix(end);
    }
    return translated;
  }

 private:
  /// Returns the steps of a JSON pointer; those of the system have no escapes.
  static std::vector<std::string> split(std::string_view pointer) {
    std::vector<std::string> steps;
    for (const char c : pointer) {
      if (c == '/')
        steps.emplace_back();
      else if (!steps.empty())
        steps.back() += c;
    }
    return steps;
  }

  static Cursor follow(Cursor cursor, const std::vector<std::string>& steps, std::size_t first) {
    for (std::size_t k = first; k < steps.size(); ++k) cursor = cursor.follow(steps[k]);
    return cursor;
  }

  Cursor root_, source_;
  std::size_t num_own_supports_, num_own_constraints_, num_scene_forces_;
};

/// Reads a periodic cell from its edges as LAMMPS has them: a along x, b in the plane of x and y.
Cell read_cell(const Cursor& cell) {
  cell.object(keys_of("cell"));
  constexpr std::string_view wanted = "edges [[a, 0, 0], [b, c, 0], [d, e, f]] with a, c and f > 0";
  std::vector<Vector3> rows;
  for (const Cursor edge : cell["edges"].list(wanted)) rows.push_back(edge.vector3());
  const auto is_wrong = [&] {
    const auto& [a, b, c] = std::array{rows[0], rows[1], rows[2]};
    return a[1] != 0.0 || a[2] != 0.0 || b[2] != 0.0 || !(std::min({a[0], b[1], c[2]}) > 0.0);
  };
  if (rows.size() != 3 || is_wrong()) cell["edges"].fail(wanted);
  return {rows[0][0], rows[1][1], rows[2][2], rows[1][0], rows[2][0], rows[2][1], cell["origin"].vector3(Vector3{})};
}

/// Returns the box that is drawn around a sample.
std::optional<Cell> find_cell(const PointSet& points, const std::vector<Force>& forces) {
  if (points.cell && points.cell->is_periodic()) return points.cell;
  for (const Force& force : forces) {
    const auto* pairs = std::get_if<PairForces>(&force);
    if (!pairs) continue;
    const Cell cell{.xx = pairs->box[0], .yy = pairs->box[1], .zz = pairs->box[2]};
    if (cell.is_periodic()) return cell;
  }
  return {};
}

}  // namespace

Scene load_scene(const std::filesystem::path& file, const Overrides& overrides) {
  std::string text;
  try {
    text = read_text(file);
  } catch (const InputError& error) {
    throw InputError(file.string(), error.what());
  }
  return parse_scene(text, file, overrides);
}

Scene load_moving_scene(const std::filesystem::path& file, const Overrides& overrides) {
  Scene scene = load_scene(file, overrides);
  if (scene.has_end()) return scene;
  try {
    (void)Simulation(scene.system, scene.motion, scene.solver, scene.t_start);  // no end mends a wrong start
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.where(), error.what());
  }
  throw InputError(file.string() + ": /motion/t_end", "is missing; give it there or with --t-end (s)");
}

Scene parse_scene(const std::string& text, const std::filesystem::path& file, const Overrides& overrides) {
  const Document document(text, file.string());
  const Cursor root(document);
  root.object(keys_of(""));
  check_version(root["tanor_scene"]);

  Scene scene;
  scene.file = file;
  scene.files = {file};
  scene.name = root["name"].string(file.stem().string());
  if (scene.name.empty()) root["name"].fail("a name");
  std::size_t num_named = 0;
  Context context{.directory = file.parent_path(),
                  .files = &scene.files,
                  .parameters = read_parameters(root["parameters"]),
                  .num_named = &num_named};

  PointSet points = read_point_source(root, context);
  const std::size_t num_own_supports = points.supports.size(), num_own_constraints = points.constraints.size();
  if (root["cell"] && points.cell) root["cell"].complain("found beside a file that has a periodic cell");
  if (root["cell"]) points.cell = read_cell(root["cell"]);
  context.num_points = points.positions.size() / 3;
  context.cell = points.cell;
  read_motion(root["motion"], context, overrides, &scene);
  read_solver(root["solver"], overrides, &scene);
  context.t_start = scene.t_start;
  context.t_end = scene.has_end() ? scene.t_end : std::max(0.0, scene.t_start);

  std::vector<Constraint> constraints = read_entries<Constraint>(root["constraints"], "a list of constraints", context);
  if (!points.constraints.empty()) name_by_scene_index(&constraints);
  append(std::move(constraints), &points.constraints);
  append(read_supports(root["supports"], context), &points.supports);
  context.constraints = points.constraints;
  std::vector<Force> forces = read_entries<Force>(root["forces"], "a list of forces", context);
  const PlaceTranslator places(root, num_own_supports, num_own_constraints, forces.size());
  append(std::move(points.forces), &forces);

  scene.source = points.source;
  scene.left_out = std::move(points.left_out);
  const std::optional<Cell> cell = find_cell(points, forces);
  scene.system = {.name = scene.name,
                  .positions = std::move(points.positions),
                  .velocities = std::move(points.velocities),
                  .masses = std::move(points.masses),
                  .supports = std::move(points.supports),
                  .constraints = std::move(points.constraints),
                  .forces = std::move(forces),
                  .friction = read_entries<Friction>(root["friction"], "a list of friction laws", context),
                  .coordinates = read_entries<Coordinates>(root["coordinates"], "a list of coordinates", context),
                  .cell = cell,
                  .units = read_units(root["units"], points.units)};
  read_equilibrium(root["equilibrium"], &scene);
  read_modes(root["modes"], &scene);
  try {
    validate(scene.system, scene.t_start);
  } catch (const InputError& error) {
    places.find(error.where(), error.what()).complain(places.translate(error.what()));
  }
  scene.observables = read_observables(root["observe"], scene.system, context.parameters);
  scene.events = read_events(root["events"], scene.system, context.parameters);
  return scene;
}

void add_events(const Scene& scene, Simulation* simulation) {
  for (std::size_t k = 0; k < scene.events.size(); ++k) {
    try {
      simulation->add_event(scene.events[k]);
    } catch (const InputError& error) {
      throw InputError("/events/" + std::to_string(k), error.what());
    }
  }
}

}  // namespace tanor::scene
