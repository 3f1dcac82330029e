#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "clients/aprsim/conform/check.hpp"
#include "clients/wires/tcp_socket.hpp"
#include "crcl/commands.hpp"
#include "crcl/framer.hpp"
#include "crcl/status.hpp"

namespace aprsim::client::conform {

using Milliseconds = std::chrono::milliseconds;

/// A status as it came.
struct SeenStatus {
  std::string document;
  crcl::Status status;
};

/// One connection to a CRCL server, for checks: throws NotKept where the server does not do what
/// every check needs.
class CrclProbe {
 public:
  static constexpr Milliseconds kAnswer{3000};

  explicit CrclProbe(const Target& target);

  /// An id that no check has used yet.
  [[nodiscard]] static std::int64_t next_id();

  void send(std::string_view bytes);
  /// Sends a command and returns its id.
  std::int64_t send(const crcl::CommandBody& body, std::int64_t id = next_id());

  /// The next status that comes.
  [[nodiscard]] SeenStatus read(Milliseconds time = kAnswer);
  /// Asks for one and reads it.
  SeenStatus poll(Milliseconds time = kAnswer);
  /// Polls until the command is over: done or in error.
  SeenStatus wait_over(std::int64_t id, Milliseconds time);
  /// Polls until the robot is in error, or that command is done after all.
  SeenStatus wait_error(std::optional<std::int64_t> id, Milliseconds time);
  /// Sends a command and waits until it is done; another end is not kept.
  SeenStatus run(const crcl::CommandBody& body, Milliseconds time = kAnswer);
  /// A session without an error, whatever was before.
  void init();

  /// Whether nothing comes for so long.
  [[nodiscard]] bool silent(Milliseconds time);
  /// Whether the server ends the connection in time.
  [[nodiscard]] bool closed(Milliseconds time);

 private:
  /// Polls until `met`.
  template <typename Met>
  SeenStatus wait(Milliseconds time, const Met& met);

  TcpSocket socket_;
  crcl::Framer framer_ = crcl::Framer::for_statuses();
};

/// A CRCLCommandInstance of that xsi:type.
[[nodiscard]] std::string command_document(std::string_view type, std::int64_t id,
                                           std::string_view elements = "");
[[nodiscard]] std::string get_status_document();

/// Throws NotKept unless the command is in that state.
void expect_state(const SeenStatus& seen, crcl::CommandState state);

/// Reaction to a command that no server may execute.
struct Refusal {
  CrclProbe other;   ///< another connection, which has seen the error; the robot is still in it
  std::string seen;  ///< in words
};
/// Sends such a command, and expects an error with a description that other connections see, in a
/// valid status: under the command's id, or any when it has none, or the connection is closed.
[[nodiscard]] Refusal refuse(const Target& target, const std::string& document,
                             std::optional<std::int64_t> id);
/// The same, and a session without the error afterwards. Returns the observation in words.
[[nodiscard]] std::string refused(const Target& target, const std::string& document,
                                  std::optional<std::int64_t> id);

/// "CRCL_Done of 7", with the description if there is one.
[[nodiscard]] std::string in_words(const crcl::Status& status);

}  // namespace aprsim::client::conform
