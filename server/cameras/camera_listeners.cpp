#include "server/cameras/camera_listeners.hpp"

#include <algorithm>
#include <thread>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>

namespace aprsim::server {

using camera_server::CameraServerOptions;

CameraListeners::CameraListeners(protocols::CameraPictures& pictures, MakeOptions make_options)
    : pictures_(pictures), make_options_(std::move(make_options)) {}

CameraListeners::~CameraListeners() { stop(); }

Result<CameraListeners::Listener> CameraListeners::open(const CameraServerOptions& options) const {
  Listener listener{std::make_unique<camera_server::CameraServer>(options, pictures_),
                    options.listener.address, options.listener.port, 0};
  const auto port = listener.server->start();
  if (!port) {
    Error error = port.error();
    error.field = options.camera;
    return tl::unexpected(std::move(error));
  }
  listener.port = *port;
  return listener;
}

Result<void> CameraListeners::start() {
  const std::lock_guard updating(update_mutex_);
  followed_ = pictures_.cameras();
  for (std::size_t i = 0; i < followed_->size(); ++i) {
    const std::string& name = (*followed_)[i].name;
    auto listener = open(make_options_(i, name));
    if (!listener) return tl::unexpected(std::move(listener.error()));
    const std::lock_guard lock(mutex_);
    listeners_[name] = *std::move(listener);
  }
  return {};
}

bool CameraListeners::update() {
  const std::lock_guard updating(update_mutex_);
  const auto cameras = pictures_.cameras();
  if (stopped_ || cameras == followed_) return false;
  followed_ = cameras;
  std::map<std::string, CameraServerOptions> wanted;
  for (std::size_t i = 0; i < cameras->size(); ++i) {
    wanted[(*cameras)[i].name] = make_options_(i, (*cameras)[i].name);
  }
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
  // Their ports are free before others listen there.
  for (const Listener& listener : gone) listener.server->stop();
  bool changed = !gone.empty();
  for (const auto& [name, options] : wanted) {
    if (listeners_.contains(name)) continue;
    auto listener = open(options);
    if (!listener) {
      spdlog::error("camera.{}: {}", name, listener.error().message);
      continue;
    }
    changed = true;
    const std::lock_guard lock(mutex_);
    listeners_[name] = *std::move(listener);
  }
  return changed;
}

void CameraListeners::stop() {
  const std::lock_guard updating(update_mutex_);
  stopped_ = true;
  std::vector<std::jthread> ending;
  for (auto& [name, listener] : listeners_) {
    ending.emplace_back([&server = *listener.server] { server.stop(); });
  }
}

CameraListeners::Ports CameraListeners::ports() const {
  const std::lock_guard lock(mutex_);
  Ports ports;
  for (const auto& [name, listener] : listeners_) ports[name] = listener.port;
  return ports;
}

std::map<std::string, camera_server::CameraServerStats> CameraListeners::stats() const {
  const std::lock_guard lock(mutex_);
  std::map<std::string, camera_server::CameraServerStats> all;
  for (const auto& [name, listener] : listeners_) all[name] = listener.server->stats();
  return all;
}

}  // namespace aprsim::server
