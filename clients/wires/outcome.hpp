#pragma once

#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace aprsim::client {

/// The kinds of failures, so that a program can act on them.
enum class FailureKind {
  kUsage,            ///< the arguments or files given are wrong
  kConnection,       ///< a wire cannot be reached, broke, or sent invalid data
  kUnauthenticated,  ///< the daemon knows no such token
  kRefused,          ///< the cell answered that it cannot do what was asked
  kTimeout,          ///< no answer or no end in time
  kCheck,            ///< it was done, but the result is not as required
  kInterrupted,      ///< the caller cancelled it
};

/// The reason why a request failed, in one readable sentence.
struct Failure {
  FailureKind kind = FailureKind::kUsage;
  std::string message;
};

/// The result of a request, or why there is none.
template <typename T>
using Outcome = tl::expected<T, Failure>;

/// `return failed(FailureKind::kTimeout, "no answer in time");`
inline tl::unexpected<Failure> failed(FailureKind kind, std::string message) {
  return tl::unexpected<Failure>(Failure{kind, std::move(message)});
}

}  // namespace aprsim::client
