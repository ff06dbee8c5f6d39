#include "scene/context.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text.hpp"

#include "scene/memory.hpp"

namespace tanor::scene {
using namespace detail;
namespace {

/// Reads {"table": "drive.csv"} with rows t, value, … Returns one function for each column of values.
std::vector<ScalarFunction> read_table(const Cursor& file_name, std::size_t num_values, const Context& context) {
  const NumberTable table = context.number_table(file_name);
  if (table.columns != num_values + 1 || table.rows < 2)
    file_name.fail(fmt::format("a table of {} columns (t and {} more) and 2 rows or more, this one has {} and {}",
                               num_values + 1, num_values, table.columns, table.rows));
  std::vector<double> times(table.rows);
  for (std::size_t row = 0; row < table.rows; ++row) times[row] = table(row, 0);
  const auto back = std::adjacent_find(times.begin(), times.end(), [](double a, double b) { return !(a < b); });
  if (back != times.end())
    file_name.fail(fmt::format("a table whose times grow, here {}",
                               fmt::join(texts_apart(std::array{*back, *(back + 1)}), " is followed by ")));
  const double begin = std::min(0.0, context.t_start);
  if (times.front() > begin || times.back() < context.t_end) {
    const auto [from, to, first, last] = texts_apart(std::array{begin, context.t_end, times.front(), times.back()});
    file_name.fail(fmt::format("a table from t = {} to t_end = {}, this one has {} to {}", from, to, first, last));
  }

  std::vector<ScalarFunction> functions;
  for (std::size_t k = 1; k <= num_values; ++k) {
    std::vector<double> values(table.rows);
    for (std::size_t row = 0; row < table.rows; ++row) values[row] = table(row, k);
    functions.push_back(file_name.locate([&] { return ScalarFunction::table(times, std::move(values)); }));
  }
  return functions;
}

ScalarFunction read_formula(const Cursor& text, const Context& context) {
  const std::string& formula = text.string();
  return text.locate([&] { return ScalarFunction::formula(formula, context.parameters); });
}

/// Returns the key of {"formula": …} or {"table": …} that is present.
Cursor formula_or_table(const Cursor& cursor) {
  cursor.object({"formula", "table"});
  const Cursor formula = cursor["formula"], table = cursor["table"];
  if (static_cast<bool>(formula) == static_cast<bool>(table)) cursor.fail("one of the keys formula, table");
  return formula ? formula : table;
}

}  // namespace

Index Context::point(const Cursor& cursor) const {
  return static_cast<Index>(cursor.integer(0, static_cast<std::int64_t>(num_points) - 1));
}

void Context::take_room(std::size_t num_more) const {
  constexpr double bytes_a_member = 100.0;  // for members of plane constraints, once planned
  if (num_named == nullptr) return;
  *num_named += num_more;
  const double needed = bytes_a_member * static_cast<double>(*num_named), there = measure_memory();
  if (needed <= there) return;
  throw std::length_error(
      fmt::format("the groups of this scene have more than {} members: they need {:.3g} GB of memory at least; there "
                  "are {:.3g} GB for this program",
                  *num_named, 1e-9 * needed, 1e-9 * there));
}

std::vector<Index> Context::points(const Cursor& cursor) const {
  constexpr std::string_view wanted = R"(a list of points, "all" or {"first", "count", "stride"})";
  std::vector<Index> points;
  if (cursor.is_object()) {
    cursor.object({"first", "count", "stride"});
    const auto n = static_cast<std::int64_t>(num_points);
    const std::int64_t first = cursor["first"].integer(0, n - 1, 0);
    const std::int64_t stride = cursor["stride"].integer(1, n, 1);
    const std::int64_t most = (n - 1 - first) / stride + 1;
    const std::int64_t count = cursor["count"].integer(0, most, most);
    take_room(static_cast<std::size_t>(count));
    for (std::int64_t k = 0; k < count; ++k) points.push_back(static_cast<Index>(first + k * stride));
  } else if (cursor.says("all")) {
    take_room(num_points);
    for (std::size_t k = 0; k < num_points; ++k) points.push_back(static_cast<Index>(k));
  } else {
    for (const Cursor entry : cursor.list(wanted)) points.push_back(point(entry));
  }
  return points;
}

template <std::size_t N>
std::vector<std::array<Index, N>> Context::tuples(const Cursor& cursor) const {
  static_assert(2 <= N && N <= 4);
  constexpr std::array<std::string_view, 5> one{"", "", "a pair of points [i, j]", "a triple of points [i, j, k]",
                                                "a quadruple of points [i, j, k, l]"};
  constexpr std::array<std::string_view, 5> all{"", "", "a list of pairs of points", "a list of triples of points",
                                                "a list of quadruples of points"};
  const std::string_view wanted = one[N];
  std::vector<std::array<Index, N>> tuples;
  for (const Cursor entry : cursor.list(all[N])) {
    if (entry.list(wanted).size() != N) entry.fail(wanted);
    auto next = tuples.emplace_back().begin();
    for (const Cursor member : entry.list(wanted)) *next++ = point(member);
  }
  return tuples;
}
template std::vector<std::array<Index, 2>> Context::tuples<2>(const Cursor&) const;
template std::vector<std::array<Index, 3>> Context::tuples<3>(const Cursor&) const;
template std::vector<std::array<Index, 4>> Context::tuples<4>(const Cursor&) const;

NumberTable Context::number_table(const Cursor& file_name) const {
  return file_name.locate([path = file(file_name)] { return read_number_table(path); });
}

ScalarFunction Context::scalar_function(const Cursor& cursor) const {
  if (cursor.is_number()) return cursor.number();
  if (!cursor.is_object()) cursor.fail(R"(a number, {"formula": "…"} or {"table": "…"})");
  const Cursor source = formula_or_table(cursor);
  return cursor["formula"] ? read_formula(source, *this) : read_table(source, 1, *this)[0];
}

VectorFunction Context::vector_function(const Cursor& cursor) const {
  if (cursor.is_list()) return cursor.vector3();
  if (!cursor.is_object()) cursor.fail(R"(3 numbers [x, y, z], {"formula": ["…", "…", "…"]} or {"table": "…"})");
  const Cursor source = formula_or_table(cursor);
  std::vector<ScalarFunction> components;
  if (cursor["formula"]) {
    constexpr std::string_view wanted = "3 strings, formulas of x, y, z";
    if (source.list(wanted).size() != 3) source.fail(wanted);
    for (const Cursor text : source.list(wanted)) components.push_back(read_formula(text, *this));
  } else {
    components = read_table(source, 3, *this);
  }
  return {components[0], components[1], components[2]};
}

Parameter Context::parameter(const Cursor& cursor, std::size_t num_members, Parameter otherwise) const {
  if (!cursor) return otherwise;
  if (cursor.says("initial")) return {};
  if (cursor.is_number()) return cursor.number();
  if (cursor.is_object()) return scalar_function(cursor);

  const Cursor::List list =
      cursor.list(R"("initial", a number, a list of numbers, {"formula": "…"} or {"table": "…"})");
  if (list.size() != num_members) cursor.fail(fmt::format("one number, or a list of {}", num_members));
  Parameter each;
  bool is_constant = true;
  for (const Cursor entry : list) is_constant = is_constant && !entry.is_object();
  for (const Cursor entry : list) {
    if (is_constant)
      each.constants.push_back(entry.number());
    else
      each.functions.push_back(scalar_function(entry));
  }
  return each;
}

Parameter Context::constant_parameter(const Cursor& cursor, std::size_t num_members) const {
  if (cursor.says("initial")) return {};
  if (!cursor.is_number() && !cursor.is_list()) cursor.fail(R"("initial", a number or a list of numbers)");
  Parameter result;
  result.constants = numbers(cursor, num_members);
  return result;
}

std::vector<double> Context::numbers(const Cursor& cursor, std::size_t num_members) const {
  if (cursor.is_number()) return {cursor.number()};
  const Cursor::List list = cursor.list("a number or a list of numbers");
  if (list.size() != num_members) cursor.fail(fmt::format("one number, or a list of {}", num_members));
  std::vector<double> result;
  for (const Cursor entry : list) result.push_back(entry.number());
  return result;
}

std::vector<Vector3> Context::vectors(const Cursor& cursor) const {
  std::vector<Vector3> vectors;
  for (const Cursor entry : cursor.list("a list of vectors [x, y, z]")) vectors.push_back(entry.vector3());
  return vectors;
}

}  // namespace tanor::scene
