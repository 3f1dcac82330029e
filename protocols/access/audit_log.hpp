#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "world/api/ports/ports.hpp"
#include "world/base/result.hpp"

namespace aprsim::protocols {

/// A command and its sender.
struct AuditRecord {
  std::string wire;      ///< listener, "grpc", "web", "modbus" or "crcl.ROBOT"
  std::string peer;      ///< address and port
  std::string identity;  ///< "token NAME", "certificate SUBJECT", or "no credentials"
  std::string command;   ///< method, kind of request or type of document
  std::string request;   ///< its content, cut to AuditLog::kMaxRequest
  std::string outcome;   ///< "ok" or the error; empty = not known yet
  std::chrono::system_clock::time_point time = std::chrono::system_clock::now();
};

struct AuditStats {
  std::uint64_t records = 0;  ///< written
  std::uint64_t lost = 0;     ///< too many waited, or the file could not be written
};

/// A file of commands, one JSON object per line, written by a thread of its own. write() never
/// blocks: commands that find no room are counted, and the next line reports how many were lost.
/// Thread: any.
class AuditLog {
 public:
  static constexpr std::size_t kMaxRequest = 4096;                  ///< bytes of one request
  static constexpr std::size_t kMaxWaiting = std::size_t{4} << 20;  ///< bytes of all waiting lines

  /// Opens the file for appending; a new file is readable for its owner only. Errors name it.
  /// The source outlives the log.
  [[nodiscard]] static Result<std::unique_ptr<AuditLog>> open(const std::string& path,
                                                              const api::SnapshotSource& source);
  ~AuditLog();
  AuditLog(const AuditLog&) = delete;
  AuditLog& operator=(const AuditLog&) = delete;

  void write(const AuditRecord& record);
  /// Reopens the path, after the file was moved away. After an error the old file stays open.
  [[nodiscard]] Result<void> reopen();
  [[nodiscard]] AuditStats stats() const;

 private:
  AuditLog(std::string path, int fd, const api::SnapshotSource& source);
  void run();
  [[nodiscard]] bool append(int fd, const std::string& line) const;

  const std::string path_;
  const api::SnapshotSource& source_;
  mutable std::mutex mutex_;  // of all below
  std::condition_variable changed_;
  std::deque<std::string> waiting_;
  std::size_t waiting_bytes_ = 0;
  int fd_;
  AuditStats stats_;
  std::uint64_t reported_ = 0;  // lost commands that were reported
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace aprsim::protocols
