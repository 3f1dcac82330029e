#include "server/listeners/modbus_listeners.hpp"

#include <algorithm>
#include <thread>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>

namespace aprsim::server {

ModbusListeners::ModbusListeners(api::CommandSink& sink, const api::SnapshotSource& source,
                                 MakeOptions make_options)
    : sink_(sink), source_(source), make_options_(std::move(make_options)) {}

ModbusListeners::~ModbusListeners() { stop(); }

Result<void> ModbusListeners::start() {
  const std::lock_guard updating(update_mutex_);
  followed_ = source_.latest()->cell;
  return open_missing(true);
}

void ModbusListeners::update() {
  const std::lock_guard updating(update_mutex_);
  const auto cell = source_.latest()->cell;
  if (stopped_ || cell == followed_) return;
  followed_ = cell;
  // Their ports are free before others listen there.
  close_gone();
  static_cast<void>(open_missing(false));
}

Result<void> ModbusListeners::open_missing(bool ends_on_error) {
  const auto& maps = followed_->modbus_servers;
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const std::string& name = maps[i].name;
    if (listeners_.contains(name)) continue;
    Listener listener{
        std::make_unique<modbus_server::ModbusServer>(make_options_(i, name), sink_, source_), 0};
    const auto port = listener.server->start();
    if (!port && ends_on_error) {
      Error error = port.error();
      error.field = name;
      return tl::unexpected(std::move(error));
    }
    if (!port) {
      spdlog::error("modbus.{}: {}", name, port.error().message);
      continue;
    }
    listener.port = *port;
    const std::lock_guard lock(mutex_);
    listeners_[name] = std::move(listener);
  }
  return {};
}

void ModbusListeners::close_gone() {
  const auto& maps = followed_->modbus_servers;
  std::vector<Listener> gone;
  {
    const std::lock_guard lock(mutex_);
    for (auto& [name, listener] : listeners_) {
      const bool stays = std::ranges::find(maps, name, &api::RegisterMap::name) != maps.end();
      if (!stays) gone.push_back(std::move(listener));
    }
    std::erase_if(listeners_, [](const auto& entry) { return !entry.second.server; });
  }
  for (const Listener& listener : gone) listener.server->stop();
}

void ModbusListeners::stop() {
  const std::lock_guard updating(update_mutex_);
  stopped_ = true;
  std::vector<std::jthread> ending;
  for (auto& [name, listener] : listeners_) {
    ending.emplace_back([&server = *listener.server] { server.stop(); });
  }
}

std::map<std::string, std::uint16_t> ModbusListeners::ports() const {
  const std::lock_guard lock(mutex_);
  std::map<std::string, std::uint16_t> ports;
  for (const auto& [name, listener] : listeners_) ports[name] = listener.port;
  return ports;
}

std::map<std::string, modbus_server::ModbusServerStats> ModbusListeners::stats() const {
  const std::lock_guard lock(mutex_);
  std::map<std::string, modbus_server::ModbusServerStats> all;
  for (const auto& [name, listener] : listeners_) all[name] = listener.server->stats();
  return all;
}

}  // namespace aprsim::server
