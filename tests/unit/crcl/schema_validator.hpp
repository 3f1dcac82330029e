#pragma once

#include <memory>
#include <string>

namespace aprsim::crcl {

/// Validates documents against an XML Schema file, for tests only.
class SchemaValidator {
 public:
  /// Throws std::runtime_error when the schema cannot be loaded.
  explicit SchemaValidator(const std::string& schema_file);
  ~SchemaValidator();

  /// Empty when the document is valid, else the first fault.
  [[nodiscard]] std::string fault(const std::string& document) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::crcl
