#pragma once

#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "protocols/ports/program_runner.hpp"

namespace aprsim::server {

/// A program that can be started.
struct Program {
  web::ProgramOffer offer;
  std::vector<std::string> command;
  std::string seed_option;  ///< option for a seed; empty = none
};

struct ProgramsOptions {
  std::vector<Program> programs;
  /// Runs the scenario whose file and options follow; empty = none can be run.
  std::vector<std::string> scenario_command;
  std::string directory;  ///< private, for files of scenarios that pages send
  std::string refusal;    ///< why pages may neither start nor stop programs; empty = they may
  std::map<std::string, std::string> environment;  ///< in addition to the daemon's
  /// Time from SIGTERM to SIGKILL; `last_patience` while the daemon is stopping.
  std::chrono::milliseconds patience{20'000}, last_patience{1'000};
};

/// Programs of a fixed list as child processes, one at a time, each in its own process group. A
/// thread starts them and reads their output. Pipes slow down a program that writes too much; the
/// log gets a limited part of output that is not for pages. Thread: any.
class Programs final : public web::ProgramRunner {
 public:
  explicit Programs(ProgramsOptions options);
  /// Ends the running program.
  ~Programs() override;

  /// As start(), regardless of the permissions of pages.
  [[nodiscard]] Result<void> launch(const std::string& name, std::optional<std::uint64_t> seed);
  /// From now on these can be started, of another scene. A running program goes on.
  void offer(std::vector<Program> programs);

  [[nodiscard]] Result<void> start(const std::string& name,
                                   std::optional<std::uint64_t> seed) override;
  /// Errors, further: kFailedPrecondition where no scenario can be run; the file cannot be written.
  [[nodiscard]] Result<void> start_scenario(const std::string& name, const std::string& text,
                                            std::optional<std::uint64_t> seed) override;
  [[nodiscard]] Result<void> stop() override;
  [[nodiscard]] std::shared_ptr<const web::ProgramStatus> status() const override;

  /// Terminates the running program and accepts no more; the destructor waits for it.
  void close();

 private:
  struct Child;
  struct Start {
    std::vector<std::string> command;
    std::string file = {};  ///< removed at the end; empty = none
  };
  void run();
  void serve(Child& child);
  void publish(web::ProgramStatus status);
  void write_offers(web::ProgramStatus& status) const;
  [[nodiscard]] Result<void> check_free() const;
  void begin(const std::string& name, Start start);
  [[nodiscard]] const Program* find(const std::string& name) const;

  const ProgramsOptions options_;
  mutable std::mutex mutex_;  // of what follows
  std::vector<Program> programs_;
  std::condition_variable changed_;
  std::shared_ptr<const web::ProgramStatus> status_;
  std::optional<Start> wanted_;  // to be started
  bool busy_ = false, stop_wanted_ = false, closed_ = false;
  std::jthread thread_;  // last: it uses all of the above
};

/// Name of the kitting controller.
inline constexpr const char* kDemo = "demo";

/// The command that runs a scenario in the cell, without the scenario's name.
[[nodiscard]] std::vector<std::string> scenario_command(const std::string& host,
                                                        const std::string& ports_file);

/// Programs for a cell with this scene (name or file): the kitting controller, if it knows the
/// cell, and the shipped scenarios of the cell. They connect to `host` and the ports of the file.
[[nodiscard]] std::vector<Program> known_programs(const std::string& scene, const std::string& host,
                                                  const std::string& ports_file);

}  // namespace aprsim::server
