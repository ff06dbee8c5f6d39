#include "python/host_handle.hpp"

#include <algorithm>
#include <cstring>
#include <memory>
#include <numeric>
#include <string_view>
#include <variant>

#include "python/arrays.hpp"
#include "python/kinds.hpp"

namespace tanor::python {
namespace {

Constraint read_constraint(const py::object& constraint) {
  py::list list;
  list.append(constraint);
  return std::move(read_constraints(list).front());
}

/// True if some number of the group is measured where its points are when it is added.
bool has_initial(const Constraint& constraint) {
  return std::visit(
      []<class Kind>(const Kind& group) {
        const auto is_initial = [&](const auto& field) {
          if constexpr (std::is_same_v<std::remove_cv_t<decltype(field.value)>, Parameter Kind::*>)
            return (group.*field.value).is_initial();
          else
            return false;
        };
        return std::apply([&](const auto&... field) { return (is_initial(field) || ...); }, KindOf<Kind>::fields);
      },
      constraint);
}

}  // namespace

PeriodicCell read_cell(const py::object& cell, const py::object& repeats) {
  PeriodicCell result;
  const Given given{cell, "/cell"};
  std::vector<Vector3> edges;
  if (py::len(cell) == 3 && PySequence_Check(py::object(cell[py::int_(0)]).ptr()) == 0) {
    Vector3 lengths;
    read(given, &lengths);
    for (std::size_t k = 0; k < 3; ++k) result.edges[k][k] = lengths[k];
  } else {
    read(given, &edges);
    if (edges.size() != 3) given.fail("three edges [3, 3], or three lengths of an orthogonal cell");
    std::copy(edges.begin(), edges.end(), result.edges.begin());
  }
  const std::vector<Given> each = Given{repeats, "/repeats"}.entries("three of True and False");
  if (each.size() != 3) Given{repeats, "/repeats"}.fail("three of True and False");
  for (std::size_t k = 0; k < 3; ++k) result.repeats[k] = each[k].value.cast<bool>();
  return result;
}

std::vector<std::array<int, 3>> read_images(const py::object& images) {
  std::vector<std::array<int, 3>> result;
  if (images.is_none()) return result;
  for (const Given& row : Given{images, "/images"}.entries("three whole numbers a row")) {
    const std::vector<Given> numbers = row.entries("three whole numbers");
    if (numbers.size() != 3) row.fail("three whole numbers");
    std::array<int, 3>& image = result.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) read(numbers[k], &image[k]);
  }
  return result;
}

HostHandle::HostHandle(Description description) : Handle("Constrainer"), description_(std::move(description)) {
  read({description_.masses, "/masses"}, &masses_);
  take_positions(points_to_read(description_.positions, {"positions", num_points()}));
}

void HostHandle::take_positions(const ConstPointArray& positions) {
  if (!positions) return;
  positions_.resize(3 * masses_.size());
  const std::ptrdiff_t stride =
      positions.stride != 0 ? positions.stride : static_cast<std::ptrdiff_t>(3 * sizeof(double));
  for (std::size_t i = 0; i < masses_.size(); ++i) {
    const auto place = positions.index != nullptr ? positions.index[i] : static_cast<std::ptrdiff_t>(i);
    std::memcpy(&positions_[3 * i], reinterpret_cast<const std::byte*>(positions.data) + place * stride,
                3 * sizeof(double));
  }
}

// ---- edits ----

void HostHandle::set_cell(const py::object& edges, const py::object& repeats) {
  const py::object kept = repeats.is_none() ? description_.repeats : repeats;
  const PeriodicCell cell = read_cell(edges, kept);
  run([&](Constrainer& constrainer) { constrainer.set_cell(cell); });
  description_.present_cell = py::make_tuple(py::module_::import("numpy").attr("array")(edges), kept);
}

ConstraintId HostHandle::add(const py::object& constraint, ConstPointArray positions, const py::object& images) {
  Constraint group = read_constraint(constraint);
  const bool is_initial = has_initial(group);
  if (is_initial && !positions)
    throw py::value_error("positions: they are needed, since lengths that are not given are those found there");
  std::vector<std::array<int, 3>> each = read_images(images);
  const ConstraintId id = run([&](Constrainer& c) { return c.add(std::move(group), positions, std::move(each)); });
  take_positions(positions);
  const py::object none = py::none();
  edits_.append(py::make_tuple("add", constraint, images, is_initial ? py::object(copy(positions_, 3)) : none,
                               is_initial ? description_.present_cell : none));
  return id;
}

void HostHandle::remove(const py::object& ids) {
  std::vector<std::int64_t> numbers;
  read({ids, "/ids"}, &numbers);
  run([&](Constrainer& c) { c.remove(numbers); });
  for (const ConstraintId id : numbers) lengths_.erase(id);
  edits_.append(py::make_tuple("remove", numbers));
}

void HostHandle::set_lengths(const py::object& ids, const py::object& lengths, const py::object& rates) {
  std::vector<std::int64_t> numbers;
  std::vector<double> now, speeds;
  read({ids, "/ids"}, &numbers);
  read({lengths, "/lengths"}, &now);
  if (!rates.is_none()) read({rates, "/rates"}, &speeds);
  run([&](Constrainer& c) { c.set_lengths(numbers, now, speeds); });
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    auto& [length, rate, moves] = lengths_[numbers[k]];
    length = now[k];
    rate = speeds.empty() ? 0.0 : speeds[k];
    moves = moves || rate != 0.0;
  }
}

void HostHandle::set_masses(const py::object& points, const py::object& masses) {
  std::vector<Index> numbers;
  std::vector<double> now;
  read({points, "/points"}, &numbers);
  read({masses, "/masses"}, &now);
  run([&](Constrainer& c) { c.set_masses(numbers, now); });
  for (std::size_t k = 0; k < numbers.size(); ++k) masses_[static_cast<std::size_t>(numbers[k])] = now[k];
}

void HostHandle::renumber(const py::object& from, const py::object& masses, const py::object& positions,
                          const py::object& index) {
  std::vector<std::int64_t> numbers;
  std::vector<double> now;
  read({from, "/from_"}, &numbers);
  read({masses, "/masses"}, &now);
  const auto size = static_cast<py::ssize_t>(numbers.size());
  const std::span<const Index> order = index_to_read(index, {"index", size, 0});
  const ConstPointArray at =
      points_to_read(positions, {"positions", order.empty() ? std::optional(size) : std::nullopt}, order);
  run([&](Constrainer& c) { c.renumber(numbers, now, at); });
  masses_ = now;
  const std::vector<double> before = std::exchange(positions_, std::vector<double>(3 * numbers.size()));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] >= 0) std::copy_n(&before[3 * static_cast<std::size_t>(numbers[i])], 3, &positions_[3 * i]);
  }
  take_positions(at);
  if (py::len(edits_) > 0 && edits_[py::len(edits_) - 1].cast<py::tuple>()[0].cast<std::string>() == "renumber") {
    // Two renumberings in a row become one, so that the list does not grow if points migrate in every step.
    const auto first = edits_[py::len(edits_) - 1].cast<py::tuple>()[1].cast<std::vector<std::int64_t>>();
    for (std::int64_t& number : numbers) number = number < 0 ? number : first[static_cast<std::size_t>(number)];
    edits_.attr("pop")();
  }
  edits_.append(py::make_tuple("renumber", numbers, now));
}

// ---- observables ----

std::size_t HostHandle::add_observable(const std::string& text, const std::string& name, const std::string& unit) {
  const Observable wanted{.name = name, .text = text, .unit = unit};
  const std::size_t number = run([&](Constrainer& c) { return c.add_observable(wanted); });
  edits_.append(py::make_tuple("observe", text, name, unit));
  return number;
}

void HostHandle::remove_observable(std::size_t number) {
  run([&](Constrainer& c) { c.remove_observable(number); });
  edits_.append(py::make_tuple("forget", number));
}

// ---- copies ----

py::bytes HostHandle::save() {
  return to_bytes(ask<HostHandle, &Constrainer::save>(*this));
}

void HostHandle::restore(const py::bytes& saved) {
  run([&](Constrainer& c) { c.restore(bytes_of(saved)); });
}

py::tuple HostHandle::state() {
  const py::bytes saved = save();
  const Description& d = description_;
  return py::make_tuple(
      py::make_tuple(d.masses, d.constraints, d.positions, d.cell, d.repeats, d.images, d.options, d.present_cell),
      py::list(edits_), lengths_, copy(masses_, 0), copy(positions_, 3), saved);
}

std::unique_ptr<HostHandle> HostHandle::from_state(const py::tuple& state) {
  const py::tuple d = state[0];
  auto copied = std::make_unique<HostHandle>(Description{d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]});
  copied->edits_ = state[1];
  copied->lengths_ = state[2].cast<std::map<ConstraintId, Length>>();
  read({state[3], "/masses"}, &copied->masses_);
  copied->take_positions(points_to_read(state[4], {"positions", copied->num_points()}));
  copied->saved_ = state[5];
  return copied;
}

Periodicity HostHandle::read_periodicity() const {
  return {.cell = read_cell(description_.cell, description_.repeats), .images = read_images(description_.images)};
}

Constrainer HostHandle::make() {
  std::vector<double> masses;
  read({description_.masses, "/masses"}, &masses);
  std::vector<Constraint> constraints = read_constraints(description_.constraints);
  const auto options = choose_options<SolverOptions>(description_.options, py::none());
  const ConstPointArray at =
      points_to_read(description_.positions, {"positions", static_cast<py::ssize_t>(masses.size())});
  const bool has_cell = !description_.cell.is_none();
  const Periodicity periodicity = has_cell ? read_periodicity() : Periodicity{};
  Constrainer made = without_lock([&] {
    return has_cell ? Constrainer(masses, std::move(constraints), at, periodicity, options)
                    : Constrainer(masses, std::move(constraints), at, options);
  });
  if (saved_.is_none()) return made;
  replay(&made);
  const py::bytes saved = std::exchange(saved_, py::none());
  made.restore(bytes_of(saved));
  return made;
}

/// Replays the edits, none of which plans anything, then sets the present state.
void HostHandle::replay(Constrainer* constrainer) const {
  const auto set_cell = [&](const py::object& cell) {
    if (cell.is_none()) return;
    const auto [edges, repeats] = cell.cast<std::pair<py::object, py::object>>();
    constrainer->set_cell(read_cell(edges, repeats));
  };
  for (const py::handle each : edits_) {
    const auto edit = each.cast<py::tuple>();
    const auto name = edit[0].cast<std::string>();
    if (name == "add") {
      set_cell(edit[4]);
      (void)constrainer->add(read_constraint(edit[1]), points_to_read(edit[3], {"positions"}), read_images(edit[2]));
    } else if (name == "remove") {
      constrainer->remove(edit[1].cast<std::vector<ConstraintId>>());
    } else if (name == "observe") {
      constrainer->add_observable({.name = edit[2].cast<std::string>(),
                                   .text = edit[1].cast<std::string>(),
                                   .unit = edit[3].cast<std::string>()});
    } else if (name == "forget") {
      constrainer->remove_observable(edit[1].cast<std::size_t>());
    } else {
      constrainer->renumber(edit[1].cast<std::vector<std::int64_t>>(), edit[2].cast<std::vector<double>>());
    }
  }
  replay_lengths(constrainer);
  std::vector<std::int64_t> same(masses_.size());
  std::iota(same.begin(), same.end(), 0);
  constrainer->renumber(same, masses_, positions_);
  set_cell(description_.present_cell);
}

/// Sets lengths. A length that had a rate once is read in every call from then on, so it first gets a rate here, too.
void HostHandle::replay_lengths(Constrainer* constrainer) const {
  std::vector<ConstraintId> ids;
  std::vector<double> lengths, rates, first_rates;
  for (const auto& [id, set] : lengths_) {
    const auto& [length, rate, moves] = set;
    ids.push_back(id);
    lengths.push_back(length);
    rates.push_back(rate);
    first_rates.push_back(moves ? 1.0 : 0.0);
  }
  constrainer->set_lengths(ids, lengths, first_rates);
  constrainer->set_lengths(ids, lengths, rates);
}

}  // namespace tanor::python
