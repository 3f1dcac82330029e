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

/// A document as a message, without loss of anything that the schema knows: Name elements are kept,
/// and missing elements stay absent. Elements may come in any order. Unknown elements are dropped,
/// and so is a second element where the schema allows one.
/// Errors: kMalformed as in command_codec.hpp; kBadValue for text that is no value of its element.
[[nodiscard]] Result<v1::CommandInstance> command_message(std::string_view document,
                                                          std::size_t max_bytes = kMaxCommandBytes);
[[nodiscard]] Result<v1::Program> program_message(std::string_view document,
                                                  std::size_t max_bytes = kMaxProgramBytes);
[[nodiscard]] Result<v1::Status> status_message(std::string_view document,
                                                std::size_t max_bytes = kMaxStatusBytes);

/// A message as a document on one line, elements in schema order. It is valid if the message has
/// all required fields. Characters that XML does not have become U+FFFD; an unspecified enumerator
/// is left out.
[[nodiscard]] std::string to_document(const v1::CommandInstance& message);
[[nodiscard]] std::string to_document(const v1::Program& message);
[[nodiscard]] std::string to_document(const v1::Status& message);

/// A C++ value as a message.
[[nodiscard]] v1::CommandInstance to_message(const CommandInstance& instance);
[[nodiscard]] v1::Program to_message(const Program& program);
[[nodiscard]] v1::Status to_message(const Status& status);

/// A message as a C++ value, which keeps only the names of documents, commands and guards.
/// Errors: those of decoding the equivalent document.
[[nodiscard]] Result<CommandInstance> from_message(const v1::CommandInstance& message);
[[nodiscard]] Result<Program> from_message(const v1::Program& message);
[[nodiscard]] Result<Status> from_message(const v1::Status& message);

}  // namespace aprsim::crcl
