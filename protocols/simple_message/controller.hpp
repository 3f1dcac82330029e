#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "protocols/simple_message/connection.hpp"

namespace aprsim::simple_message {

/// The programs of one robot's controller behind its three ports. Thread: the listener's.
class Controller {
 public:
  virtual ~Controller() = default;

  /// A request on the motion port. False: the program does not read now.
  [[nodiscard]] virtual bool take_motion(Connection& connection,
                                         std::span<const std::uint8_t> request,
                                         bool known_length) = 0;
  [[nodiscard]] virtual bool take_gripper(Connection& connection,
                                          std::span<const std::uint8_t> request,
                                          bool known_length) = 0;
  /// Whether a reply is owed to this connection.
  [[nodiscard]] virtual bool owes(const Connection& connection) const = 0;

  /// The motion port serves a client from now on, or no more.
  virtual void motion_connected(Connection& connection) = 0;
  virtual void motion_gone(Connection& connection) = 0;
  /// Whether a new client of the motion port takes the place of the present one.
  [[nodiscard]] virtual bool yields_motion() = 0;

  /// Follows the cell. Called about every millisecond while waits().
  virtual void advance() = 0;
  [[nodiscard]] virtual bool waits() const = 0;
  /// Tells the log of a motion that has ended before its last point. Changes nothing else.
  virtual void report_ends() = 0;

  [[nodiscard]] virtual std::chrono::milliseconds state_period() const = 0;
  /// The messages of one period.
  [[nodiscard]] virtual std::vector<std::string> states() = 0;
};

}  // namespace aprsim::simple_message
