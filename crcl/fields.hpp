#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "crcl/error.hpp"
#include "crcl/values.hpp"
#include "crcl/xml_tree.hpp"

namespace aprsim::crcl {

/// The first thing found wrong while a document is decoded; later ones are not recorded.
using ErrorSlot = std::optional<Error>;

/// Reads the elements of one XML element by name, in any order. A reader that meets a fault records
/// it with the path of the element and returns a neutral value, so that decoders read straight
/// through and look at the slot once at the end. Must not outlive the node, its parent or the slot.
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

/// The shared value types. Elements as in DataPrimitives.xsd.
[[nodiscard]] Vector read_point(const Fields& point);
[[nodiscard]] Vector read_vector(const Fields& vector);
[[nodiscard]] Pose read_pose(const Fields& pose);
[[nodiscard]] PoseTolerance read_pose_tolerance(const Fields& tolerance);
[[nodiscard]] std::vector<JointTolerance> read_joint_tolerances(const Fields& tolerances);
[[nodiscard]] ParameterSetting read_parameter(const Fields& setting);
/// All children with that name.
[[nodiscard]] std::vector<ParameterSetting> read_parameters(const Fields& parent,
                                                            std::string_view name);

}  // namespace aprsim::crcl
