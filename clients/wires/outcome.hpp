#pragma once

#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace aprsim::client {

enum class FailureKind {
  kUsage,        ///< the arguments or files given are wrong
  kConnection,   ///< a wire cannot be reached, broke, or spoke nonsense
  kRefused,      ///< the cell answered that it cannot do what was asked
  kTimeout,      ///< no answer or no end in time
  kCheck,        ///< it was done, but the result is not what it should be
  kInterrupted,  ///< Ctrl-C or the like came first
};

/// Why something the user asked for did not happen, in one readable sentence.
struct Failure {
  FailureKind kind = FailureKind::kUsage;
  std::string message;
};

template <typename T>
using Outcome = tl::expected<T, Failure>;

inline tl::unexpected<Failure> failed(FailureKind kind, std::string message) {
  return tl::unexpected<Failure>(Failure{kind, std::move(message)});
}

}  // namespace aprsim::client
