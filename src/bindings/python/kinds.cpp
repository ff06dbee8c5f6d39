#include "python/kinds.hpp"

#include <functional>
#include <string>
#include <tuple>
#include <variant>

#include "base/member_names.hpp"
#include "python/carried.hpp"
#include "python/functions.hpp"
#include "python/header_docs.hpp"
#include "python/scene_file.hpp"
#include "scene/scene.hpp"

namespace tanor::python {
using namespace detail;

namespace {

/// Members of a struct that the fields of its kind do not list, since scene files spell them in a way of their own.
template <class Group>
struct Extra {
  static constexpr auto law_or_kernel() {
    if constexpr (requires(Group group) { group.law; })
      return std::tuple{FieldOf("law", &Group::law)};
    else if constexpr (requires(Group group) { group.kernel; })
      return std::tuple{FieldOf("kernel", &Group::kernel, {.is_required = true})};
    else
      return std::tuple<>{};
  }
  static constexpr auto fields = law_or_kernel();
};
template <>
struct Extra<FormulaForce> {
  static constexpr bool members_are_optional = true;
  static constexpr std::tuple fields{FieldOf("tuples", &FormulaForce::tuples),
                                     FieldOf("kernel", &FormulaForce::kernel, {.is_required = true})};
};
template <>
struct Extra<Potential> {
  static constexpr std::tuple fields{FieldOf("kernel", &Potential::kernel, {.is_required = true}),
                                     FieldOf("constants", &Potential::constants)};
};
template <>
struct Extra<Torsions> {
  static constexpr std::tuple fields{FieldOf("law", &Torsions::law),
                                     FieldOf("coefficients", &Torsions::coefficients, {.unit = "J"}),
                                     FieldOf("multiplicity", &Torsions::multiplicity)};
};
template <>
struct Extra<UserCoordinates> {
  static constexpr std::tuple fields{FieldOf("kernel", &UserCoordinates::kernel, {.is_required = true}),
                                     FieldOf("q", &UserCoordinates::q, {.is_required = true}),
                                     FieldOf("q_dot", &UserCoordinates::q_dot)};
};
template <>
struct Extra<PairForces> {
  static constexpr bool members_are_optional = true;
  static constexpr std::tuple fields{FieldOf("law", &PairForces::law), FieldOf("box", &PairForces::box, {.unit = "m"}),
                                     FieldOf("exclude_rods", &PairForces::exclude_rods),
                                     FieldOf("charges", &PairForces::charges)};
};
template <>
struct Extra<Coulomb> {
  static constexpr std::tuple fields{FieldOf("regularisation", &Coulomb::regularisation, {.unit = "m/s"}),
                                     FieldOf("reaction", &Coulomb::reaction)};
};

template <class Group>
concept HasOptionalMembers = requires {
  Extra<Group>::members_are_optional;
};

/// All fields of a kind of <tanor/kinds.hpp>: its members and guides first, its name last.
template <class Group>
struct Description {
  static constexpr auto members() {
    if constexpr (requires { KindOf<Group>::members; })
      return std::tuple{
          FieldOf(list_name<Group>(), KindOf<Group>::members, {.is_required = !HasOptionalMembers<Group>})};
    else
      return std::tuple<>{};
  }
  static constexpr auto guides() {
    if constexpr (requires(Group group) { group.at; })
      return std::tuple{FieldOf("at", &Group::at, {.is_required = true})};
    else
      return std::tuple<>{};
  }
  static constexpr auto fields = std::tuple_cat(members(), guides(), KindOf<Group>::fields, Extra<Group>::fields,
                                                std::tuple{FieldOf("name", &Group::name)});
};
template <>
struct Description<Support> {
  static constexpr std::tuple fields{FieldOf("points", &Support::points, {.is_required = true}),
                                     FieldOf("displacement", &Support::displacement, {.unit = "m"}),
                                     FieldOf("name", &Support::name)};
};
/// Returns members as fields of their own names.
template <auto... members>
constexpr std::tuple own_fields{FieldOf(member_key<members>.data(), members)...};

template <>
struct Description<SolverOptions> {
  static constexpr const char* place = "/solver";
  static constexpr auto of_scene = &scene::Scene::solver;
  using S = SolverOptions;
  static constexpr auto fields = own_fields<&S::form, &S::linear_solver, &S::ordering, &S::threads, &S::friction,
                                            &S::reuse, &S::exact, &S::contact>;
};
template <>
struct Description<MotionOptions> {
  static constexpr const char* place = "/motion";
  static constexpr auto of_scene = &scene::Scene::motion;
  using M = MotionOptions;
  static constexpr auto fields = own_fields<&M::method, &M::step, &M::max_step, &M::rtol, &M::atol, &M::stabilisation,
                                            &M::start, &M::order, &M::spectral_radius>;
};
template <>
struct Description<EquilibriumOptions> {
  static constexpr const char* place = "/equilibrium";
  static constexpr auto of_scene = &scene::equilibrium_options;
  using E = EquilibriumOptions;
  static constexpr auto fields =
      own_fields<&E::method, &E::force_tolerance, &E::max_iterations, &E::accept, &E::at, &E::load_steps, &E::prestress,
                 &E::one_sided, &E::ignore_friction, &E::freeze_time>;
};
template <>
struct Description<ModesOptions> {
  static constexpr const char* place = "/modes";
  static constexpr auto of_scene = &scene::modes_options;
  using M = ModesOptions;
  static constexpr auto fields = own_fields<&M::count, &M::time, &M::prestress, &M::force_tolerance, &M::tolerance,
                                            &M::ignore_friction, &M::damped, &M::freeze_time>;
};
template <>
struct Description<BucklingOptions> {
  static constexpr const char* place = "/buckling";
  static constexpr auto of_scene = &scene::buckling_options;
  using B = BucklingOptions;
  static constexpr auto fields =
      std::tuple_cat(std::tuple{FieldOf("loads", &B::loads, {.is_required = true})},
                     own_fields<&B::time, &B::force_tolerance, &B::ignore_friction, &B::freeze_time>);
};

template <class Struct, class Visit>
void for_each_described(const Visit& visit) {
  std::apply([&](const auto&... field) { (visit(field), ...); }, Description<Struct>::fields);
}

/// Reads a field. A kernel also needs what else its group says.
template <class Group, class Value>
void read_field(const Given& given, const FieldOf<Group, Value>& field, Group* group) {
  const Given own = given[field.name];
  if (take_carried(own, &(group->*field.value))) return;
  if constexpr (std::is_same_v<Value, ConstraintKernel>) {
    read(own, group->tuples.empty() ? 1 : static_cast<int>(group->tuples[0].size()), &(group->*field.value));
  } else if constexpr (std::is_same_v<Value, ForceKernel>) {
    read(own, group->tuples.empty() ? 0 : static_cast<int>(group->tuples[0].size()), &(group->*field.value));
  } else if constexpr (std::is_same_v<Value, PotentialKernel>) {
    std::vector<std::string> names;
    const Given constants = given["constants"];
    if (py::isinstance<py::dict>(constants.value)) {
      for (const auto& [name, numbers] : py::dict(constants.value)) names.push_back(name.template cast<std::string>());
    }
    read(own, group->points.empty() ? 1 : static_cast<int>(group->points[0].size()), names, &(group->*field.value));
  } else if constexpr (std::is_same_v<Value, FrictionKernel>) {
    int num_multipliers = 0;
    read(given["num_multipliers"], &num_multipliers);
    read(own, num_multipliers, &(group->*field.value));
  } else if constexpr (std::is_same_v<Value, CoordinateKernel>) {
    std::vector<std::string> names;
    read(given["names"], &names);
    read(own, names, &(group->*field.value));
  } else {
    read(own, &(group->*field.value));
  }
}

std::string class_of(const Given& given) {
  return py::str(py::type::of(given.value).attr("__name__")).cast<std::string>();
}

template <class Struct>
Struct read_struct(const Given& given) {
  const std::string wanted(name_of_struct<Struct>());
  if (class_of(given) != wanted) {
    if constexpr (requires { Description<Struct>::place; })
      given.fail(wanted + ", or its fields by name, " + std::get<0>(Description<Struct>::fields).name + "=...");
    given.fail("a " + wanted);
  }
  Struct result;
  for_each_described<Struct>([&](const auto& field) { read_field(given, field, &result); });
  return result;
}

/// Returns the object of Python's class of that name that describes a struct.
template <class Struct>
py::object give_struct(const Struct& group) {
  py::dict fields;
  for_each_described<Struct>([&](const auto& field) { fields[field.name] = give(group.*field.value); });
  if constexpr (std::is_same_v<Struct, UserFriction>) fields["num_multipliers"] = 0;    // its kernel is carried
  if constexpr (std::is_same_v<Struct, UserCoordinates>) fields["names"] = py::list();  // likewise
  return py::module_::import("tanor").attr(std::string(name_of_struct<Struct>()).c_str())(**fields);
}

template <class Entry>
py::list give_entries(const std::vector<Entry>& entries) {
  py::list list;
  for (const Entry& entry : entries)
    list.append(std::visit([](const auto& group) { return give_struct(group); }, entry));
  return list;
}

/// Reads one of the kinds of a list.
template <class Entry>
struct AnyOf;
template <class... Groups>
struct AnyOf<std::variant<Groups...>> {
  static std::variant<Groups...> read(const Given& given) {
    const std::string name = class_of(given);
    std::variant<Groups...> result;
    const bool is_known = ((name == name_of_struct<Groups>() && (result = read_struct<Groups>(given), true)) || ...);
    if (is_known) return result;
    std::string all;
    ((all += (all.empty() ? "" : ", ") + std::string(name_of_struct<Groups>())), ...);
    given.fail("one of " + all);
  }
  static void describe(const char* list, py::list* all);
};

template <class Entry>
std::vector<Entry> read_entries(const Given& list, const char* wanted) {
  std::vector<Entry> entries;
  for (const Given& each : list.entries(wanted)) entries.push_back(AnyOf<Entry>::read(each));
  return entries;
}

/// Returns what a kernel may be, in words.
template <class Kernel>
constexpr const char* kernel_in_words() {
  if constexpr (std::is_same_v<Kernel, ForceKernel>)
    return "three formulas in x, y, z, vx, vy, vz, t, or a callable (t, r [k, 3], v [k, 3]) -> forces [k, 3], N; with "
           "tuples three for each of their points in x1, y1, z1, x2, ..., vx1, ..., t, or a callable (t, r [k, p, 3], "
           "v [k, p, 3]) -> forces [k, p, 3]";
  if constexpr (std::is_same_v<Kernel, ConstraintKernel>)
    return "a formula in x1, y1, z1, x2, ..., t, or a callable (t, r [k, p, 3], v [k, p, 3]) -> (xi [k], gradient "
           "[k, p, 3], rate [k], phi [k])";
  if constexpr (std::is_same_v<Kernel, PotentialKernel>)
    return "a formula in x1, y1, z1, x2, ..., t and the names of the constants, J, a Definition of (r1 [3], r2 [3], "
           "..., t, and the constants by name), or a callable r [k, p, 3] -> (energy [k], gradient [k, p, 3], hessian "
           "[k, 3p, 3p] or None)";
  if constexpr (std::is_same_v<Kernel, FrictionKernel>)
    return "a callable (t, r [k, 3], v [k, 3], multipliers [k, p]) -> (tau [k, 3], N, its derivative in the "
           "multipliers [k, 3, p])";
  if constexpr (std::is_same_v<Kernel, CoordinateKernel>)
    return "formulas x, y, z of each point in the names of the coordinates and t, [3p]";
  return "";
}

/// Returns "float [3]; m; …": the shape, then what the header says of the field, or its unit.
template <class Struct, class Value>
std::string text_of(const FieldOf<Struct, Value>& field) {
  const std::string said = header_doc(std::string(name_of_struct<Struct>()) + "." + field.name);
  std::string text = in_words<Value>().shape;
  if (text.empty()) text = kernel_in_words<Value>();
  if constexpr (std::is_enum_v<Value> && !std::is_same_v<Value, Method>) text = "one of " + words_of<Value>();
  const std::string unit = field.data.unit;
  if (!said.empty()) {
    text += (text.empty() ? "" : "; ") + said;
  } else if (!unit.empty()) {
    text += "; " + unit;
  }
  return text;
}

template <class Struct>
void describe(const char* list, const std::string& kind, py::list* all) {
  py::list fields;
  const Struct defaults;
  for_each_described<Struct>([&]<class Value>(const FieldOf<Struct, Value>& field) {
    const bool is_required = field.data.is_required;
    py::object value = py::none();
    if constexpr (!requires { (defaults.*field.value).evaluate; }) {
      if (!is_required) value = default_of(defaults.*field.value);
    }
    fields.append(
        py::make_tuple(field.name, std::string(in_words<Value>().annotation), text_of(field), value, is_required));
  });
  py::dict entry;
  entry["list"] = list;
  entry["name"] = std::string(name_of_struct<Struct>());
  entry["kind"] = kind;
  entry["doc"] = header_doc(name_of_struct<Struct>());
  entry["fields"] = fields;
  all->append(entry);
}

template <class... Groups>
void AnyOf<std::variant<Groups...>>::describe(const char* list, py::list* all) {
  (python::describe<Groups>(list, std::string(KindOf<Groups>::name), all), ...);
}

/// Returns the name of units that have one.
py::object give_units(const Units& units) {
  for (const char* name : {"none", "si", "lj", "real", "metal"})
    if (units == units_from_name(name)) return py::str(name);
  return give(units);
}

}  // namespace

std::vector<Constraint> read_constraints(const py::object& constraints) {
  return read_entries<Constraint>({constraints, "/constraints"}, "a list of constraints");
}

System read_system(const py::object& object) {
  if (py::isinstance<SceneFile>(object)) {
    auto& scene = object.cast<SceneFile&>();
    return scene.seen.contains("system") ? read_system(scene.seen["system"]) : scene.read().system;
  }
  if (!py::hasattr(object, "positions"))
    throw py::type_error("found " + py::repr(object).cast<std::string>() + ", wanted a System or a Scene");
  const Given given{object, ""};
  System system;
  std::vector<Vector3> positions, velocities;
  read(given["name"], &system.name);
  read(given["positions"], &positions);
  const py::module_ numpy = py::module_::import("numpy");
  const auto dimensions = [&](const Given& each) { return numpy.attr("ndim")(each.value).cast<int>(); };
  if (dimensions(given["masses"]) == 0) {
    read(given["masses"], &system.masses.emplace_back());
    system.masses.resize(positions.size(), system.masses[0]);
  } else {
    read(given["masses"], &system.masses);
  }
  system.units = read_units(object);
  if (!take_carried(given["cell"], &system.cell) && !object.attr("cell").is_none()) {
    Vector3 edges{};
    read(given["cell"], &edges);
    system.cell = Cell{.xx = edges[0], .yy = edges[1], .zz = edges[2]};
  }
  Given all = given["velocities"];
  if (dimensions(all) == 1 && py::len(all.value) == 3)
    all.value = numpy.attr("broadcast_to")(all.value, py::make_tuple(positions.size(), 3));
  if (!all.value.is_none()) read(all, &velocities);
  const std::string n = std::to_string(positions.size());
  if (system.masses.size() != positions.size()) given["masses"].fail(n + " numbers, or one for all points");
  if (!velocities.empty() && velocities.size() != positions.size())
    given["velocities"].fail("numbers [" + n + ", 3], or [3] for all points");
  for (const Vector3& r : positions) system.positions.insert(system.positions.end(), r.begin(), r.end());
  for (const Vector3& v : velocities) system.velocities.insert(system.velocities.end(), v.begin(), v.end());
  for (const Given& each : given["supports"].entries("a list of supports"))
    system.supports.push_back(read_struct<Support>(each));
  system.constraints = read_constraints(object.attr("constraints"));
  system.forces = read_entries<Force>(given["forces"], "a list of forces");
  system.friction = read_entries<Friction>(given["friction"], "a list of laws of friction");
  system.coordinates = read_entries<Coordinates>(given["coordinates"], "a list of coordinates");
  return system;
}

py::object give_system(const System& system) {
  const auto rows = [](const std::vector<double>& numbers) { return copy(numbers, 3); };
  py::list supports;
  for (const Support& each : system.supports) supports.append(give_struct(each));
  py::dict fields;
  fields["positions"] = rows(system.positions);
  fields["masses"] = give(system.masses);
  fields["velocities"] = system.velocities.empty() ? py::object(py::none()) : rows(system.velocities);
  fields["supports"] = supports;
  fields["constraints"] = give_entries(system.constraints);
  fields["forces"] = give_entries(system.forces);
  fields["friction"] = give_entries(system.friction);
  fields["coordinates"] = give_entries(system.coordinates);
  fields["name"] = system.name;
  fields["cell"] = system.cell ? give(system.cell) : py::object(py::none());
  fields["units"] = give_units(system.units);
  return py::module_::import("tanor").attr("System")(**fields);
}

template <class Options>
py::object give_options(const py::object& system) {
  return give_struct(choose_options<Options>(py::none(), system));
}
template <class Options>
Options choose_options(const py::object& options, const py::object& system) {
  if (!options.is_none()) return read_struct<Options>({options, Description<Options>::place});
  if (!py::isinstance<SceneFile>(system)) return {};
  auto& scene = system.cast<SceneFile&>();
  const char* part = Description<Options>::place + 1;
  if (scene.seen.contains(part)) return read_struct<Options>({scene.seen[part], Description<Options>::place});
  return std::invoke(Description<Options>::of_scene, scene.read());
}
template <class Options>
void take_named_options(const char* what, const py::object& system, const py::kwargs& named, py::object* options,
                        py::object* solver) {
  if (named.empty()) return;
  if (options->is_none()) *options = give_options<Options>(system);
  if (solver->is_none()) *solver = give_options<SolverOptions>(system);
  const py::tuple both = py::module_::import("tanor.description").attr("split_options")(what, *options, *solver, named);
  *options = both[0];
  *solver = both[1];
}

template SolverOptions choose_options(const py::object&, const py::object&);
template py::object give_options<SolverOptions>(const py::object&);
#define TANOR_INSTANTIATE(Options)                                       \
  template Options choose_options(const py::object&, const py::object&); \
  template py::object give_options<Options>(const py::object&);          \
  template void take_named_options<Options>(const char*, const py::object&, const py::kwargs&, py::object*, py::object*)
TANOR_INSTANTIATE(MotionOptions);
TANOR_INSTANTIATE(EquilibriumOptions);
TANOR_INSTANTIATE(ModesOptions);
TANOR_INSTANTIATE(BucklingOptions);
#undef TANOR_INSTANTIATE

double start_of_scene(const py::object& object) {
  return py::isinstance<SceneFile>(object) ? object.cast<SceneFile&>().read().t_start : 0.0;
}

std::vector<Observable> choose_observables(const py::object& object, const System& system) {
  return py::isinstance<SceneFile>(object) ? object.cast<SceneFile&>().read().observables : default_observables(system);
}

void add_requests_of_scene(const py::object& object, Simulation* simulation) {
  for (const Observable& each : choose_observables(object, simulation->system())) simulation->add_observable(each);
  if (!py::isinstance<SceneFile>(object)) return;
  add_events(object.cast<SceneFile&>().read(), simulation);
}

py::dict letters_of(const Units& units) {
  using namespace py::literals;
  return py::dict("length"_a = units.length, "mass"_a = units.mass, "time"_a = units.time, "force"_a = units.force,
                  "energy"_a = units.energy, "temperature"_a = units.temperature, "pressure"_a = units.pressure);
}

void bind_system_functions(py::module_& module) {
  using py::arg;
  py::class_<Carried>(module, "Carried", "A function, a kernel or a cell of a scene, for the field in which it stands.")
      .def_readwrite("origin", &Carried::origin, "(tuple) the state of its scene, and its place there")
      .def("__repr__", [](const Carried&) { return "<of a scene file>"; })
      .def("__deepcopy__", [](const Carried& self, const py::dict&) { return self; })
      .def("__reduce__", [](const Carried& self) {
        return py::make_tuple(py::module_::import("tanor.description").attr("carried"), self.origin);
      });
  module.def(
      "validate",
      [](const py::object& object, double time) {
        const System system = read_system(object);
        without_lock([&] { validate(system, time); });
      },
      arg("system"), arg("time") = 0.0,
      "Checks a System by every rule; what depends on time at `time`, s. Raises InputError with the place.");
  module.def("_observe", [](const py::object& object, const Solution& at, const std::optional<std::string>& text) {
    const System system = read_system(object);
    return observe(system, text ? std::vector<Observable>{{.text = *text}} : choose_observables(object, system), at);
  });
  module.def("_letters", [](const py::object& system) { return letters_of(read_units(system)); });
  module.def(
      "num_equations", [](const py::object& object) { return num_equations(read_system(object)); }, arg("system"),
      "Scalar equations of all constraints of a System, group by group, member by member.");
  module.def(
      "equation_names",
      [](const py::object& object) {
        const System system = read_system(object);
        std::vector<std::string> names(num_equations(system));
        for (std::size_t row = 0; row < names.size(); ++row) names[row] = equation_name(system, row);
        return names;
      },
      arg("system"), "The names of all rows: \"rods[17]\"; \"wire[4].1\" for the second row of a member with several.");
}

py::list descriptions() {
  py::list all;
  AnyOf<Constraint>::describe("constraints", &all);
  AnyOf<Force>::describe("forces", &all);
  AnyOf<Friction>::describe("friction", &all);
  AnyOf<Coordinates>::describe("coordinates", &all);
  describe<Support>("supports", "", &all);
  describe<SolverOptions>("options", "", &all);
  describe<MotionOptions>("options", "", &all);
  describe<EquilibriumOptions>("options", "", &all);
  describe<ModesOptions>("options", "", &all);
  describe<BucklingOptions>("options", "", &all);
  return all;
}

}  // namespace tanor::python
