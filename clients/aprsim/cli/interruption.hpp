#pragma once

#include <chrono>

/// Interruption of a client that moves machines: motion is stopped before the program exits.
/// requested() cancels calls of the client library. The signals are SIGINT, SIGTERM, SIGHUP, and
/// SIGPIPE (the reader of the output is gone).
namespace aprsim::client::interruption {

/// The exit code that a shell reports after Ctrl-C.
inline constexpr int kExitCode = 130;

/// Installs the handlers; an ignored SIGHUP stays ignored (nohup). Outside a Hold a signal ends
/// the process at once. Call once, before other threads start.
void install();

/// While one exists, the first signal only sets requested(); a second one ends the process at once.
class Hold {
 public:
  Hold();
  ~Hold();
  Hold(const Hold&) = delete;
  Hold& operator=(const Hold&) = delete;
};

/// While one exists, requested() is false and waits are not cut short: for cleaning up after an
/// interruption.
class Cleanup {
 public:
  Cleanup();
  ~Cleanup();
  Cleanup(const Cleanup&) = delete;
  Cleanup& operator=(const Cleanup&) = delete;
};

/// Whether a signal has arrived that was not handled yet.
[[nodiscard]] bool requested();
/// Whether any signal has arrived.
[[nodiscard]] bool happened();

/// Sleeps, but not beyond requested().
void sleep_until(std::chrono::steady_clock::time_point time);

/// Ends an interrupted process after its clean-up. After SIGINT it kills itself with SIGINT, so
/// that a shell ends its loop, too; otherwise it returns the exit code.
[[nodiscard]] int exit_process();

}  // namespace aprsim::client::interruption
