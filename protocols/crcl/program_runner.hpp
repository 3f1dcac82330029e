#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "crcl/documents.hpp"
#include "protocols/crcl/connection_settings.hpp"
#include "world/api/error.hpp"
#include "world/api/robot_command.hpp"

namespace aprsim::protocols {

/// An uploaded program on its way: which command is next, and how each of them shows in a status.
class ProgramRunner {
 public:
  /// A CRCLProgram document: its commands under their own ids. `settings` are those of the socket
  /// that sent it, which may close meanwhile. Errors: loops without counterpart or without bound.
  [[nodiscard]] static Result<ProgramRunner> of_document(
      crcl::Program program, std::shared_ptr<ConnectionSettings> settings, std::string peer);
  /// The text of a RunProgram command: all under that command's id, without the program's own
  /// InitCanon and EndCanon, since the session is the caller's.
  [[nodiscard]] static Result<ProgramRunner> of_command(
      crcl::Program program, const crcl::CommandInstance& command,
      std::shared_ptr<ConnectionSettings> settings, std::string peer);

  [[nodiscard]] bool finished() const { return next_ >= order_.size(); }
  /// The next command, with its place in the program; only while not finished().
  [[nodiscard]] crcl::CommandInstance take();

  [[nodiscard]] const std::shared_ptr<ConnectionSettings>& settings() const { return settings_; }
  [[nodiscard]] const std::string& peer() const { return peer_; }

  /// How the command that runs is followed.
  struct Step {
    api::Ticket ticket = 0;  // 0: done at once
    bool setting = false;
  };
  Step step;

 private:
  ProgramRunner() = default;

  crcl::Program program_;
  std::vector<std::size_t> order_;  // indices into the program
  std::size_t next_ = 0;
  std::string file_;
  std::optional<std::int64_t> fixed_id_;
  std::shared_ptr<ConnectionSettings> settings_;
  std::string peer_;
};

}  // namespace aprsim::protocols
