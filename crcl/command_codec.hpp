#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "crcl/documents.hpp"
#include "crcl/error.hpp"
#include "crcl/framer.hpp"

/// Commands and programs between documents and values.
namespace aprsim::crcl {

/// Reads one CRCLCommandInstance document. Lenient where the reference servers are: elements in any
/// order, unknown ones ignored, a missing CommandID is 0, a missing boolean false, numbers outside
/// a schema range kept. Numbers must be finite and axes must give an orientation. A StopMotion
/// stops (Fast) even when its condition is not one of the three.
/// Errors: kMalformed for documents on which those servers close the connection (broken XML, a
/// missing or unknown xsi:type); kBadValue, with the command's type and id, for all others.
/// Thread: any.
[[nodiscard]] Result<CommandInstance> decode_command(std::string_view document,
                                                     std::size_t max_bytes = kMaxCommandBytes);

/// Reads a CRCLProgram document; the same rules for each of its commands.
[[nodiscard]] Result<Program> decode_program(std::string_view document,
                                             std::size_t max_bytes = kMaxProgramBytes);

/// One CRCLCommandInstance document on one line, elements in schema order.
[[nodiscard]] std::string encode_command(const CommandInstance& instance);

/// One CRCLProgram document: InitCanon and EndCanon as such, all others as MiddleCommand.
[[nodiscard]] std::string encode_program(const Program& program);

/// The schema's type name, e.g. "MoveToType".
[[nodiscard]] std::string_view type_name(const CommandBody& body);

}  // namespace aprsim::crcl
