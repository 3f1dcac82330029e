#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "world/api/ports/virtual_time.hpp"
#include "world/api/snapshot/virtual_time_state.hpp"
#include "world/runtime/time/pacer.hpp"

namespace aprsim::world {

/// A conservative barrier: virtual time goes no further than every member has requested. Counts
/// steps from the start, over all resets. The wall clock is passed in, and only decides when to
/// stop waiting for a silent client. Thread: one at a time.
///
/// With declared roles, time begins when all of them are present, and stops while one is absent. It
/// never falls back to the wall clock. Without declared roles, every client that joins paces.
///
/// Roles of robots that the present scene lacks are not waited for. While it has none of the
/// declared ones, time waits for any clients, and every one that joins paces.
///
/// Members whose time has come in the same step are notified in order: feeds first, then clients by
/// endpoint. Each client is notified when the one before it has made its next request, so messages
/// between clients are ordered, too.
class TimeBarrier {
 public:
  using Steps = std::uint64_t;

  struct Options {
    std::vector<std::string>
        declared;  ///< roles, one for each place; none = every client that joins
    std::chrono::nanoseconds grace{};  ///< silence after which a client is excluded; 0 = never
  };

  explicit TimeBarrier(Options options);

  /// Whether the role is declared.
  [[nodiscard]] bool is_registered(const std::string& role) const;
  /// nullopt when pacers are declared and this client has no place among them.
  [[nodiscard]] std::optional<api::PacerId> join(api::PacerRole role, WallTime now);
  /// The member waits until `steps` have been taken. 0, for feeds only: until cut().
  void request_until(api::PacerId id, Steps steps);
  /// Marks the present request as its last one; no other client is excluded for its sake.
  void finish(api::PacerId id);
  void leave(api::PacerId id, WallTime now);
  /// Time does not wait for its place once it has left, until another client takes the place.
  void exclude(api::PacerId id);
  /// The request of a feed is met now.
  void cut(api::PacerId id);

  /// Whether clients pace; else the wall clock does.
  [[nodiscard]] bool paced() const;
  /// Steps that may be taken now; 0 = time waits for a member. Only while paced().
  [[nodiscard]] Steps due() const;
  void step() { ++now_; }
  /// The robots of the present scene, by which declared roles count or not.
  void set_robots(const std::vector<std::string>& robots, WallTime now);
  /// Members whose time has come. Time waits for their next requests.
  [[nodiscard]] std::vector<api::PacerId> take_reached(WallTime now);
  /// All waiting clients: the cell is paused, and no client shall wait for it.
  [[nodiscard]] std::vector<api::PacerId> release_clients(WallTime now);
  /// Excludes clients that have been silent for longer than the grace time; with declared pacers
  /// only while another client waits.
  void expire(WallTime now);

  /// Endpoints whose commands wait until time goes on.
  [[nodiscard]] std::vector<api::EndpointId> endpoints() const;
  [[nodiscard]] api::VirtualTimeState state(WallTime now) const;
  [[nodiscard]] Steps now() const { return now_; }

 private:
  struct Member {
    api::PacerId id = 0;
    api::PacerRole role;
    bool waiting = false;   ///< for its request to be met
    Steps until = 0;        ///< while waiting: the step of its request
    WallTime since{};       ///< when it was last answered
    bool absent = false;    ///< excluded
    bool finished = false;  ///< its present request is the last
  };
  struct Place {
    std::string role;
    api::PacerId taken_by = 0;  ///< 0 = nobody
    WallTime free_since{};
    bool given_up = false;
    bool suspended = false;  ///< its robot is not in the present scene
  };

  [[nodiscard]] Member* find(api::PacerId id);
  /// Whether the present scene has a declared role.
  [[nodiscard]] bool has_declared() const;
  /// Whether time waits for the member's requests: a client without one of the declared places
  /// does not pace.
  [[nodiscard]] bool paces(const Member& member) const;
  [[nodiscard]] bool feed_is_busy() const;
  [[nodiscard]] bool client_waits() const;
  [[nodiscard]] bool client_thinks() const;
  void begin_if_complete(WallTime now);
  /// After any change of the members.
  void record_fallback();

  static bool is_client(const Member& member) {
    return member.role.kind == api::PacerKind::kClient;
  }

  std::chrono::nanoseconds grace_;
  std::vector<Place> places_;    ///< empty = not declared
  std::vector<Member> members_;  ///< by kind and endpoint
  Steps now_ = 0;
  api::PacerId last_id_ = 0;
  std::optional<WallTime> begun_;  ///< when all declared pacers were present
  bool was_paced_ = true;
  std::uint64_t expired_ = 0, fallbacks_ = 0;
};

}  // namespace aprsim::world
