#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "protocols/web/viewer/viewer.hpp"

namespace aprsim::web {

/// The open viewers, by id, and the limit of what waits for them. Thread: the server's.
class Viewers {
 public:
  /// `max_waiting_bytes`: of the messages that wait for all viewers together.
  explicit Viewers(std::size_t max_waiting_bytes) : max_waiting_bytes_(max_waiting_bytes) {}

  void add(std::shared_ptr<Viewer> viewer) {
    const std::uint64_t id = viewer->id();
    all_[id] = std::move(viewer);
  }
  void remove(const Viewer& viewer) { all_.erase(viewer.id()); }
  [[nodiscard]] std::size_t size() const { return all_.size(); }
  /// Null = it has ended. Keep the pointer: a write may end and remove the viewer.
  [[nodiscard]] std::shared_ptr<Viewer> find(std::uint64_t id) const {
    const auto found = all_.find(id);
    return found == all_.end() ? nullptr : found->second;
  }
  /// Copy of the list, since viewers may end during a loop over it.
  [[nodiscard]] std::vector<std::shared_ptr<Viewer>> all() const {
    std::vector<std::shared_ptr<Viewer>> all;
    all.reserve(all_.size());
    for (const auto& [id, viewer] : all_) all.push_back(viewer);
    return all;
  }
  /// Closes the viewers with most waiting bytes until the others keep the limit.
  void limit_waiting();

 private:
  const std::size_t max_waiting_bytes_;
  std::map<std::uint64_t, std::shared_ptr<Viewer>> all_;
};

}  // namespace aprsim::web
