/// docs/scene-format.md agrees with the tables of fields and the structs of options. The unit, the range and the
/// default of each key are those of the library.

#include <algorithm>
#include <cmath>
#include <limits>
#include <regex>

#include <tanor/enum_names.hpp>
#include <tanor/equilibrium.hpp>
#include <tanor/kinds.hpp>
#include <tanor/modes.hpp>
#include <tanor/motion.hpp>
#include <tanor/statics_names.hpp>

#include "cli/format_page.hpp"
#include "report/field_json.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

/// Returns the only entry of a table's probe, such as {"kind": "rod", "?": 0}, and the list that contains it.
std::pair<std::string, json> entry_of(const Table& table) {
  const json probe = json::parse(table.probe);
  const json& value = *probe.begin();
  return {probe.begin().key(), value.is_array() ? value[0] : value};
}

const Table& table_of(const std::vector<Table>& tables, const std::string& list, std::string_view kind) {
  for (const Table& table : tables) {
    const auto [of, entry] = entry_of(table);
    if (of == list && (kind.empty() || entry.value("kind", "") == kind)) return table;
  }
  ADD_FAILURE() << "no table of " << list << " " << kind;
  return tables.front();
}

/// Returns the row of a key on the page. "as of the constraint" and "as of `coulomb`" lead to another table.
std::map<std::string, std::string> row_of(const std::vector<Table>& tables, const std::string& list,
                                          std::string_view kind, const std::string& key) {
  const Table& table = table_of(tables, list, kind);
  const auto found = table.cells.find(key);
  if (found == table.cells.end()) return {};
  const std::string& what = found->second.at("what");
  if (what.starts_with("as of the constraint")) return row_of(tables, "constraints", kind, key);
  if (what.starts_with("as of `")) return row_of(tables, list, what.substr(7, what.find('`', 7) - 7), key);
  return found->second;
}

/// Returns a unit such as "m/s²" as the tables of fields spell it.
std::string in_ascii(const std::string& unit) {
  return std::regex_replace(unit, std::regex("²"), "^2");
}

/// Returns the number at the beginning of a cell, or NaN if there is none.
double number_in(const std::string& cell) {
  std::smatch match;
  const bool is_one = std::regex_search(cell, match, std::regex("^`?(-?[0-9.]+(e-?[0-9]+)?)`?( |$)"));
  return is_one ? std::stod(match[1]) : std::numeric_limits<double>::quiet_NaN();
}

/// Returns true if a cell names the value of a field that a scene does not give.
bool says(const std::string& cell, double value) {
  return number_in(cell) == value;
}
bool says(const std::string& cell, Index value) {
  return number_in(cell) == value;
}
bool says(const std::string& cell, const Parameter& value) {
  if (value.is_initial()) return cell == "`\"initial\"`";
  return value.constants.size() == 1 && says(cell, value.constants[0]);
}
/// The cell holds a list of numbers or of vectors.
template <class Element, std::size_t size>
bool says(const std::string& cell, const std::array<Element, size>& value) {
  if (cell == "none") return value == std::array<Element, size>{};
  const std::string list = cell.substr(0, cell.find_last_of('`')).substr(cell.find('`') == 0 ? 1 : 0);
  return json::accept(list) && json::parse(list) == json(value);
}
bool says(const std::string& cell, const VectorFunction& value) {
  return value.is_constant() && value(0.0)[0].value() == 0.0 && (cell == "none" || says(cell, 0.0));
}
/// The cell says in words that nothing is given.
template <class T>
bool says(const std::string& cell, const std::optional<T>& value) {
  return !value && !cell.empty() && !std::regex_match(cell, std::regex("-?[0-9.]+(e-?[0-9]+)?"));
}
template <class T>
bool says(const std::string& cell, const std::vector<T>& value) {
  return value.empty() && (cell == "none" || says(cell, 0.0));
}

/// Returns true if the table is that of a kind with laws. It names the law, and the required keys depend on it.
bool depends_on_law(const std::vector<Table>& tables, const std::string& list, std::string_view kind) {
  return table_of(tables, list, kind).cells.contains("law");
}

template <class Group, class Value>
void expect_row(const std::vector<Table>& tables, const std::string& list, const FieldOf<Group, Value>& field) {
  const std::string_view kind = KindOf<Group>::name;
  SCOPED_TRACE(list + " " + std::string(kind) + " " + field.name);
  std::map<std::string, std::string> row = row_of(tables, list, kind, field.name);
  ASSERT_FALSE(row.empty());

  const std::string unit = in_ascii(row["unit"]);
  // "[c] m" is a unit in units of another key.
  EXPECT_TRUE(unit == field.data.unit || (unit.starts_with("[") && *field.data.unit == '\0'))
      << unit << " on the page, " << field.data.unit;

  const std::string& what = row["what"];
  const auto complaint = field.data.range.complaint;
  if (complaint == ValueRange::positive.complaint) {
    EXPECT_TRUE(contains(what, "> 0")) << what;
  } else if (complaint == ValueRange::not_negative.complaint) {
    EXPECT_TRUE(contains(what, ">= 0")) << what;
  } else if (complaint == ValueRange::not_zero.complaint) {
    EXPECT_TRUE(contains(what, "not 0")) << what;
  } else if (complaint == ValueRange::any.complaint) {
    EXPECT_FALSE(contains(what, "> 0") || contains(what, ">= 0") || contains(what, "not 0")) << what;
  }
  if (field.data.role == FieldRole::Direction) {
    EXPECT_TRUE(contains(what, "not zero")) << what;
  }

  const std::string& otherwise = row["default"];
  if (field.data.is_required) {
    EXPECT_EQ(otherwise, "required");
  } else if (!(otherwise.starts_with("required") && depends_on_law(tables, list, kind))) {
    EXPECT_TRUE(says(otherwise, Group{}.*field.value)) << "the page says '" << otherwise << "'";
  }
}

template <class Group>
void expect_rows(const std::vector<Table>& tables, const std::string& list) {
  std::apply([&](const auto&... field) { (expect_row(tables, list, field), ...); }, KindOf<Group>::fields);
}

/// Expects the rows of every kind of one list that scene files can name.
template <class... Groups>
void expect_kinds(const std::vector<Table>& tables, const std::string& list,
                  std::type_identity<std::variant<Groups...>>) {
  (expect_rows<Groups>(tables, list), ...);
}

/// The row of a report on the page names each key of its table of fields.
template <class Report>
void expect_keys_in_row(const char* mark, const char* row) {
  const Names named = find_tables(mark).at(0).words.at(row);
  const report::Json fields = report::json_of(Report());
  for (const auto& [key, value] : fields.items()) EXPECT_TRUE(named.contains(key)) << row << ": " << key;
}

TEST(SceneFormatPage, RowsOfListsNameEachKeyOfTheirTables) {
  expect_keys_in_row<Units>("result of run", "units");
  expect_keys_in_row<Observed>("result of run", "observables");
  expect_keys_in_row<Passage>("result of run", "passages");
  expect_keys_in_row<RankChanges>("result of run", "rank_changes");
  expect_keys_in_row<FrictionReport>("result of solve", "friction_report");
}

/// The page in the browser reads named numbers and their extremes by a table of its own, in data.ts.
template <class Report>
void expect_fields_of_page(const Report& filled, const std::string& source, const std::string& interface) {
  std::smatch body;
  ASSERT_TRUE(std::regex_search(source, body, std::regex("interface " + interface + " \\{([^}]*)\\}"))) << interface;
  const report::Json fields = report::json_of(filled);
  const std::regex member("(\\w+): (Figure|string)(\\[\\])?");
  const std::string members = body[1];
  for (std::sregex_iterator each(members.begin(), members.end(), member), end; each != end; ++each) {
    const std::string key = (*each)[1];
    if (key == "rows" || key == "unit") continue;  // which the page has of its own
    ASSERT_TRUE(fields.contains(key)) << interface << ": " << key;
    EXPECT_EQ(fields[key].is_array(), (*each)[3].matched) << key;
    EXPECT_EQ(fields[key].is_string() || fields[key].is_array(), (*each)[2] == "string") << key;
  }
  for (const char* needed : {"value", "members", "least"})
    EXPECT_EQ(fields.contains(needed), contains(members, std::string(needed) + ":")) << interface << ": " << needed;
}

TEST(PageSource, ReadsTheFieldsOfObservablesThatAreWritten) {
  const std::string source =
      report::read_text(std::filesystem::path(TANOR_DOCS).parent_path() / "src/program/report/page/data.ts");
  expect_fields_of_page(Extreme{1.0, 2.0, "links[3]"}, source, "Extreme");
  Observed torque;
  torque.name = torque.member = torque.unknown = "links[3]";
  expect_fields_of_page(torque, source, "Observable");
}

TEST(SceneFormatPage, FieldsOfKindsHaveTheUnitsRangesAndDefaultsOfTheirTables) {
  const std::vector<Table> tables = find_tables("keys of ");
  expect_kinds(tables, "constraints", std::type_identity<Constraint>());
  expect_kinds(tables, "coordinates", std::type_identity<Coordinates>());
  expect_kinds(tables, "forces", std::type_identity<Force>());
  expect_rows<Coulomb>(tables, "friction");
  expect_rows<Viscous>(tables, "friction");
}

/// Returns the default of a key of an object that is not a list of kinds.
std::string default_of(const std::vector<Table>& tables, const std::string& object, const std::string& key) {
  return row_of(tables, object, "", key)["default"];
}

/// Masses outside of this range have no inverse whose square is a number.
TEST(SceneFormatPage, MassesHaveTheRangeThatIsTaken) {
  const auto is_taken = [](double mass) {
    try {
      (void)Dynamics(System{.positions = {0.0, 0.0, 0.0}, .masses = {mass}});
      return true;
    } catch (const InputError&) {
      return false;
    }
  };
  const std::string what = row_of(find_tables("keys of "), "points", "", "masses")["what"];
  EXPECT_TRUE(contains(what, "> 0 and from 1e-100 to 1e100")) << what;
  EXPECT_TRUE(is_taken(1.1e-100) && is_taken(0.9e100));
  EXPECT_FALSE(is_taken(0.9e-100) || is_taken(1.1e100) || is_taken(0.0));
}

TEST(SceneFormatPage, OptionsHaveTheDefaultsOfTheirStructs) {
  const std::vector<Table> tables = find_tables("keys of ");
  const auto expect_number = [&](const std::string& object, const std::string& key, double value) {
    EXPECT_TRUE(says(default_of(tables, object, key), value)) << object << " " << key << " is " << value;
  };
  const auto expect_name = [&](const std::string& object, const std::string& key, std::string_view value) {
    EXPECT_EQ(default_of(tables, object, key), "`" + std::string(value) + "`") << object << " " << key;
  };

  const MotionOptions motion;
  expect_name("motion", "method", name_of(motion.method));
  expect_number("motion", "rtol", motion.rtol);
  expect_number("motion", "order", motion.order);
  expect_number("motion", "spectral_radius", motion.spectral_radius);
  expect_name("motion", "stabilisation", name_of(motion.stabilisation));
  expect_name("motion", "start", name_of(motion.start));
  for (const auto& [key, value] : {std::pair{"step", motion.step}, {"max_step", motion.max_step}}) {
    EXPECT_EQ(value, 0.0);
    EXPECT_EQ(default_of(tables, "motion", key), "none") << key;
  }

  const SolverOptions solver;
  expect_name("solver", "form", name_of(solver.form));
  expect_name("solver", "linear_solver", name_of(solver.linear_solver));
  expect_name("solver", "ordering", name_of(solver.ordering));
  expect_name("solver", "friction", name_of(solver.friction));
  expect_number("solver", "threads", solver.threads);
  EXPECT_EQ(default_of(tables, "solver", "reuse"), solver.reuse ? "true" : "false");
  EXPECT_EQ(default_of(tables, "solver", "exact"), solver.exact ? "true" : "false");

  const auto of_contact =
      std::ranges::find_if(tables, [](const Table& each) { return contains(each.probe, "contact"); });
  ASSERT_NE(of_contact, tables.end());
  for (const auto& [key, value] :
       {std::pair{"max_at_one_instant", solver.contact.max_at_one_instant}, {"max_events", solver.contact.max_events}})
    EXPECT_TRUE(says(of_contact->cells.at(key).at("default"), value)) << key;

  const EquilibriumOptions equilibrium;
  expect_name("equilibrium", "method", name_of(equilibrium.method));
  expect_number("equilibrium", "force_tolerance", equilibrium.force_tolerance);
  expect_number("equilibrium", "max_iterations", equilibrium.max_iterations);
  expect_name("equilibrium", "accept", name_of(equilibrium.accept));
  expect_number("equilibrium", "at", equilibrium.at);
  expect_number("equilibrium", "load_steps", equilibrium.load_steps);

  const ModesOptions modes;
  expect_number("modes", "count", static_cast<double>(modes.count));
  EXPECT_EQ(default_of(tables, "modes", "damped"), modes.damped ? "true" : "false");
}

/// Returns the default in a cell, which is JSON or a word that becomes a text, or null if it is given in other words.
json value_in(const std::string& cell) {
  const std::string bare = cell.starts_with("`") && cell.ends_with("`") ? cell.substr(1, cell.size() - 2) : cell;
  if (json::accept(bare)) return json::parse(bare);
  return bare != cell ? json(bare) : json();
}

/// Returns what the program says about the result of a generator.
std::string solve_generated(const Folder& folder, const json& generator) {
  const json gravity{{"kind", "gravity"}, {"acceleration", {0, 0, -9.81}}};
  write_text(folder / "s.json", json{{"tanor_scene", 1}, {"generate", generator}, {"forces", {gravity}}}.dump());
  const Ended ended = run_program(folder, {"solve", "s.json", "--json", "--quiet"});
  EXPECT_EQ(ended.code, 0) << generator << ": " << ended.err;
  return ended.out;
}

/// Expects that a generator with all defaults of the page written out makes the same as without them. `start` is given,
/// since some keys are read only with others.
void expect_defaults(const std::vector<Table>& tables, const Table& table, const json& start, bool with_energies) {
  const Folder folder;
  json generator = start;
  for (const auto& [key, cells] : table.cells) {
    if (start.contains(key) || (!with_energies && cells.at("what").starts_with("with `energies`"))) continue;
    const bool is_of_chain = cells.at("what").starts_with("as of a chain");
    const Table& teller = is_of_chain ? table_of(tables, "generate", "chain") : table;
    const std::string& cell = teller.cells.at(key).at("default");
    generator[key] = value_in(cell);
    ASSERT_FALSE(generator[key].is_null()) << start << " " << key << ": '" << cell << "'";
  }
  ASSERT_GT(generator.size(), start.size() + 2);
  EXPECT_TRUE(solve_generated(folder, generator) == solve_generated(folder, start)) << generator;
}

TEST(SceneFormatPage, GeneratorsHaveTheDefaultsThatThePageSays) {
  const std::vector<Table> tables = find_tables("keys of ");
  std::size_t count = 0;
  for (const Table& table : tables) {
    const auto [list, entry] = entry_of(table);
    if (list != "generate") continue;
    ++count;
    const json start{{"kind", entry.at("kind")}};
    expect_defaults(tables, table, start, false);
    if (!table.cells.contains("bonds")) continue;
    json with_energies = start;
    with_energies["bonds"] = "energies";
    expect_defaults(tables, table, with_energies, true);
  }
  EXPECT_EQ(count, 7u);
}

}  // namespace
}  // namespace tanor::cli
