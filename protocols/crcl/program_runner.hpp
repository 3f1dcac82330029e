#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "crcl/documents.hpp"
#include "protocols/crcl/command_history.hpp"
#include "protocols/crcl/connection_settings.hpp"
#include "world/base/result.hpp"

namespace aprsim::crcl_server {

/// An uploaded program that runs: its commands in order, how each of them shows in a status, which
/// is next and what the one before waits for.
class ProgramRunner {
 public:
  /// A CRCLProgram document: its commands under their own ids. The caller's socket may close
  /// meanwhile. Errors: loops without counterpart or without bound.
  [[nodiscard]] static Result<ProgramRunner> of_document(crcl::Program program, Caller caller);
  /// The text of the RunProgram command with that id: all under the id, without the program's own
  /// InitCanon and EndCanon, since the session is the caller's.
  [[nodiscard]] static Result<ProgramRunner> of_command(crcl::Program program, std::int64_t id,
                                                        Caller caller);

  [[nodiscard]] bool finished() const { return next_ >= order_.size(); }
  /// The next command, with its place in the program; only while not finished().
  [[nodiscard]] crcl::CommandInstance next();

  [[nodiscard]] const Caller& caller() const { return caller_; }

  /// Submission of the command under way; nothing once it is done.
  [[nodiscard]] const std::optional<Submission>& pending() const { return pending_; }
  void wait_for(std::optional<Submission> pending) { pending_ = pending; }

 private:
  ProgramRunner() = default;

  crcl::Program program_;
  std::vector<std::size_t> order_;  // indices into the program
  std::size_t next_ = 0;
  std::string file_;
  std::optional<std::int64_t> fixed_id_;
  Caller caller_;
  std::optional<Submission> pending_;
};

}  // namespace aprsim::crcl_server
