#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tanor/units.hpp>

#include "observe/arguments.hpp"
#include "observe/instant.hpp"

namespace tanor::detail {

/// A quantity of things of a system, such as the tension of the rods of a group: [members x parts] numbers.
class Quantity {
 public:
  virtual ~Quantity() = default;

  virtual std::size_t num_members() const { return 1; }
  virtual std::string name_member(std::size_t) const { return {}; }
  /// Returns the constraint, support or force of a member; nothing if it is none of these.
  virtual std::optional<Thing> thing(std::size_t) const { return {}; }
  /// Returns the names of the parts of a member, "x", "y", "z" or none for a number.
  virtual std::vector<std::string> parts() const { return {}; }
  virtual std::size_t num_parts() const { return std::max<std::size_t>(1, parts().size()); }
  /// Returns true if the members of a vector are added up where nothing else is said.
  virtual bool is_sum() const { return false; }
  /// Returns true if all members were taken out, so that there are no numbers.
  virtual bool is_gone() const { return false; }
  virtual Needs needs() const = 0;
  virtual void evaluate(const ObservedInstant& at, double* values) const = 0;

  Dimension dimension = Dimension::None;
};

/// One number of an instant.
class Number final : public Quantity {
 public:
  using Find = std::function<double(const ObservedInstant&)>;
  Number(Dimension measures, Needs needs, Find find) : needs_(needs), find_(std::move(find)) { dimension = measures; }
  Needs needs() const override { return needs_; }
  void evaluate(const ObservedInstant& at, double* values) const override { values[0] = find_(at); }

 private:
  Needs needs_;
  Find find_;
};

/// One row of the table of quantities.
struct QuantityKind {
  std::string_view name;
  std::string_view arguments;  ///< as in "rods" or "thing, axis, about"
  std::string_view what;       ///< description in one line
  std::unique_ptr<Quantity> (*make)(const Things& things, const Arguments& arguments);
};

std::unique_ptr<Quantity> make_temperature(const Things& things, const Arguments& arguments);
std::unique_ptr<Quantity> make_pressure(const Things& things, const Arguments& arguments);
std::unique_ptr<Quantity> make_virial(const Things& things, const Arguments& arguments);

/// All quantities of this version.
std::span<const QuantityKind> quantity_kinds();

}  // namespace tanor::detail
