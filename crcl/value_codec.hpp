#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "crcl/element_writer.hpp"
#include "crcl/error.hpp"
#include "crcl/values.hpp"
#include "crcl/xml_reader.hpp"

/// Encodes and decodes the value types of DataPrimitives.xsd that commands and statuses share, and
/// computes the orientation of a pose's axes.
namespace aprsim::crcl {

/// A right-handed orthonormal triad: the columns of a pose's rotation matrix.
struct Axes {
  Vector x, y, z;
};

/// The triad of a pose: ZAxis normalised, XAxis made perpendicular to it and normalised, Y = Z x X.
/// Writers round their axes (0.707), so lengths and right angles need not be exact. Errors:
/// kBadValue for an axis without length, or axes closer to parallel than about 6 degrees.
[[nodiscard]] Result<Axes> orthonormal_axes(const Pose& pose);

[[nodiscard]] Vector read_point(const Fields& point);
[[nodiscard]] Vector read_vector(const Fields& vector);
[[nodiscard]] Pose read_pose(const Fields& pose);
[[nodiscard]] PoseTolerance read_pose_tolerance(const Fields& tolerance);
[[nodiscard]] std::vector<JointTolerance> read_joint_tolerances(const Fields& tolerances);
[[nodiscard]] ParameterSetting read_parameter(const Fields& setting);
/// All children with that name.
[[nodiscard]] std::vector<ParameterSetting> read_parameters(const Fields& parent,
                                                            std::string_view name);

/// PointType.
void write_point(ElementWriter& out, std::string_view name, const Vector& point);
/// VectorType.
void write_vector(ElementWriter& out, std::string_view name, const Vector& vector);
/// Point, XAxis, ZAxis, without an element around them.
void write_pose_elements(ElementWriter& out, const Pose& pose);
void write_tolerance(ElementWriter& out, std::string_view name, const PoseTolerance& tolerance);
void write_joint_tolerances(ElementWriter& out, std::string_view name,
                            const std::vector<JointTolerance>& tolerances);
void write_parameter(ElementWriter& out, std::string_view name, const ParameterSetting& setting);
void write_parameters(ElementWriter& out, std::string_view name,
                      const std::vector<ParameterSetting>& settings);

/// The element only when there is a value.
void write_optional(ElementWriter& out, std::string_view name, const std::optional<double>& value);
void write_optional(ElementWriter& out, std::string_view name, const std::optional<int>& value);
void write_optional(ElementWriter& out, std::string_view name,
                    const std::optional<std::int64_t>& value);
void write_optional(ElementWriter& out, std::string_view name, const std::optional<bool>& value);
void write_optional(ElementWriter& out, std::string_view name,
                    const std::optional<std::string>& value);

}  // namespace aprsim::crcl
