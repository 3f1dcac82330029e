#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "aprsim/crcl/v1/commands.pb.h"
#include "aprsim/crcl/v1/status.pb.h"
#include "crcl/documents.hpp"
#include "crcl/error.hpp"
#include "crcl/framer.hpp"
#include "crcl/status.hpp"

/// The language as protobuf messages of package aprsim.crcl.v1: between documents and messages, and
/// between C++ values and messages. Thread: any.
namespace aprsim::crcl {

/// A document as a message, and nothing of it lost that the schema knows: names of parts too, and
/// what is missing stays missing. Elements may come in any order; unknown ones are left out, and so
/// is a second one where the schema has one.
/// Errors: kMalformed as in command_codec.hpp; kBadValue for text that is no value of its element.
[[nodiscard]] Result<v1::CommandInstance> command_message(std::string_view document,
                                                          std::size_t max_bytes = kMaxCommandBytes);
[[nodiscard]] Result<v1::Program> program_message(std::string_view document,
                                                  std::size_t max_bytes = kMaxProgramBytes);
[[nodiscard]] Result<v1::Status> status_message(std::string_view document,
                                                std::size_t max_bytes = kMaxStatusBytes);

/// A message as a document on one line, elements in schema order: valid if the message has what the
/// schema asks for. Characters that XML does not have become U+FFFD; an enumerator that is not
/// stated is left out.
[[nodiscard]] std::string to_document(const v1::CommandInstance& message);
[[nodiscard]] std::string to_document(const v1::Program& message);
[[nodiscard]] std::string to_document(const v1::Status& message);

/// A C++ value as a message.
[[nodiscard]] v1::CommandInstance to_message(const CommandInstance& instance);
[[nodiscard]] v1::Program to_message(const Program& program);
[[nodiscard]] v1::Status to_message(const Status& status);

/// A message as a C++ value, which keeps no names but those of documents, commands and guards.
/// Errors: those of the decoder of the document that says the same.
[[nodiscard]] Result<CommandInstance> from_message(const v1::CommandInstance& message);
[[nodiscard]] Result<Program> from_message(const v1::Program& message);
[[nodiscard]] Result<Status> from_message(const v1::Status& message);

}  // namespace aprsim::crcl
