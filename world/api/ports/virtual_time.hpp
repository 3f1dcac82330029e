#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "world/api/commands/command.hpp"
#include "world/base/time.hpp"

/// Virtual time: simulated time that passes only as clients request it. A member waits at an
/// instant until its request is met. Time advances to the smallest request, and stops there
/// until every member has made its next request.
namespace aprsim::api {

enum class PacerKind {
  kFeed,     ///< a listener that forwards every camera frame before time goes on
  kProgram,  ///< an uploaded program: a member of its listener
  kClient,   ///< a connection whose requests are the clock
};

using PacerId = std::uint32_t;

struct PacerRole {
  std::string name;  ///< "crcl.fanuc", "modbus", "vision.fanuc"
  PacerKind kind = PacerKind::kClient;
  EndpointId endpoint = 0;  ///< of its commands
  int robot = -1;           ///< whose frames a feed forwards; negative = none
};

/// The listeners' side of virtual time. Thread: any.
class VirtualTime {
 public:
  virtual ~VirtualTime() = default;

  /// Simulated time that a request of a pacing client takes.
  [[nodiscard]] virtual SimTime poll_period() const = 0;
  /// Whether the role was declared as a pacer.
  [[nodiscard]] virtual bool is_registered(const std::string& role) const = 0;

  /// Adds a member. `reached` is called once for the latest request_until(), on any thread and
  /// within these functions, too: it posts to the listener's thread and does nothing else. nullopt
  /// when pacers were declared and all places of a client's role are taken: it does not pace then.
  [[nodiscard]] virtual std::optional<PacerId> join(PacerRole role,
                                                    std::function<void()> reached) = 0;
  /// Time may go on by `span`, at least one step. For a feed: until then or until the next frame of
  /// its camera; 0 = until the next frame alone. Commands submitted before take effect now.
  virtual void request_until(PacerId pacer, SimTime span) = 0;
  /// The client has finished sending. Its request still holds, but no other client is given up for
  /// its sake.
  virtual void finish(PacerId pacer) = 0;
  /// Once this has returned, `reached` is not called. No effect for an unknown pacer.
  virtual void leave(PacerId pacer) = 0;
  /// Like leave(), for a client whose listener refuses it for now: time does not wait for its
  /// return. It counts as given up.
  virtual void exclude(PacerId pacer) = 0;
};

}  // namespace aprsim::api
