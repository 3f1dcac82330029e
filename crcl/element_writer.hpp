#pragma once

#include <cstdint>
#include <string_view>

namespace aprsim::crcl {

/// Receives the elements of a document in order and writes them as text or as a tree.
class ElementWriter {
 public:
  ElementWriter() = default;
  ElementWriter(const ElementWriter&) = delete;
  ElementWriter& operator=(const ElementWriter&) = delete;
  virtual ~ElementWriter() = default;

  virtual void open(std::string_view name) = 0;
  /// An element whose type the schema cannot tell from its name.
  virtual void open(std::string_view name, std::string_view xsi_type) = 0;
  virtual void close(std::string_view name) = 0;

  /// Elements that contain only a value.
  virtual void text(std::string_view name, std::string_view value) = 0;
  virtual void number(std::string_view name, double value) = 0;
  virtual void integer(std::string_view name, std::int64_t value) = 0;
  void flag(std::string_view name, bool value) { text(name, value ? "true" : "false"); }
};

}  // namespace aprsim::crcl
