#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "crcl/error.hpp"

/// The schemas of the language, written for this project.
namespace aprsim::crcl {

struct SchemaFile {
  std::string_view name;  ///< e.g. "commands.xsd"
  std::string_view text;
};
/// All of them; the last three declare the roots.
[[nodiscard]] std::span<const SchemaFile> schema_files();

/// The first violation of the schema in a document with one of the three roots: kMalformed with
/// line and column; empty for a valid document. Schema hints in the document are ignored, and
/// nothing is fetched. Thread: any; each thread keeps a parser of its own.
[[nodiscard]] std::optional<Error> schema_fault(std::string_view document);

}  // namespace aprsim::crcl
