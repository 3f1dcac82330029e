#pragma once

#include <string>
#include <string_view>

#include "world/api/values/state_ptr.hpp"
#include "world/base/result.hpp"

namespace aprsim::protocols {

/// Converts saved states to the bytes of files and back. Thread: any.
class StateFiles {
 public:
  virtual ~StateFiles() = default;

  /// Errors: kUnavailable where scene or models cannot be read.
  [[nodiscard]] virtual Result<std::string> write(const std::string& name,
                                                  const api::StatePtr& state) = 0;
  struct Read {
    std::string name;  ///< as it was saved
    api::StatePtr state;
  };
  /// Errors, field "file": kInvalidArgument where the bytes are no state file or damaged;
  /// kFailedPrecondition where they belong to another scene or layout, which it names; kUnavailable
  /// as above.
  [[nodiscard]] virtual Result<Read> read(std::string bytes) = 0;
};

}  // namespace aprsim::protocols
