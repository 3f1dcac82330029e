#pragma once

#include <chrono>

/// Ctrl-C and its like for a client that sets machines in motion: what moves is stopped before the
/// program leaves. Calls of the client library are cancelled by noted(). The signals are SIGINT,
/// SIGTERM, SIGHUP, and SIGPIPE (nobody reads the output any more).
namespace aprsim::client::interruption {

/// The exit code that a shell shows for a program that Ctrl-C ended.
inline constexpr int kExitCode = 130;

/// Takes the signals over; SIGHUP stays ignored where it is (nohup). Outside a Hold each ends the
/// process at once. Once, before there are other threads.
void install();

/// While one lives, the first signal is only noted; a second one ends the process at once.
class Hold {
 public:
  Hold();
  ~Hold();
  Hold(const Hold&) = delete;
  Hold& operator=(const Hold&) = delete;
};

/// While one lives, noted() is false and waits last as long as they should: for what is still to be
/// done after an interruption.
class Cleanup {
 public:
  Cleanup();
  ~Cleanup();
  Cleanup(const Cleanup&) = delete;
  Cleanup& operator=(const Cleanup&) = delete;
};

/// Whether a signal has come that nothing has been done about yet.
[[nodiscard]] bool noted();
/// Whether one has come at all.
[[nodiscard]] bool happened();

/// Sleeps, at most until noted().
void sleep_until(std::chrono::steady_clock::time_point time);

/// The end of a process that was interrupted, after its cleaning up. One interrupted by SIGINT dies
/// of it, as its shell must see to end a loop around it too; otherwise returns the exit code.
[[nodiscard]] int leave();

}  // namespace aprsim::client::interruption
