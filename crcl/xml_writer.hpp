#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace aprsim::crcl {

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

  [[nodiscard]] std::string take() { return std::move(out_); }

 private:
  std::string out_;
};

}  // namespace aprsim::crcl
