#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>

#include "world/base/result.hpp"

namespace aprsim::server {

/// The listeners that the present scene describes, by name. Where another scene is loaded, they
/// open and close; one of the same name at the same address and port stays. `Options` have a
/// `listener` with both.
template <typename Server, typename Options>
class SceneListeners {
 public:
  using Wanted = std::map<std::string, Options>;
  using Stats = decltype(std::declval<const Server&>().stats());

  struct Source {
    std::string kind;                                    ///< before the names in the log
    std::function<std::shared_ptr<const void>()> scene;  ///< changes with the scene
    std::function<Wanted()> wanted;                      ///< of the present scene
    std::function<std::unique_ptr<Server>(const Options&)> make;
  };

  explicit SceneListeners(Source source) : source_(std::move(source)) {}
  ~SceneListeners() { stop(); }
  SceneListeners(const SceneListeners&) = delete;
  SceneListeners& operator=(const SceneListeners&) = delete;

  /// Opens those of the present scene. Error: that of the first that cannot listen; its field is
  /// the listener's name. Once only.
  [[nodiscard]] Result<void> start() {
    const std::lock_guard updating(update_mutex_);
    followed_ = source_.scene();
    for (const auto& [name, options] : source_.wanted()) {
      if (auto opened = open(name, options); !opened) return opened;
    }
    return {};
  }

  /// Follows the present scene. One that cannot listen is logged. Thread: one.
  void update() {
    const std::lock_guard updating(update_mutex_);
    const auto scene = source_.scene();
    if (stopped_ || scene == followed_) return;
    followed_ = scene;
    const Wanted wanted = source_.wanted();
    // Their ports are free before others listen there.
    close_others(wanted);
    for (const auto& [name, options] : wanted) {
      if (listeners_.contains(name)) continue;
      if (const auto opened = open(name, options); !opened) {
        spdlog::error("{}.{}: {}", source_.kind, name, opened.error().message);
      }
    }
  }

  /// Closes all, and every later update() does nothing. Thread: the owner's.
  void stop() {
    const std::lock_guard updating(update_mutex_);
    stopped_ = true;
    std::vector<std::jthread> ending;
    for (auto& [name, listener] : listeners_) {
      ending.emplace_back([&server = *listener.server] { server.stop(); });
    }
  }

  /// Thread: any.
  [[nodiscard]] std::map<std::string, std::uint16_t> ports() const {
    const std::lock_guard lock(mutex_);
    std::map<std::string, std::uint16_t> ports;
    for (const auto& [name, listener] : listeners_) ports[name] = listener.port;
    return ports;
  }
  [[nodiscard]] std::map<std::string, Stats> stats() const {
    const std::lock_guard lock(mutex_);
    std::map<std::string, Stats> all;
    for (const auto& [name, listener] : listeners_) all[name] = listener.server->stats();
    return all;
  }

 private:
  struct Listener {
    std::unique_ptr<Server> server;
    std::string address;
    std::uint16_t wanted = 0;  ///< port, 0 = any
    std::uint16_t port = 0;
  };

  [[nodiscard]] Result<void> open(const std::string& name, const Options& options) {
    Listener listener{source_.make(options), options.listener.address, options.listener.port, 0};
    const auto port = listener.server->start();
    if (!port) {
      Error error = port.error();
      error.field = name;
      return tl::unexpected(std::move(error));
    }
    listener.port = *port;
    const std::lock_guard lock(mutex_);
    listeners_[name] = std::move(listener);
    return {};
  }

  void close_others(const Wanted& wanted) {
    const auto stays = [&wanted](const auto& entry) {
      const auto found = wanted.find(entry.first);
      return found != wanted.end() && found->second.listener.port == entry.second.wanted &&
             found->second.listener.address == entry.second.address;
    };
    std::vector<Listener> gone;
    {
      const std::lock_guard lock(mutex_);
      for (auto& entry : listeners_) {
        if (!stays(entry)) gone.push_back(std::move(entry.second));
      }
      std::erase_if(listeners_, [](const auto& entry) { return !entry.second.server; });
    }
    for (const Listener& listener : gone) listener.server->stop();
  }

  const Source source_;
  std::mutex update_mutex_;  // of what follows
  bool stopped_ = false;
  std::shared_ptr<const void> followed_;
  mutable std::mutex mutex_;  // of the map; only those who hold both change it
  std::map<std::string, Listener> listeners_;
};

}  // namespace aprsim::server
