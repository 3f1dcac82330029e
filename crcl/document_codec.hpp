#pragma once

#include "crcl/documents.hpp"
#include "crcl/element_writer.hpp"
#include "crcl/error.hpp"
#include "crcl/status.hpp"
#include "crcl/xml_reader.hpp"

/// Whole documents as elements, independent of the medium that they are read from or written to.
/// The rules are those of command_codec.hpp and status_codec.hpp.
namespace aprsim::crcl {

inline constexpr std::string_view kCommandRoot = "CRCLCommandInstance";
inline constexpr std::string_view kProgramRoot = "CRCLProgram";
inline constexpr std::string_view kStatusRoot = "CRCLStatus";

[[nodiscard]] Result<CommandInstance> read_command_instance(const XmlNode& root);
[[nodiscard]] Result<Program> read_program(const XmlNode& root);
[[nodiscard]] Result<Status> read_status(const XmlNode& root);

void write_command_instance(ElementWriter& out, const CommandInstance& instance);
void write_program(ElementWriter& out, const Program& program);
void write_status(ElementWriter& out, const Status& status);

}  // namespace aprsim::crcl
