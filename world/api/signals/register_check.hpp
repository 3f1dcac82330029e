#pragma once

#include <optional>
#include <string>

#include "world/api/description/register_map.hpp"
#include "world/api/signals/bound_signal.hpp"

namespace aprsim::api {

/// An error of a register in a scene.
struct RegisterProblem {
  std::string key;  ///< of the register, as in "encoding"
  std::string found, expected;
};

/// Whether a register makes sense by itself; absent = it does.
[[nodiscard]] std::optional<RegisterProblem> check_register(const Register& mapped);
/// Whether it fits its signal: access, and the signal's range in the encoding.
[[nodiscard]] std::optional<RegisterProblem> check_binding(const Register& mapped,
                                                           const BoundSignal& signal);

}  // namespace aprsim::api
