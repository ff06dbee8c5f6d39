#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tanor::scene {

/// A JSON text as one tape of values. The content of a list or object follows it, and a key precedes its value.
///
///     {"a": [1, 2]}   ->   object | "a" | list | 1 | 2
///
/// A value takes 16 bytes, so that a million points take 64 MB. No JSON pointers are stored; `pointer` finds the path
/// to a value when an error needs it.
class Document {
 public:
  /// Position of a value on the tape; the root is 0.
  using Node = std::uint32_t;
  enum class Type : std::uint8_t { Null, Boolean, Number, String, List, Object };

  /// Parses the text. Throws InputError, which names line and column if the text is not JSON, and the JSON pointer of a
  /// duplicate key or of a number that is not finite.
  Document(const std::string& text, std::string file);

  Type type(Node node) const { return tape_[node].type; }
  double number(Node node) const { return tape_[node].number; }  ///< of a Number; 0 or 1 of a Boolean
  const std::string& string(Node node) const { return strings_[tape_[node].string]; }
  /// Returns the first node after this value and its content.
  Node end(Node node) const { return tape_[node].end; }

  /// Returns the JSON pointer of a value, e.g. "/constraints/3/pairs/17"; of the next one while the tape is being
  /// written.
  std::string pointer(Node node) const;
  /// Returns "<file>: <pointer>", or the file alone for the root.
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

/// Returns "/key", with the escapes of JSON pointers.
std::string pointer_step(std::string_view key);

/// Returns the beginning of a text, ending in "…" if it was cut; never cuts inside a UTF-8 character.
std::string cut(std::string_view text, std::size_t longest);

/// Returns the text in double quotes on one line, with control characters escaped and long texts cut.
std::string quote(std::string_view text);

}  // namespace tanor::scene
