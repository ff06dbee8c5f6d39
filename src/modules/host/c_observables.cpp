/// \file The calls of <tanor.h> about observables.

#include "host/c_call.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;

const Observed& find_observed(tn_system& system, size_t number) {
  const std::span<const Observed> all = system.constrainer().observed();
  if (number >= all.size())
    throw InputError("", "there is no observable " + std::to_string(number) + " among " + std::to_string(all.size()));
  return all[number];
}

}  // namespace

extern "C" {

int tn_add_observable(tn_system* system, const char* text, size_t* number) {
  return guard(system, [&](tn_system& self) {
    require(text, "text");
    const size_t added = self.constrainer().add_observable({.text = text});
    if (number != nullptr) *number = added;
  });
}

int tn_remove_observable(tn_system* system, size_t number) {
  return guard(system, [&](tn_system& self) { self.constrainer().remove_observable(number); });
}

int tn_observe(tn_system* system, double time, tn_const_points x, tn_const_points v, tn_const_points f, tn_points w,
               const tn_wanted* wanted, tn_report* report) {
  return report_on(system, report, [&](Constrainer& constrainer, const tn_system&) {
    return constrainer.observe(state_of(x, v, f, w, wanted, constrainer, time));
  });
}

int tn_observed(tn_system* system, size_t number, double* values, size_t* size) {
  return guard(
      system, [&](tn_system& self) { write_list<double>(find_observed(self, number).values, values, size, "values"); });
}

int tn_observed_member(tn_system* system, size_t number, char* member, size_t size) {
  return guard(system, [&](tn_system& self) {
    write_text(find_observed(self, number).member, member, size, "the name of a member");
  });
}

int tn_column_name(tn_system* system, size_t number, size_t column, char* text, size_t size) {
  return guard(system, [&](tn_system& self) {
    const std::vector<std::string> names = column_names(find_observed(self, number));
    if (column >= names.size())
      throw InputError("", "there is no column " + std::to_string(column) + " among " + std::to_string(names.size()));
    write_text(names[column], text, size, "the name of a column");
  });
}

int tn_extreme(tn_system* system, size_t number, size_t part, tn_which which, double* value, double* time, char* member,
               size_t size) {
  return guard(system, [&](tn_system& self) {
    const Observed& observed = find_observed(self, number);
    const std::vector<Extreme>& extremes = which == TN_LEAST ? observed.least : observed.largest;
    if (which != TN_LEAST && which != TN_LARGEST)
      throw InputError("", "which = " + std::to_string(static_cast<int>(which)) + " is not TN_LEAST or TN_LARGEST");
    if (part >= extremes.size())
      throw InputError("", "there is no part " + std::to_string(part) + " among " + std::to_string(extremes.size()));
    if (member != nullptr) write_text(extremes[part].member, member, size, "the name of a member");
    if (value != nullptr) *value = extremes[part].value;
    if (time != nullptr) *time = extremes[part].time;
  });
}

}  // extern "C"
