#include "scene/cursor.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/suggestion.hpp"
#include "scene/parts.hpp"

namespace tanor::scene {
using namespace detail;

double Cursor::number(std::optional<double> otherwise) const {
  if (!*this && otherwise) return *otherwise;
  if (!is_number()) fail("a number");
  return document_->number(node_);
}

double Cursor::positive(std::optional<double> otherwise) const {
  if (!*this && otherwise) return *otherwise;
  if (!is_number() || !(number() > 0.0)) fail("a number > 0");
  return number();
}

double Cursor::non_negative(std::optional<double> otherwise) const {
  if (!*this && otherwise) return *otherwise;
  if (!is_number() || !(number() >= 0.0)) fail("a number >= 0");
  return number();
}

std::int64_t Cursor::integer(std::int64_t least, std::int64_t most, std::optional<std::int64_t> otherwise) const {
  if (!*this && otherwise) return *otherwise;
  const auto in_range = [&](double x) {
    return x == std::floor(x) && x >= static_cast<double>(least) && x <= static_cast<double>(most);
  };
  if (!is_number() || !in_range(number())) fail(fmt::format("a whole number from {} to {}", least, most));
  return static_cast<std::int64_t>(number());
}

bool Cursor::boolean(std::optional<bool> otherwise) const {
  if (!*this && otherwise) return *otherwise;
  if (!is(Document::Type::Boolean)) fail("true or false");
  return document_->number(node_) != 0.0;
}

const std::string& Cursor::string() const {
  if (!is_string()) fail("a string");
  return document_->string(node_);
}

Vector3 Cursor::vector3(std::optional<Vector3> otherwise) const {
  if (!*this && otherwise) return *otherwise;
  constexpr std::string_view wanted = "3 numbers [x, y, z]";
  if (list(wanted).size() != 3) fail(wanted);
  Vector3 vector;
  std::size_t k = 0;
  for (const Cursor component : list(wanted)) vector[k++] = component.number();
  return vector;
}

std::size_t Cursor::choice_index(const std::vector<std::string_view>& words,
                                 const std::vector<std::string_view>& planned) const {
  const std::string wanted = fmt::format("{}{}", words.size() > 1 ? "one of " : "", fmt::join(words, ", "));
  if (!is_string()) fail(wanted);
  const auto found = std::find(words.begin(), words.end(), string());
  if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
  if (std::find(planned.begin(), planned.end(), string()) == planned.end())
    complain(fmt::format("found {}{}, wanted {}", describe(), suggest(string(), {words.begin(), words.end()}), wanted));
  complain(fmt::format("found {}, which this version of tanor does not have yet, wanted {}", describe(), wanted));
}

const Cursor& Cursor::object(const std::vector<std::string_view>& keys) const {
  for (const auto& [key, value] : members("an object")) {
    if (std::find(keys.begin(), keys.end(), key) == keys.end())
      value.complain(fmt::format("found the unknown key {}{}, wanted one of {}", quote(key), explain_key(key, keys),
                                 fmt::join(keys, ", ")));
  }
  return *this;
}

Cursor Cursor::operator[](std::string_view key) const {
  for (const auto& [name, value] : members("an object"))
    if (name == key) return value;
  return {document_, node_, key};
}

std::vector<std::pair<std::string_view, Cursor>> Cursor::members(std::string_view wanted) const {
  std::vector<std::pair<std::string_view, Cursor>> members;
  if (!*this) return members;
  if (!is_object()) fail(wanted);
  for (Document::Node key = node_ + 1; key < document_->end(node_); key = document_->end(key + 1))
    members.emplace_back(document_->string(key), Cursor(document_, key + 1));
  return members;
}

Cursor::List Cursor::list(std::string_view wanted) const {
  if (!is_list()) fail(wanted);
  return {document_, node_ + 1, document_->end(node_)};
}

Cursor::List Cursor::optional_list(std::string_view wanted) const {
  return *this ? list(wanted) : List(document_, node_, node_);
}

std::size_t Cursor::List::size() const {
  std::size_t count = 0;
  for (Document::Node node = first_; node != last_; node = document_->end(node)) ++count;
  return count;
}

void Cursor::fail(std::string_view wanted) const {
  complain(fmt::format("{}, wanted {}", *this ? "found " + describe() : "missing", wanted));
}

void Cursor::complain(const std::string& what) const {
  throw InputError(document_->where(pointer()), what);
}

std::string Cursor::pointer() const {
  return *this ? document_->pointer(node_) : document_->pointer(node_) + pointer_step(key_);
}

Cursor Cursor::follow(std::string_view step) const {
  if (is_object())
    for (const auto& [key, value] : members(""))
      if (key == step) return value;
  if (is_list()) {
    std::size_t index = 0;
    for (const Cursor entry : list(""))
      if (std::to_string(index++) == step) return entry;
  }
  return *this;
}

std::string Cursor::describe() const {
  switch (document_->type(node_)) {
    case Document::Type::Null:
      return "null";
    case Document::Type::Boolean:
      return document_->number(node_) != 0.0 ? "boolean true" : "boolean false";
    case Document::Type::Number:
      return fmt::format("number {}", document_->number(node_));
    case Document::Type::String:
      return "string " + quote(document_->string(node_));
    case Document::Type::List:
      return fmt::format("a list of {}", list("").size());
    case Document::Type::Object:
      return "an object";
  }
  return {};
}

}  // namespace tanor::scene
