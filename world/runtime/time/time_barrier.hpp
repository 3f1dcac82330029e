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

/// Who paces virtual time, and how far it may go. Counts steps from the start, over all resets; the
/// wall clock is passed in, and decides only who is given up as silent. Thread: one at a time.
///
/// With declared roles time begins when all of them are there, stands while one is away, and never
/// falls back to the wall clock. Without, whoever joins paces. Of what is reached in one step,
/// feeds come first; then clients, one at a time and by endpoint, each when the one before has
/// asked again: so what they tell each other besides is in an order, too.
class TimeBarrier {
 public:
  using Steps = std::uint64_t;

  struct Options {
    std::vector<std::string> declared;  ///< roles, one for each place; none = whoever joins
    std::chrono::nanoseconds grace{};   ///< of silence before a client is left behind; 0 = never
  };

  explicit TimeBarrier(Options options);

  [[nodiscard]] bool declares(const std::string& role) const;
  /// Nothing when pacers are declared and this client has no place among them.
  [[nodiscard]] std::optional<api::PacerId> join(api::PacerRole role, WallTime now);
  /// `steps` 0 is for feeds: until cut().
  void ask(api::PacerId id, Steps steps);
  /// It asks for the last time; nobody is left behind for its sake.
  void finish(api::PacerId id);
  void leave(api::PacerId id, WallTime now);
  /// Its place is not waited for once it has left, until somebody takes it.
  void shut_out(api::PacerId id);
  /// What a feed has asked for is reached now.
  void cut(api::PacerId id);

  /// Whether clients pace; else the wall clock does.
  [[nodiscard]] bool paced() const;
  /// Steps that may be taken now; 0 = time stands. Only while paced().
  [[nodiscard]] Steps due() const;
  void step() { ++now_; }
  /// Those whose time has come. They stand here until they ask again.
  [[nodiscard]] std::vector<api::PacerId> take_reached(WallTime now);
  /// All clients that have asked, whatever for: the cell is paused, and nobody shall wait for it.
  [[nodiscard]] std::vector<api::PacerId> release_clients(WallTime now);
  /// Leaves behind who has been silent for longer than the grace time; those before whom others
  /// wait, where pacers are declared.
  void expire(WallTime now);

  /// Endpoints whose commands wait until time goes on.
  [[nodiscard]] std::vector<api::EndpointId> endpoints() const;
  [[nodiscard]] api::VirtualTimeState state(WallTime now) const;
  [[nodiscard]] Steps now() const { return now_; }

 private:
  struct Member {
    api::PacerId id = 0;
    api::PacerRole role;
    bool asking = false;
    Steps until = 0;        ///< while asking
    WallTime since{};       ///< when it was last answered
    bool absent = false;    ///< left behind
    bool finished = false;  ///< it asks for the last time
  };
  struct Place {
    std::string role;
    api::PacerId taken_by = 0;  ///< 0 = nobody
    WallTime free_since{};
    bool given_up = false;
  };

  [[nodiscard]] Member* find(api::PacerId id);
  [[nodiscard]] bool feed_at_work() const;
  [[nodiscard]] bool client_waits() const;
  [[nodiscard]] bool client_thinks() const;
  void begin_if_complete(WallTime now);
  /// After any change of who is there.
  void note_fallback();

  static bool is_client(const Member& member) {
    return member.role.kind == api::PacerKind::kClient;
  }

  std::chrono::nanoseconds grace_;
  std::vector<Place> places_;    ///< empty = not declared
  std::vector<Member> members_;  ///< by kind and endpoint
  Steps now_ = 0;
  api::PacerId last_id_ = 0;
  std::optional<WallTime> begun_;  ///< since when all declared are there
  bool was_paced_ = true;
  std::uint64_t expired_ = 0, fallbacks_ = 0;
};

}  // namespace aprsim::world
