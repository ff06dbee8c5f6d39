#include <tanor/report_fields.hpp>

#include "base/member_names.hpp"
#include "scene/entries.hpp"
#include "scene/parts.hpp"

namespace tanor::scene {

Units read_units(const Cursor& units, const Units& imported) {
  if (!units) return imported;
  if (!units.is_object()) {
    const std::vector<std::pair<std::string_view, const char*>> names{
        {"none", "none"}, {"si", "si"}, {"lj", "lj"}, {"real", "real"}, {"metal", "metal"}};
    return units_from_name(units.choice<const char*>(names));
  }
  units.object(keys_of("units"));
  Units own = imported;
  own.name = "own";
  // Other letters of a length do not go with the force of an import.
  if (units["length"] || units["mass"] || units["time"]) own.force = own.energy = own.pressure = "";
  fields_of<Units>.for_each([&](auto field) {
    auto& value = own.*field.member;
    const Cursor letters = units[detail::name_of_member<field.member>()];
    if constexpr (std::is_same_v<decltype(own.*field.member), double&>)
      value = letters.positive(value);
    else
      value = letters.string(value);
    if (letters.is_string() && letters.string().find_first_of("\"\r\n") != std::string::npos)
      letters.fail("letters on one line, without quotes");
  });
  const Units given = own;
  own.mass = given.letters(Dimension::Mass);
  own.force = given.letters(Dimension::Forces);
  own.energy = given.letters(Dimension::Energy);
  own.pressure = given.letters(Dimension::Pressure);
  return own;
}

std::vector<Observable> read_observables(const Cursor& list, const System& system, const Constants& parameters) {
  if (!list) return default_observables(system);
  std::vector<Observable> observables;
  for (const Cursor each : list.list("a list of observables")) {
    Observable& observable = observables.emplace_back();
    observable.parameters = parameters;
    if (each.is_string()) {
      observable.text = each.string();
    } else {
      each.object(keys_of("observe"));
      observable.text = each["what"].string();
      observable.name = each["name"].string("");
      observable.every_step = each["every_step"].boolean(false);
      observable.unit = each["unit"].string("");
    }
    try {
      check_observable(system, observable);
    } catch (const InputError& error) {
      const bool is_own = error.where() == "/unit" || error.where() == "/name";
      (each.is_string() ? each : each[is_own ? error.where().substr(1) : "what"]).complain(error.what());
    }
    const std::string& name = observable.name.empty() ? observable.text : observable.name;
    for (std::size_t k = 0; k + 1 < observables.size(); ++k)
      if (name == (observables[k].name.empty() ? observables[k].text : observables[k].name))
        each.complain("two observables have the name \"" + name + "\"");
  }
  return observables;
}

std::vector<Event> read_events(const Cursor& list, const System& system, const Constants& parameters) {
  std::vector<Event> events;
  for (const Cursor each : list.optional_list("a list of events")) {
    each.object(keys_of("events"));
    Event& event = events.emplace_back();
    event.parameters = parameters;
    event.when = each["when"].string();
    event.name = each["name"].string(event.when);
    event.action = each["do"].choice<EventAction>(EventAction::Report);
    event.of = each["of"].string("");
    const bool takes = event.action == EventAction::Break || event.action == EventAction::Release;
    if (each["of"] && !takes) each["of"].complain("belongs to events that break or release something");
    try {
      check_event(system, event);
    } catch (const InputError& error) {
      const Cursor place = each[error.where().empty() ? "when" : error.where().substr(1)];
      (place ? place : each).complain(error.what());
    }
    // Several events without names may share a condition.
    for (std::size_t k = 0; k + 1 < events.size(); ++k)
      if (event.name == events[k].name && (each["name"] || event.name != events[k].when))
        (each["name"] ? each["name"] : each).complain("two events have the name \"" + event.name + "\"");
  }
  return events;
}

}  // namespace tanor::scene
