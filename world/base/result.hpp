#pragma once

#include <string>

#include <tl/expected.hpp>

namespace aprsim {

/// The kind of a failure, which each protocol maps to its own error form.
enum class ErrorCode {
  kInvalidArgument,     ///< a value is malformed or out of its range
  kNotFound,            ///< a name, file or index does not exist
  kUnreachable,         ///< no joint vector reaches the pose, or the path leaves the limits
  kFailedPrecondition,  ///< not possible in the present state
  kUnavailable,         ///< a queue is full or the simulation has stopped
  kUnimplemented,
};

/// An expected failure: peer input, limits, configuration. Broken invariants throw instead.
struct Error {
  ErrorCode code = ErrorCode::kInvalidArgument;
  std::string field;    ///< what was wrong: a joint, a key, a command's element
  std::string message;  ///< value, limit and unit, in one readable sentence
};

template <typename T>
using Result = tl::expected<T, Error>;

/// `return fail(ErrorCode::kNotFound, "scene", "no such file ...");`
inline tl::unexpected<Error> fail(ErrorCode code, std::string field, std::string message) {
  return tl::unexpected<Error>(Error{code, std::move(field), std::move(message)});
}

}  // namespace aprsim
