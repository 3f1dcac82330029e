#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "crcl/values.hpp"
#include "crcl/xml_writer.hpp"

/// The shared value types as elements, in schema order. DataPrimitives.xsd.
namespace aprsim::crcl {

/// PointType.
void write_point(XmlWriter& out, std::string_view name, const Vector& point);
/// VectorType.
void write_vector(XmlWriter& out, std::string_view name, const Vector& vector);
/// Point, XAxis, ZAxis, without an element around them.
void write_pose_elements(XmlWriter& out, const Pose& pose);
void write_tolerance(XmlWriter& out, std::string_view name, const PoseTolerance& tolerance);
void write_joint_tolerances(XmlWriter& out, std::string_view name,
                            const std::vector<JointTolerance>& tolerances);
void write_parameter(XmlWriter& out, std::string_view name, const ParameterSetting& setting);
void write_parameters(XmlWriter& out, std::string_view name,
                      const std::vector<ParameterSetting>& settings);

/// The element only when there is a value.
void write_optional(XmlWriter& out, std::string_view name, const std::optional<double>& value);
void write_optional(XmlWriter& out, std::string_view name, const std::optional<int>& value);
void write_optional(XmlWriter& out, std::string_view name,
                    const std::optional<std::int64_t>& value);
void write_optional(XmlWriter& out, std::string_view name, const std::optional<bool>& value);
void write_optional(XmlWriter& out, std::string_view name, const std::optional<std::string>& value);

}  // namespace aprsim::crcl
