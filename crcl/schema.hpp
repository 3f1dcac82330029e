#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "crcl/error.hpp"

/// The schemas of the language, as this project writes them down.
namespace aprsim::crcl {

struct SchemaFile {
  std::string_view name;  ///< e.g. "commands.xsd"
  std::string_view text;
};
/// All of them; the last three declare the roots.
[[nodiscard]] std::span<const SchemaFile> schema_files();

/// What a schema does not allow in a document with any of the three roots: kMalformed with line and
/// column, nothing when it is valid. Hints in the document to other schemas are ignored and nothing
/// is ever fetched. Thread: any; each thread keeps a parser of its own.
[[nodiscard]] std::optional<Error> schema_fault(std::string_view document);

}  // namespace aprsim::crcl
