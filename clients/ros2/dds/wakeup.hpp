#pragma once

#include <chrono>

#include "clients/ros2/dds/node.hpp"

namespace aprsim::ros2 {

/// Lets a thread sleep until a request comes or another thread has something for it.
class Wakeup {
 public:
  explicit Wakeup(const Node& node);
  ~Wakeup();
  Wakeup(const Wakeup&) = delete;
  Wakeup& operator=(const Wakeup&) = delete;

  /// Samples of this reader wake the thread, until the reader is removed.
  void attach(dds_entity_t reader) const;
  /// Wakes the thread. Thread: any.
  void notify() const;
  /// Returns after a sample, after notify(), or after that time.
  void wait(std::chrono::milliseconds longest) const;

 private:
  dds_entity_t waitset_;
  dds_entity_t guard_;
};

}  // namespace aprsim::ros2
