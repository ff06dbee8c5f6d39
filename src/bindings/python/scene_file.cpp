#include "python/scene_file.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include "python/bindings.hpp"
#include "python/carried.hpp"
#include "python/kinds.hpp"
#include "scene/cursor.hpp"
#include "scene/document.hpp"
#include "scene/entries.hpp"
#include "scene/text_file.hpp"

namespace tanor::python {
namespace {

using namespace py::literals;

scene::Overrides overrides_of(const py::dict& given) {
  scene::Overrides o;
  const auto take = [&](const char* name, auto* value) {
    if (const py::object found = given[name]; !found.is_none()) read({found, name}, &value->emplace());
  };
  take("method", &o.method);
  take("step", &o.step);
  take("max_step", &o.max_step);
  take("rtol", &o.rtol);
  take("atol", &o.atol);
  take("t_end", &o.t_end);
  take("threads", &o.threads);
  return o;
}

std::unique_ptr<SceneFile> load(const py::object& file, const py::object& method, const py::object& step,
                                const py::object& max_step, const py::object& rtol, const py::object& atol,
                                const py::object& t_end, const py::object& threads) {
  const std::string path = py::module_::import("os").attr("fspath")(file).cast<std::string>();
  const auto named = py::dict("method"_a = method, "step"_a = step, "max_step"_a = max_step, "rtol"_a = rtol,
                              "atol"_a = atol, "t_end"_a = t_end, "threads"_a = threads);
  auto result = std::make_unique<SceneFile>(scene::read_text(path), path, named);
  result->read();  // reports errors now
  return result;
}

py::tuple get_state(const SceneFile& self) {
  return py::make_tuple(self.text, self.file, py::tuple(self.overrides.attr("items")()), self.seen);
}

std::unique_ptr<SceneFile> set_state(const py::tuple& s) {
  auto result = std::make_unique<SceneFile>(s[0].cast<std::string>(), s[1].cast<std::string>(), py::dict(s[2]));
  result->seen = s[3].attr("copy")().cast<py::dict>();
  return result;
}

/// Binds a part of a scene as one object, which is made when it is asked for and is what the scene consists of then.
template <class Make>
void bind_part(py::class_<SceneFile>* scene, const char* part, const char* doc, const Make& make) {
  const auto get = [part, make](const py::object& self) -> py::object {
    const py::dict seen = self.cast<SceneFile&>().seen;
    if (!seen.contains(part)) seen[part] = make(self);
    return seen[part];
  };
  scene->def_property_readonly(part, get, doc);
}

constexpr const char* scene_doc = R"doc(
A scene file: a system with its motion, for Simulation, Dynamics, InverseDynamics and run_scene. The format is
docs/scene-format.md. What is changed in `system`, `motion` and `solver` holds for the scene.

file                                          a path
method, step, max_step, rtol, atol, t_end, threads  values that replace those of the file, as the options of the
                                              program do; s, > 0
Raises InputError with the file, the place in it and the rule.
)doc";

}  // namespace

SceneFile::SceneFile(std::string the_text, std::string the_file, py::dict the_overrides)
    : text(std::move(the_text)), file(std::move(the_file)), overrides(std::move(the_overrides)) {}

void SceneFile::read_with(const py::dict& changed) {
  const scene::Overrides read = overrides_of(changed);
  try {
    scene_ = without_lock([&] { return scene::parse_scene(text, file, read); });
  } catch (const InputError& error) {
    std::string where = error.where();
    if (!where.starts_with("--")) throw;
    std::ranges::replace(where, '-', '_');  // --t-end is an option of the program
    throw InputError(where.substr(2), error.what());
  }
  overrides = changed;
}

const scene::Scene& SceneFile::read() {
  if (!scene_) read_with(overrides);
  return *scene_;
}

void bind_scene(py::module_& module) {
  using py::arg;
  const py::none none;
  py::class_<SceneFile> scene(module, "Scene", scene_doc);
  scene
      .def(py::init(&load), arg("file"), py::kw_only(), arg("method") = none, arg("step") = none,
           arg("max_step") = none, arg("rtol") = none, arg("atol") = none, arg("t_end") = none, arg("threads") = none)
      .def_readonly("file", &SceneFile::file, "(str) its path")
      .def_property_readonly(
          "t_start", [](SceneFile& self) { return self.read().t_start; }, "(float) s")
      .def_property(
          "t_end",
          [](SceneFile& self) { return self.read().has_end() ? std::optional(self.read().t_end) : std::nullopt; },
          [](SceneFile& self, const py::object& t_end) {
            const py::dict changed(self.overrides.attr("copy")());
            changed["t_end"] = t_end;
            self.read_with(changed);
          },
          "(float | None) s; None: not given")
      .def_property_readonly(
          "output_every", [](SceneFile& self) { return self.read().output_every; },
          "(float) s; 0: start and end only. `run` takes another one, run(Simulation(scene), t_end, every=0.1)")
      .def_property_readonly(
          "num_points", [](const py::object& self) { return read_system(self).num_points(); },
          "(int) supports included")
      .def_property_readonly(
          "old_names", [](SceneFile& self) { return self.read().old_names; },
          "(list[str]) names of an older version that the file uses, with those of today")
      .def(py::pickle(&get_state, &set_state));
  bind_part(&scene, "system", "(System) what moves, to read and to change", [](const py::object& self) {
    return py::module_::import("tanor.description")
        .attr("note_origins")(give_system(self.cast<SceneFile&>().read().system), self);
  });
  bind_part(&scene, "motion", "(MotionOptions) how steps are taken", give_options<MotionOptions>);
  bind_part(&scene, "solver", "(SolverOptions) how solutions are found", give_options<SolverOptions>);
  for (const char* name : {"positions", "masses", "velocities", "supports", "constraints", "forces", "friction",
                           "coordinates", "cell", "units", "name"})
    scene.def_property(
        name, [name](const py::object& self) -> py::object { return self.attr("system").attr(name); },
        [name](const py::object& self, const py::object& value) { self.attr("system").attr(name) = value; },
        "(Any) of its system");
}

Units read_units(const py::object& object) {
  const Given given{object.attr("units"), "/units"};
  Units units;
  if (take_carried(given, &units)) return units;
  if (py::isinstance<py::dict>(given.value)) {  // letters of one's own, as in scenes
    const scene::Document document(py::module_::import("json").attr("dumps")(given.value).cast<std::string>(), "units");
    return scene::read_units(scene::Cursor(document), units);
  }
  std::string name;
  read(given, &name);
  return units_from_name(name);
}

}  // namespace tanor::python
