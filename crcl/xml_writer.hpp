#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace aprsim::crcl {

struct XmlNode;

/// Writes one document on one line, as the reference servers do: no white space between elements,
/// no attribute but xsi:type.
class XmlWriter {
 public:
  XmlWriter();

  void open(std::string_view name);
  /// An element whose type the schema cannot tell from its name.
  void open(std::string_view name, std::string_view xsi_type);
  void close(std::string_view name);

  void text(std::string_view name, std::string_view value);
  void number(std::string_view name, double value);
  void integer(std::string_view name, std::int64_t value);
  void flag(std::string_view name, bool value);
  /// An element as it was read, with its xsi:types.
  void subtree(const XmlNode& node);
  /// What another writer has produced for the inside of an element.
  void raw(std::string_view xml) { out_ += xml; }

  [[nodiscard]] std::string take() { return std::move(out_); }

  /// The children of `node` that come after those named `Name`, `CommandID` and `Guard`.
  static std::string body_of_command(const XmlNode& node);

 private:
  explicit XmlWriter(std::string start) : out_(std::move(start)) {}

  std::string out_;
};

}  // namespace aprsim::crcl
