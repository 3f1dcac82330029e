#include "clients/ros2/simulation_services.hpp"

#include <chrono>
#include <utility>

#include "clients/ros2/dds/simulation_server.hpp"
#include "clients/ros2/dds/steps_server.hpp"
#include "clients/ros2/simulation/simulation.hpp"

namespace aprsim::ros2 {
namespace {

constexpr std::chrono::milliseconds kServicePeriod{100};  // replies may wait for their readers

bool is_same_daemon(const client::Endpoints& a, const client::Endpoints& b) {
  return a.host == b.host && a.grpc == b.grpc && a.token == b.token;
}

}  // namespace

SimulationServices::SimulationServices(Node& node, std::string ros_namespace)
    : node_(node),
      namespace_(ros_namespace == "/" ? "" : std::move(ros_namespace)),
      wakeup_(node),
      thread_([this] { run(); }) {}

SimulationServices::~SimulationServices() {
  stopping_ = true;
  wakeup_.notify();
  thread_.join();
}

void SimulationServices::set_daemon(const client::Endpoints& daemon) {
  const std::lock_guard lock(mutex_);
  daemon_ = daemon;
}

void SimulationServices::set_time(const google::protobuf::Duration& time) {
  const std::lock_guard lock(mutex_);
  now_ = time;
}

void SimulationServices::disconnect() {
  const std::lock_guard lock(mutex_);
  daemon_.reset();
}

void SimulationServices::check() {
  const std::lock_guard lock(mutex_);
  if (error_) std::rethrow_exception(error_);
}

void SimulationServices::run() {
  try {
    work();
  } catch (const std::exception&) {
    const std::lock_guard lock(mutex_);
    error_ = std::current_exception();
  }
}

void SimulationServices::work() {
  SimulationServer server(node_, namespace_, wakeup_);
  StepsServer steps(node_, namespace_, wakeup_);
  node_.announce();
  std::optional<client::Endpoints> used;
  std::unique_ptr<Simulation> simulation;
  while (!stopping_) {
    wakeup_.wait(steps.is_active() ? std::chrono::milliseconds{0} : kServicePeriod);
    std::optional<client::Endpoints> daemon;
    google::protobuf::Duration now;
    {
      const std::lock_guard lock(mutex_);
      daemon = daemon_;
      now = now_;
    }
    if (!daemon) {
      simulation.reset();
    } else if (!simulation || !is_same_daemon(*used, *daemon)) {
      simulation = std::make_unique<Simulation>(*daemon, [this] { return stopping_.load(); });
      used = daemon;
    }
    server.serve(simulation.get());
    steps.serve(simulation.get(), now);
  }
}

}  // namespace aprsim::ros2
