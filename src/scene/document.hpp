#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tanor::scene {

/// A JSON text as one tape of values: a list or an object is followed by what it holds, a key stands before its value.
///
///     {"a": [1, 2]}   ->   object | "a" | list | 1 | 2
///
/// 16 bytes a value, so a million points take 64 MB. No JSON pointers are kept: `pointer` finds a value's way when an
/// error asks for it.
class Document {
 public:
  /// Place of a value on the tape; the root is 0.
  using Node = std::uint32_t;
  enum class Type : std::uint8_t { Null, Boolean, Number, String, List, Object };

  /// Throws InputError: line and column where the text is no JSON, the JSON pointer of a duplicate key or of a number
  /// that is not finite.
  Document(const std::string& text, std::string file);

  Type type(Node node) const { return tape_[node].type; }
  double number(Node node) const { return tape_[node].number; }  ///< of a Number; 0 or 1 of a Boolean
  const std::string& string(Node node) const { return strings_[tape_[node].string]; }
  /// The first node behind this value and all that it holds.
  Node end(Node node) const { return tape_[node].end; }

  /// JSON pointer of a value, e.g. "/constraints/3/pairs/17"; of the next one where the tape is still being written.
  std::string pointer(Node node) const;
  /// "<file>: <pointer>"; the file alone for the root.
  std::string where(std::string_view pointer) const;

 private:
  class Builder;
  struct Value {
    Type type;
    Node end;
    union {
      double number;
      std::size_t string;
    };
  };

  std::string file_;
  std::vector<Value> tape_;
  std::vector<std::string> strings_;
};

/// "/key", with the escapes of JSON pointers.
std::string pointer_step(std::string_view key);

/// The beginning of a text, which ends in "…" where that is not all; never inside a character of UTF-8.
std::string cut(std::string_view text, std::size_t longest);

/// The text in double quotes on one line: control characters escaped, long ones cut.
std::string quote(std::string_view text);

}  // namespace tanor::scene
