#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "crcl/error.hpp"

/// The part of XML that CRCL uses: elements without namespace, text, and xsi:type.
namespace aprsim::crcl {

struct XmlNode {
  std::string name;
  std::string type;  ///< local part of xsi:type, empty when absent
  std::string text;  ///< all character data directly inside, undivided by children
  std::vector<XmlNode> children;

  /// The first child with that name, or null.
  [[nodiscard]] const XmlNode* child(std::string_view child_name) const;
};

struct XmlLimits {
  std::size_t max_bytes = 65'536;
  std::size_t max_depth = 32;
  std::size_t max_attributes = 64;  ///< of one element
};

/// Parses one document. Refused as kMalformed: anything not well formed, any DOCTYPE, an element in
/// a namespace, a limit exceeded. Schema hints are ignored and nothing is ever fetched.
/// Thread: any; each thread keeps a parser of its own.
[[nodiscard]] Result<XmlNode> parse_xml(std::string_view document, const XmlLimits& limits = {});

/// Sets the XML library up, once; parse_xml() does so by itself. A process that reads its
/// environment from several threads calls this before it starts them.
void initialize_xml();

}  // namespace aprsim::crcl
