#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "python/call.hpp"

namespace tanor::python {

/// An object of the library that is made from a description on first use. Copies and pickles keep the description.
template <class Library>
class Handle {
 public:
  explicit Handle(std::string name) : name_(std::move(name)) {}
  virtual ~Handle() = default;
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  /// Returns call(library's object), run without the interpreter's lock.
  template <class Call>
  auto run(const Call& call) {
    const Turns::Turn turn(turns_, name_.c_str());
    if (!made_) made_.emplace(make());
    return without_lock([&] { return call(*made_); });
  }

 protected:
  /// Returns the library's object, which was made.
  const Library& made() const { return *made_; }

 private:
  virtual Library make() = 0;

  std::string name_;
  std::optional<Library> made_;
  Turns turns_;
};

/// Returns values that the library lends, for Python to keep.
template <class Value>
std::vector<Value> list_of(std::span<const Value> lent) {
  return std::vector<Value>(lent.begin(), lent.end());
}

/// Saved states are bytes of Python.
inline py::bytes to_bytes(const std::vector<std::byte>& saved) {
  return {reinterpret_cast<const char*>(saved.data()), saved.size()};
}
inline std::span<const std::byte> bytes_of(std::string_view saved) {
  return std::as_bytes(std::span(saved));
}

/// Returns what a method of the library returns, called without the interpreter's lock. `Self` has run(call).
template <class Self, auto method>
auto ask(Self& self) {
  return self.run([](auto& library) { return (library.*method)(); });
}

}  // namespace tanor::python
