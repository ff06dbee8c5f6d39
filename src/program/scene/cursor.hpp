#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tanor/enum_names.hpp>

#include "scene/document.hpp"

namespace tanor::scene {

/// A value of a scene together with its place, so that every error names both.
///
/// A missing key gives an absent cursor. A reader then returns its default (`otherwise`), or fails with "missing,
/// wanted …" if it has none. An absent object has no keys and an absent list no entries. All readers throw InputError:
/// where() is "<file>: <JSON pointer>", what() is "found …, wanted …".
class Cursor {
 public:
  /// The root of a document, which must outlive the cursor.
  explicit Cursor(const Document& document) : document_(&document) {}

  explicit operator bool() const { return key_.empty(); }
  bool is_number() const { return is(Document::Type::Number); }
  bool is_string() const { return is(Document::Type::String); }
  bool is_list() const { return is(Document::Type::List); }
  bool is_object() const { return is(Document::Type::Object); }
  bool is_null() const { return is(Document::Type::Null); }
  /// Returns true if the value is this very string.
  bool says(std::string_view word) const { return is_string() && document_->string(node_) == word; }

  // Plain values.
  double number(std::optional<double> otherwise = {}) const;
  double positive(std::optional<double> otherwise = {}) const;
  double non_negative(std::optional<double> otherwise = {}) const;
  std::int64_t integer(std::int64_t least, std::int64_t most, std::optional<std::int64_t> otherwise = {}) const;
  bool boolean(std::optional<bool> otherwise = {}) const;
  const std::string& string() const;
  std::string string(const std::string& otherwise) const { return *this ? string() : otherwise; }
  Vector3 vector3(std::optional<Vector3> otherwise = {}) const;

  /// Reads one of an enumeration's words (<tanor/enum_names.hpp>).
  template <class Enum>
  Enum choice(std::optional<Enum> otherwise = {}) const {
    if (!*this && otherwise) return *otherwise;
    std::vector<std::string_view> words;
    for (const auto& each : enum_names<Enum>) words.push_back(each.name);
    return enum_names<Enum>[choice_index(words)].value;
  }

  /// Reads one of some names. `planned` are names that this version does not support yet.
  template <class T>
  T choice(const std::vector<std::pair<std::string_view, T>>& names, std::optional<T> otherwise = {},
           const std::vector<std::string_view>& planned = {}) const {
    if (!*this && otherwise) return *otherwise;
    std::vector<std::string_view> words;
    for (const auto& [word, value] : names) words.push_back(word);
    return names[choice_index(words, planned)].second;
  }
  std::size_t choice_index(const std::vector<std::string_view>& words,
                           const std::vector<std::string_view>& planned = {}) const;

  /// Returns itself after checking that it is an object with no other keys than these; an absent one has none.
  const Cursor& object(const std::vector<std::string_view>& keys) const;
  /// Returns a value of an object.
  Cursor operator[](std::string_view key) const;
  /// Returns all keys and values of an object; `wanted` says what it should be.
  std::vector<std::pair<std::string_view, Cursor>> members(std::string_view wanted) const;

  /// The entries of a list.
  class List;
  /// Returns the list; `wanted` says what it should be, e.g. "a list of pairs".
  List list(std::string_view wanted) const;
  /// Returns the same, with an absent list being empty.
  List optional_list(std::string_view wanted) const;

  /// Throws "found <this value>, wanted <wanted>" with this place.
  [[noreturn]] void fail(std::string_view wanted) const;
  /// Throws `what` with this place.
  [[noreturn]] void complain(const std::string& what) const;
  /// Calls `work` and adds this place to an InputError that it throws.
  template <class Work>
  auto locate(Work&& work) const {
    try {
      return work();
    } catch (const InputError& error) {
      complain(error.where().empty() ? error.what() : error.where() + ": " + error.what());
    }
  }

  /// Returns the JSON pointer of the value.
  std::string pointer() const;
  /// Returns the value behind one step of a JSON pointer, a key or a number, or itself if there is none.
  Cursor follow(std::string_view step) const;

 private:
  Cursor(const Document* document, Document::Node node, std::string_view key = {})
      : document_(document), node_(node), key_(key) {}
  bool is(Document::Type type) const { return key_.empty() && document_->type(node_) == type; }
  std::string describe() const;

  const Document* document_;
  Document::Node node_ = 0;
  std::string_view key_;  ///< key of an absent value; `node_` is the object that lacks it
};

class Cursor::List {
 public:
  class Iterator {
   public:
    Iterator(const Document* document, Document::Node node) : document_(document), node_(node) {}
    Cursor operator*() const { return {document_, node_}; }
    Iterator& operator++() {
      node_ = document_->end(node_);
      return *this;
    }
    bool operator!=(const Iterator& other) const { return node_ != other.node_; }

   private:
    const Document* document_;
    Document::Node node_;
  };

  List(const Document* document, Document::Node first, Document::Node last)
      : document_(document), first_(first), last_(last) {}
  Iterator begin() const { return {document_, first_}; }
  Iterator end() const { return {document_, last_}; }
  /// Counts the entries, in linear time.
  std::size_t size() const;

 private:
  const Document* document_;
  Document::Node first_, last_;
};

}  // namespace tanor::scene
