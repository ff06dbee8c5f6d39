#include "report/html_page.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <tanor/version.hpp>

#include "base/text.hpp"
#include "report/colours.hpp"
#include "report/error_time.hpp"
#include "report/field_json.hpp"
#include "report/packed_bytes.hpp"
#include "report/page.hpp"
#include "report/shared_parts.hpp"
#include "report/words.hpp"

namespace tanor::report {
using namespace detail;

namespace {

constexpr std::string_view place_of_data = "<!--tanor-data-->";

/// Returns JSON that no text of a scene can break out of: "<" would begin the end of the element around it.
std::string escape(const Json& json) {
  std::string text;
  for (const char c : json.dump(-1, ' ', false, Json::error_handler_t::replace)) {
    if (c == '<')
      text += "\\u003c";
    else
      text += c;
  }
  return text;
}

/// Returns "#rrggbb".
std::string in_hexadecimals(Rgb colour) {
  const auto part = [](float x) { return static_cast<int>(std::lround(255.0f * x)); };
  return fmt::format("#{:02x}{:02x}{:02x}", part(colour.r), part(colour.g), part(colour.b));
}

/// Returns the colours of the motion, which are those of its pictures.
Json describe_colours(const TensionScale& tensions) {
  return {{"tensions", {tensions.least, tensions.most}}, {"pulled", list_of(pulled, in_hexadecimals)},
          {"pushed", list_of(pushed, in_hexadecimals)},  {"unknown", in_hexadecimals(unknown_colour)},
          {"bead", in_hexadecimals(bead_colour)},        {"support", in_hexadecimals(support_colour)},
          {"earth", in_hexadecimals(earth_colour)},      {"normal", in_hexadecimals(normal_colour)},
          {"tangent", in_hexadecimals(tangent_colour)},  {"guide", in_hexadecimals(guide_colour)},
          {"ground", in_hexadecimals(ground)},           {"ink", in_hexadecimals(ink)}};
}

struct Range {
  double least = INFINITY, most = -INFINITY;
  void take(double number) {
    if (!std::isfinite(number)) return;
    least = std::min(least, number);
    most = std::max(most, number);
  }
  Json json() const { return least <= most ? Json{least, most} : Json{0.0, 0.0}; }
};

/// Packs rows of numbers in 16 bits between the ends of ranges, which the page receives with them. With a range for
/// each row a large force at one time takes no digits from others. In one range for all rows numbers that change little
/// from row to row pack well.
template <class Row>
Json pack(std::string_view name, const std::vector<Row>& rows, bool in_one_range, PackedBytes* bytes) {
  std::vector<Range> ranges(in_one_range ? 1 : rows.size());
  const auto range_of = [&](std::size_t k) -> Range& { return ranges[in_one_range ? 0 : k]; };
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (const double number : rows[k]) range_of(k).take(number);
  std::vector<std::uint16_t> numbers;
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (const double number : rows[k]) numbers.push_back(to_16_bits(number, range_of(k).least, range_of(k).most));
  bytes->add_rows(name, numbers, rows.empty() ? 1 : std::max<std::size_t>(1, rows[0].size()));
  return list_of(ranges, [](const Range& range) { return range.json(); });
}

/// Packs an array of all frames.
Json pack(std::string_view name, const std::vector<RecordedFrame>& frames, std::vector<float> RecordedFrame::*array,
          bool in_one_range, PackedBytes* bytes) {
  std::vector<std::span<const float>> rows;
  for (const RecordedFrame& frame : frames) rows.emplace_back(frame.*array);
  return pack(name, rows, in_one_range, bytes);
}

std::span<const std::int32_t> flat(const std::vector<std::array<std::int32_t, 2>>& pairs) {
  return {pairs.empty() ? nullptr : pairs.front().data(), 2 * pairs.size()};
}

Json describe_guides(const std::vector<Guide>& guides, const std::vector<RecordedFrame>& frames) {
  Json list = Json::array();
  for (std::size_t k = 0; k < guides.size(); ++k) {
    Json rows = Json::array();
    const bool moves =
        std::ranges::any_of(frames, [&](const auto& frame) { return frame.guides[k] != frames[0].guides[k]; });
    for (std::size_t f = 0; f < (moves ? frames.size() : std::min<std::size_t>(1, frames.size())); ++f)
      rows.push_back(frames[f].guides[k]);
    list.push_back({{"kind", guides[k].kind}, {"name", guides[k].name}, {"rows", rows}});
  }
  return list;
}

/// Returns the edges and the origin of a cell that is periodic in all directions, or null.
Json describe_cell(const std::optional<Cell>& cell) {
  if (!cell || !cell->is_periodic_everywhere()) return {};
  return {{"edges", {{cell->xx, 0.0, 0.0}, {cell->xy, cell->yy, 0.0}, {cell->xz, cell->yz, cell->zz}}},
          {"origin", cell->origin}};
}

/// Returns [number, time] of each part that is gone.
template <class List, class Since = std::identity>
Json list_gone(const List& parts, Since since = {}) {
  Json list = Json::array();
  for (std::size_t k = 0; k < parts.size(); ++k)
    if (const double time = std::invoke(since, parts[k]); !std::isnan(time)) list.push_back({k, time});
  return list;
}

/// Returns [point, pivot] of each crank.
Json list_pivots(const ShownParts& shown, const GoneParts& gone, const std::vector<RecordedFrame>& frames) {
  Json list = Json::array();
  if (frames.empty()) return list;
  const std::vector<double> all(frames[0].positions.begin(), frames[0].positions.end());
  const double size = measure_diagonal(all);
  for (const auto& [k, member] : shown.support_names) {
    std::vector<Vector3> places;
    for (const RecordedFrame& frame : frames) {
      const float* const r = &frame.positions[3 * k];
      if (gone.supports.empty() || !(gone.supports[k] <= frame.time)) places.push_back({r[0], r[1], r[2]});
    }
    if (const auto pivot = find_pivot(places, 2.0 * size)) list.push_back({k, (*pivot)[0], (*pivot)[1], (*pivot)[2]});
  }
  return list;
}

Json describe_motion(const System& system, const Recording& recording, const std::optional<Cell>& cell,
                     std::span<const Passage> passages, PackedBytes* bytes) {
  const std::vector<RecordedFrame> frames = recording.frames();
  const ShownParts& shown = recording.shown();
  const GoneParts gone = find_gone(shown, passages);
  const Vector3 gravity = find_gravity(system);
  Json supports = Json::array(), support_names = Json::array();
  for (const auto& [point, member] : shown.support_names) {
    supports.push_back(point);
    support_names.push_back(member.name);
  }
  bool are_all = shown.num_points == system.num_points();
  for (std::size_t k = 0; k < shown.num_points; ++k) are_all = are_all && shown.points[k] == static_cast<Index>(k);
  const auto image = [](const ShownParts::Image& each) {
    return Json{each.point, each.offset[0], each.offset[1], each.offset[2]};
  };
  const auto rod_group = [](const ShownParts::RodGroup& each) {
    return Json{{"name", each.name}, {"first", each.first}, {"members", each.members}};
  };
  const auto tie = [&](const ShownParts::Tie& each) {
    Json json{{"kind", each.kind}, {"name", each.name}, {"points", each.points}, {"sheaves", each.sheaves}};
    if (!each.rope) return json;
    std::vector<double> lengths;
    for (const RecordedFrame& frame : frames)
      lengths.push_back(find_rope_length(system, *each.rope, recording.t_start(), frame.time));
    if (std::ranges::adjacent_find(lengths, std::not_equal_to<>()) == lengths.end() && !lengths.empty())
      lengths.resize(1);
    json["lengths"] = lengths;
    json["coefficients"] = each.rope->coefficients;
    return json;
  };
  bytes->add("rods", flat(shown.rods));
  bytes->add("held", recording.held());
  Json motion{
      {"points", shown.num_points},
      {"numbers", are_all ? std::vector<Index>() : shown.points},
      {"rods", shown.rods.size()},
      {"rod_groups", list_of(shown.rod_groups, rod_group)},
      {"times", list_of(frames, [](const RecordedFrame& frame) { return frame.time; })},
      {"frames_seen", recording.frames_seen()},
      {"supports", supports},
      {"support_names", support_names},
      {"pivots", list_pivots(shown, gone, frames)},
      {"gone",
       {{"rods", list_gone(gone.rods)},
        {"ties", list_gone(list_ties(shown, passages), &Guide::gone)},
        {"supports", list_gone(gone.supports)},
        {"guides", list_gone(place_guides(system, recording.t_start(), recording.t_start(), passages), &Guide::gone)}}},
      {"images", list_of(shown.images, image)},
      {"guides", describe_guides(recording.guides(), frames)},
      {"ties", list_of(shown.ties, tie)},
      {"cell", describe_cell(cell)},
      {"without_picture", list_of(recording.guides_without_picture(system), name_guide)},
      {"up", {-gravity[0], -gravity[1], -gravity[2]}},
      {"has_friction", !system.friction.empty()}};
  using F = RecordedFrame;
  motion["ranges"] = {{"positions", pack("positions", frames, &F::positions, true, bytes)},
                      {"tensions", pack("tensions", frames, &F::tensions, false, bytes)},
                      {"ties", pack("ties", frames, &F::tie_tensions, false, bytes)},
                      {"normal", pack("normal", frames, &F::normal_reactions, false, bytes)},
                      {"tangent", pack("tangent", frames, &F::tangent_reactions, false, bytes)}};
  motion["arrays"] = bytes->list();
  return motion;
}

/// Rounds a number to nine digits. A curve does not show more, and the text is half as long.
double shorten(double number) {
  return std::isfinite(number) ? std::stod(fmt::format("{:.9g}", number)) : number;
}

/// Energies that are rounding beside those of the motion are 0.
Json describe_history(const Recording& recording, const MotionReport& report) {
  const std::vector<RecordedStep> steps = recording.steps();
  Json history;
  const auto add = [&](std::string_view key, double RecordedStep::*number) {
    const bool is_energy =
        number == &RecordedStep::energy || number == &RecordedStep::kinetic || number == &RecordedStep::potential;
    history[std::string(key)] = list_of(steps, [&](const RecordedStep& step) {
      return shorten(is_energy ? beyond_rounding(step.*number, report) : step.*number);
    });
  };
  using S = RecordedStep;
  add("t", &S::time);
  const auto add_all = [&]<auto... members>() {
    (add(detail::name_of_member<members>(), members), ...);
  };
  add_all.
  operator()<&S::step, &S::energy, &S::kinetic, &S::potential, &S::drift, &S::position_violation,
             &S::velocity_violation, &S::acceleration_violation, &S::reciprocal_condition, &S::friction_iterations>();
  return history;
}

Json describe_units(const Units& units) {
  return {{"length", units.length},
          {"force", units.force},
          {"time", units.time},
          {"energy", units.energy},
          {"rate", per_time("1", units.time)},
          {"angular_velocity", per_time("rad", units.time)}};
}

/// Returns the observables that have few numbers, with these over time.
Json describe_observed(const Recording& recording, const System& system, const Simulation* motion) {
  const std::vector<RecordedFrame> frames = recording.frames();
  Json list = Json::array();
  std::size_t first = 0;
  const auto rounding = measure_rounding(recording.observables(), system, motion);
  for (const Observed& each : recording.observables()) {
    if (!is_recorded(each)) continue;
    const double noise = rounding(each);
    Observed shown = without_noise(each, noise);
    for (auto* const list : {&shown.least, &shown.largest})
      for (Extreme& extreme : *list)
        if (motion == nullptr) extreme.time = NAN;
    Json object = json_of(shown), times = Json::array(), rows = Json::array();
    for (const RecordedFrame& frame : frames) {
      if (frame.observed.size() < first + each.values.size()) continue;
      Json row = Json::array();
      for (const double number : std::span(frame.observed).subspan(first, each.values.size()))
        row.push_back(json_of(std::abs(number) <= noise ? 0.0 : shorten(number)));
      times.push_back(frame.time);
      rows.push_back(std::move(row));
    }
    first += each.values.size();
    object["unit"] = each.unit;
    object["t"] = std::move(times);
    object["rows"] = std::move(rows);
    list.push_back(std::move(object));
  }
  return list;
}

Json describe_events(const Simulation& simulation, const Recording& recording) {
  const MotionReport& report = simulation.report();
  Json events = Json::array();
  const auto add = [&](double t, const char* kind, const std::string& what) {
    events.push_back({{"t", t}, {"kind", kind}, {"what", what}});
  };
  for (const RecordedChange& change : recording.switches()) add(change.time, "contact", change.what);
  for (const SingularPassage& passage : report.singular_passages.first)
    add(passage.time, "singular", "singular configuration");
  constexpr std::size_t most_named = 100;
  const std::span<const Passage> passages = simulation.passages();
  for (const Passage& passage : passages.first(std::min(most_named, passages.size())))
    add(passage.time, "event", describe_passage(passage, simulation));
  std::ranges::stable_sort(events.get_ref<Json::array_t&>(), {},
                           [](const Json& event) { return event["t"].get<double>(); });
  return events;
}

/// Returns the total number of events, of which describe_events lists the first ones.
Json count_events(const Simulation& simulation, const Recording& recording) {
  const MotionReport& report = simulation.report();
  return {{"contact", recording.num_switches()},
          {"singular", report.singular_passages.count},
          {"event", simulation.passages().size()}};
}

/// Returns the facts of a run. `text` describes the run in words and is empty while it goes on.
Json describe_run(const RunFacts& facts, const Simulation& simulation, const std::string& text) {
  const MotionReport& report = simulation.report();
  const PlanSummary& plan = simulation.plan();
  const Units& units = simulation.system().units;
  Json warnings = Json::array();
  if (!facts.has_started) warnings.push_back("No consistent start was found: " + simulation.outcome().what);
  if (!report.accuracy_warning.empty()) warnings.push_back(report.accuracy_warning);
  if (facts.certificate && !facts.certificate->passed()) warnings.push_back(facts.certificate->line());
  const bool is_running = text.empty();
  if (facts.has_started && simulation.time() < facts.t_end && !is_running) {
    const auto [time, end] = texts_apart(std::array{simulation.time(), facts.t_end});
    warnings.push_back(fmt::format("The motion ended at t = {} of {}{}", with_unit(time, units.time),
                                   with_unit(end, units.time),
                                   facts.stopped_by.empty() ? "." : ": " + facts.stopped_by));
  }
  if (const std::string several = describe_several(report.friction, units); !several.empty())
    warnings.push_back(several);
  using P = PlanSummary;
  using M = MotionReport;
  Json run = json_of_members<&P::points, &P::equations, &P::islands>(plan);
  run.update(json_of_members<&M::steps, &M::rejected>(report));
  run.update({{"scene", facts.scene},
              {"version", TANOR_VERSION},
              {"method", name_of(report.method)},
              {"threads", facts.threads},
              {"rods", count_rods(simulation.system())},
              {"has_started", facts.has_started},
              {"t_start", facts.t_start},
              {"t_resumed", facts.t_resumed ? Json(*facts.t_resumed) : Json()},
              {"t_end", facts.t_end},
              {"t_reached", simulation.time()},
              {"certificate", describe_certificate(facts.certificate)},
              {"wants_certificate", facts.wants_certificate},
              {"warnings", warnings},
              {"left_out", list_left_out(facts.left_out, plan.left_out)},
              {"drift", if_started(facts, report.energy.drift_relative())},
              {"position_violation", if_started(facts, report.violation.position)},
              {"velocity_violation", if_started(facts, report.violation.velocity)},
              {"wall", describe_times(facts, report.times, true)},
              {"is_running", is_running},
              {"text", text}});
  return run;
}

/// Returns what stands in the place of the facts of a run.
Json describe_rest(const System& system, const Rest& rest) {
  return {{"scene", rest.scene},           {"version", TANOR_VERSION},   {"method", rest.said},
          {"points", system.num_points()}, {"rods", count_rods(system)}, {"equations", num_equations(system)},
          {"has_started", true},           {"is_at_rest", true},         {"certificate", describe_certificate({})},
          {"warnings", rest.warnings},     {"left_out", rest.left_out},  {"wall", {{"total", 0.0}}}};
}

void write_page(const std::filesystem::path& directory, const Json& data, const PackedBytes& bytes) {
  const std::string_view page = html_page_template();
  const std::size_t place = page.find(place_of_data);
  replace_file(directory / html_page_name, [&](OutputFile* file) {
    file->write(page.substr(0, place));
    file->write("<script type=\"application/json\" id=\"data\">");
    file->write(escape(data));
    file->write("</script>\n<script type=\"text/plain\" id=\"motion\">");
    file->write(bytes.text());
    file->write("</script>\n");
    file->write(page.substr(place + place_of_data.size()));
  });
}

void write(const std::filesystem::path& directory, const RunFacts& facts, const Simulation& simulation,
           const Recording& recording, const std::string& text) {
  PackedBytes bytes;
  const Json data{
      {"run", describe_run(facts, simulation, text)},
      {"motion", describe_motion(simulation.system(), recording, facts.cell, simulation.passages(), &bytes)},
      {"colours", describe_colours(facts.tensions.value_or(TensionScale()))},
      {"history", describe_history(recording, simulation.report())},
      {"units", describe_units(simulation.system().units)},
      {"observables", describe_observed(recording, simulation.system(), &simulation)},
      {"events", describe_events(simulation, recording)},
      {"events_seen", count_events(simulation, recording)},
      {"error_time", read_error_time(directory, facts.scene_checksum)}};
  write_page(directory, data, bytes);
}

}  // namespace

void write_html_page(const std::filesystem::path& directory, const RunFacts& facts, Simulation& simulation,
                     const Recording& recording) {
  write(directory, facts, simulation, recording, format_page(facts, simulation));
}

void write_running_page(const std::filesystem::path& directory, const RunFacts& facts, const Simulation& simulation,
                        const Recording& recording) {
  write(directory, facts, simulation, recording, "");
}

void write_rest_page(const std::filesystem::path& directory, const System& system, const Rest& rest) {
  if (!has_html_page()) return;
  Recording recording(system, {});
  recording.take_frame(system, rest.state, {}, rest.observed);
  PackedBytes bytes;
  Json data{{"run", describe_rest(system, rest)},
            {"motion", describe_motion(system, recording, rest.cell, {}, &bytes)},
            {"colours", describe_colours(choose_tension_scale(recording.tensions()))},
            {"history", Json::object()},
            {"units", describe_units(system.units)},
            {"observables", describe_observed(recording, system, nullptr)},
            {"events", Json::array()},
            {"events_seen", Json::object()},
            {"error_time", Json::array()}};
  if (rest.modes != nullptr) {
    data["modes"] = {{"omega", rest.modes->omega}, {"decay", rest.modes->decay}};
    std::vector<std::span<const double>> shapes;
    for (std::size_t k = 0; k < rest.modes->count(); ++k) shapes.push_back(rest.modes->shape(k));
    data["motion"]["ranges"]["shapes"] = pack("shapes", shapes, false, &bytes);
    data["motion"]["arrays"] = bytes.list();
  }
  write_page(directory, data, bytes);
}

}  // namespace tanor::report
