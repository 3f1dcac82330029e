#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "world/api/commands/command.hpp"
#include "world/base/time.hpp"

/// Virtual time: simulated time that passes only as clients ask for it. Whoever takes part stands
/// at an instant until it asks for more; time goes to the least of what all have asked for, and
/// stands until the last of them has asked.
namespace aprsim::api {

enum class PacerKind {
  kFeed,     ///< a listener that hands on every camera frame before time goes on
  kProgram,  ///< an uploaded program: a listener's own, which nobody waits for but itself
  kClient,   ///< a connection whose requests are the clock
};

using PacerId = std::uint32_t;

struct PacerRole {
  std::string name;  ///< "crcl.fanuc", "modbus", "vision.fanuc"
  PacerKind kind = PacerKind::kClient;
  EndpointId endpoint = 0;  ///< of its commands
  int robot = -1;           ///< whose frames a feed hands on
};

/// The listeners' side of virtual time. Thread: any.
class VirtualTime {
 public:
  virtual ~VirtualTime() = default;

  /// Simulated time that a request of a pacing client takes.
  [[nodiscard]] virtual SimTime poll_period() const = 0;
  /// Whether that role is among those that have been declared to pace.
  [[nodiscard]] virtual bool declares(const std::string& role) const = 0;

  /// Takes part from now on. `reached` is called once for the latest ask(), on any thread and
  /// within these functions, too: it posts to the listener's thread and does nothing else. Nothing
  /// when pacers have been declared and all places of a client's role are taken: it paces nothing
  /// then.
  [[nodiscard]] virtual std::optional<PacerId> join(PacerRole role,
                                                    std::function<void()> reached) = 0;
  /// Time may go on by `span`, at least one step; for a feed until then or until the next frame of
  /// its camera, 0 = the latter alone. Commands submitted before take effect now.
  virtual void ask(PacerId pacer, SimTime span) = 0;
  /// The client has finished sending. What it has asked for still holds, but nobody is left behind
  /// for its sake.
  virtual void finish(PacerId pacer) = 0;
  /// `reached` is not called any more once this has returned. An unknown pacer: nothing.
  virtual void leave(PacerId pacer) = 0;
  /// The same of one that its listener does not let in again for now: nobody waits for its return,
  /// which counts as left behind.
  virtual void shut_out(PacerId pacer) = 0;
};

}  // namespace aprsim::api
