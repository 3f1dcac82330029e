#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
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

/// Parses one document. Errors: kMalformed for a document that is not well formed, a DOCTYPE, an
/// element in a namespace, an exceeded limit. Schema hints are ignored; nothing is fetched.
/// Thread: any; each thread keeps a parser of its own.
[[nodiscard]] Result<XmlNode> parse_xml(std::string_view document, const XmlLimits& limits = {});

/// Initialises the XML library, once; parse_xml() does so itself. A process that reads its
/// environment from several threads calls this before it starts them.
void initialize_xml();

/// The first fault found while a document is decoded; later ones are not recorded.
using ErrorSlot = std::optional<Error>;

/// Reads the elements of one XML element by name, in any order. On a fault it records the element's
/// path and returns a neutral value, so that decoders need no branches and check the slot once at
/// the end. Must not outlive the node, its parent or the slot.
class Fields {
 public:
  Fields(const XmlNode& node, ErrorSlot& slot) : node_(&node), slot_(&slot) {}

  [[nodiscard]] bool has(std::string_view name) const { return node_->child(name) != nullptr; }
  [[nodiscard]] std::string_view type() const { return node_->type; }

  /// The child element; when it is missing, an error and an empty element.
  [[nodiscard]] Fields child(std::string_view name) const;
  /// All children with that name.
  [[nodiscard]] std::vector<Fields> children(std::string_view name) const;

  /// A finite number.
  [[nodiscard]] double number(std::string_view name) const;
  [[nodiscard]] std::optional<double> optional_number(std::string_view name) const;
  [[nodiscard]] int integer(std::string_view name) const;
  [[nodiscard]] std::optional<int> optional_integer(std::string_view name) const;
  [[nodiscard]] std::optional<std::int64_t> optional_long(std::string_view name) const;
  [[nodiscard]] std::optional<bool> optional_flag(std::string_view name) const;
  /// Absent = false, as the reference servers read a boolean.
  [[nodiscard]] bool flag(std::string_view name) const;
  /// As it stands, white space included.
  [[nodiscard]] std::string text(std::string_view name) const;
  [[nodiscard]] std::optional<std::string> optional_text(std::string_view name) const;

  /// Records that this element's child `name` (or this element, when empty) is wrong.
  void fail(std::string_view name, std::string_view value, std::string expected,
            ErrorKind kind = ErrorKind::kBadValue) const;

 private:
  Fields(const XmlNode& node, ErrorSlot& slot, const Fields* parent)
      : node_(&node), slot_(&slot), parent_(parent) {}
  [[nodiscard]] std::string path() const;

  const XmlNode* node_;
  ErrorSlot* slot_;
  const Fields* parent_ = nullptr;
};

}  // namespace aprsim::crcl
