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

/// A program that may be started.
struct Program {
  web::ProgramOffer offer;
  std::vector<std::string> command;
  std::string seed_option;  ///< which a seed follows; empty = it takes none
};

struct ProgramsOptions {
  std::vector<Program> programs;
  std::string refusal;  ///< why pages may neither start nor stop any; empty = they may
  std::map<std::string, std::string> environment;  ///< besides our own
  /// For a program to end when it is told to, before it is killed; and when we end, too.
  std::chrono::milliseconds patience{20'000}, last_patience{1'000};
};

/// Programs of a fixed list as child processes, one at a time, each in a process group of its own,
/// with a thread that starts them and reads what they say: pipes hold a flood back, the log gets a
/// limited part of what is not for pages. Nothing waits for them, and their end harms nothing.
/// Thread: any.
class Programs final : public web::ProgramRunner {
 public:
  explicit Programs(ProgramsOptions options);
  /// Ends what runs.
  ~Programs() override;

  /// As start(), whatever pages may.
  [[nodiscard]] Result<void> launch(const std::string& name, std::optional<std::uint64_t> seed);

  [[nodiscard]] Result<void> start(const std::string& name,
                                   std::optional<std::uint64_t> seed) override;
  [[nodiscard]] Result<void> stop() override;
  [[nodiscard]] std::shared_ptr<const web::ProgramStatus> status() const override;

  /// Tells what runs to end and takes no more; the destructor waits for it.
  void close();

 private:
  struct Child;
  void run();
  void serve(Child& child);
  void publish(const web::ProgramStatus& status);
  [[nodiscard]] const Program* find(const std::string& name) const;

  ProgramsOptions options_;
  mutable std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  std::shared_ptr<const web::ProgramStatus> status_;
  std::optional<std::vector<std::string>> wanted_;  // to be started
  bool busy_ = false, stop_wanted_ = false, closed_ = false;
  std::jthread thread_;  // last: it uses all of the above
};

/// The kitting controller, as a program.
inline constexpr const char* kDemo = "demo";

/// Programs for a cell with this scene, a name or a file: the kitting controller, where
/// it knows the cell, and the shipped scenarios that can be run in it. They find the cell at `host`
/// and the ports of the file.
[[nodiscard]] std::vector<Program> known_programs(const std::string& scene, const std::string& host,
                                                  const std::string& ports_file);

}  // namespace aprsim::server
