#pragma once

#include <stdexcept>
#include <string>

namespace aprsim::physics {

/// The world cannot continue: a state that is not a number, runaway energy, or an error in ODE.
/// what() names step, body and cause. The world that threw cannot continue.
class PhysicsFailure : public std::runtime_error {
 public:
  explicit PhysicsFailure(const std::string& what) : std::runtime_error(what) {}
};

}  // namespace aprsim::physics
