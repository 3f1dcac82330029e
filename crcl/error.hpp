#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <tl/expected.hpp>

namespace aprsim::crcl {

/// The stage at which a document was rejected.
enum class ErrorKind {
  kTooLarge,   ///< more bytes than the limit without an end tag
  kMalformed,  ///< not XML, a limit of the parser, or an element that cannot be a CRCL document
  kBadValue,   ///< a known command or status with a field that is missing or out of its domain
};

/// A fault of a document: the element, its text, the expected content.
struct Error {
  ErrorKind kind = ErrorKind::kMalformed;
  std::string element;   ///< path of the element, e.g. MoveToType/EndPosition/Point/X
  std::string value;     ///< the offending text, shortened; empty when something is missing
  std::string expected;  ///< what the element must hold
  /// Only for kBadValue in a command: the command that the document carried.
  std::string command_type;
  std::optional<std::int64_t> command_id;

  /// One readable sentence.
  [[nodiscard]] std::string message() const;
};

template <typename T>
using Result = tl::expected<T, Error>;

}  // namespace aprsim::crcl
