#include "server/listeners/robot_listeners.hpp"

#include <algorithm>
#include <exception>
#include <iterator>
#include <thread>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "protocols/net/tcp_listener.hpp"
#include "server/listeners/endpoints.hpp"
#include "world/api/description/robot_identity.hpp"

namespace aprsim::server {
namespace {

/// Time between attempts to open listeners whose ports are in use.
constexpr std::chrono::seconds kRetryPeriod{1};

struct Wanted {
  std::string name;  ///< "crcl.fanuc"
  protocols::ListenerOptions options;
};

std::vector<Wanted> main_listeners(const std::string& robot, const RobotListenerOptions& options) {
  return {{"crcl." + robot, options.crcl.listener}, {"vision." + robot, options.vision.listener}};
}

std::vector<Wanted> message_listeners(const std::string& robot,
                                      const RobotListenerOptions& options) {
  std::vector<Wanted> all;
  if (!options.simple_message) return all;
  const auto add = [&](const char* role, std::uint16_t port) {
    all.push_back({role + ('.' + robot), options.simple_message->listener});
    all.back().options.port = port;
  };
  add("motion", options.simple_message->motion_port);
  add("state", options.simple_message->state_port);
  add("gripper", options.simple_message->gripper_port);
  return all;
}

bool same(const std::vector<Wanted>& a, const std::vector<Wanted>& b) {
  return std::ranges::equal(a, b, [](const Wanted& x, const Wanted& y) {
    return x.name == y.name && x.options.address == y.options.address &&
           x.options.port == y.options.port;
  });
}

bool same_main(const RobotListenerOptions& a, const RobotListenerOptions& b) {
  return same(main_listeners("", a), main_listeners("", b));
}

bool same_messages(const RobotListenerOptions& a, const RobotListenerOptions& b) {
  if (!same(message_listeners("", a), message_listeners("", b))) return false;
  if (!a.simple_message) return true;
  return a.simple_message->controller == b.simple_message->controller &&
         a.simple_message->joint_speed == b.simple_message->joint_speed &&
         a.simple_message->rounding == b.simple_message->rounding &&
         a.simple_message->interpolation_clock == b.simple_message->interpolation_clock;
}

tl::unexpected<Error> cannot_listen(const std::string& listener, Error error) {
  error.field = listener;
  return tl::unexpected<Error>(std::move(error));
}

/// Whether the snapshots show the robots of the scene: it is loaded shortly before.
bool shows(const api::CellDescription& cell, const scene::Scene& scene) {
  return std::ranges::equal(cell.robots, scene.robots, {}, &api::RobotDescription::name,
                            &scene::Robot::name);
}

}  // namespace

void RobotListeners::Robot::stop() const {
  std::vector<std::jthread> ending;
  ending.emplace_back([this] { crcl->stop(); });
  ending.emplace_back([this] { vision->stop(); });
  if (simple_message) ending.emplace_back([this] { simple_message->stop(); });
}

void RobotListeners::Robot::forget_messages(const std::string& name) {
  simple_message.reset();
  message_view.reset();
  options.simple_message.reset();
  for (const char* role : {"motion.", "state.", "gripper."}) ports.erase(role + name);
}

/// Each listener moves on its own thread, between two of its looks at the cell.
void RobotListeners::Robot::move_to(int place, const api::SnapshotPtr& now) {
  if (std::exchange(index, place) == place) return;
  const auto move = [place, now](const std::shared_ptr<RobotView>& view) {
    return [view, place, now] { view->move_to(place, now); };
  };
  crcl->set_robot(place, move(crcl_view));
  vision->set_robot(place, move(vision_view));
  if (simple_message) simple_message->set_robot(place, move(message_view));
}

Result<std::shared_ptr<RobotListeners::Robot>> RobotListeners::open(
    const scene::Scene& scene, std::size_t index, const api::SnapshotPtr& now) const {
  const std::string& name = scene.robots[index].name;
  auto robot = std::make_shared<Robot>();
  robot->options = source_.options(scene, index);
  robot->options.simple_message.reset();
  robot->description = now->cell->robots[index];
  robot->index = static_cast<int>(index);
  robot->number = free_number();
  robot->options.crcl.listener.endpoint = kFirstCrclEndpoint + robot->number;
  const auto view = [&] {
    return std::make_shared<RobotView>(source_.sink, source_.snapshots, now, robot->index);
  };
  robot->crcl_view = view();
  robot->crcl = std::make_shared<crcl_server::CrclServer>(robot->options.crcl, *robot->crcl_view,
                                                          *robot->crcl_view);
  robot->vision_view = view();
  robot->vision =
      std::make_shared<vision_server::VisionServer>(robot->options.vision, *robot->vision_view);
  auto port = robot->crcl->start();
  if (!port) return cannot_listen("crcl." + name, port.error());
  robot->ports["crcl." + name] = *port;
  port = robot->vision->start();
  if (!port) return cannot_listen("vision." + name, port.error());
  robot->ports["vision." + name] = *port;
  return robot;
}

Result<std::shared_ptr<RobotListeners::Robot>> RobotListeners::with_messages(
    const Robot& robot, const std::string& name, const scene::Scene& scene,
    const api::SnapshotPtr& now) const {
  auto more = std::make_shared<Robot>(robot);
  more->options.simple_message =
      source_.options(scene, static_cast<std::size_t>(robot.index)).simple_message;
  more->options.simple_message->listener.endpoint = kFirstSimpleMessageEndpoint + robot.number;
  more->message_view =
      std::make_shared<RobotView>(source_.sink, source_.snapshots, now, robot.index);
  more->simple_message = std::make_shared<simple_message::SimpleMessageServer>(
      *more->options.simple_message, *more->message_view, *more->message_view);
  const auto three = more->simple_message->start();
  if (!three) return cannot_listen(three.error().field + "." + name, three.error());
  more->ports["motion." + name] = three->motion;
  more->ports["state." + name] = three->state;
  more->ports["gripper." + name] = three->gripper;
  return more;
}

Result<void> RobotListeners::complete(const scene::Scene& scene, std::size_t index,
                                      const api::SnapshotPtr& now) try {
  const std::string& name = scene.robots[index].name;
  Robots present = robots();
  if (!present.contains(name)) {
    auto opened = open(scene, index, now);
    if (!opened) return tl::unexpected(opened.error());
    present[name] = *opened;
    replace(name, *std::move(opened));
  }
  const Robot& robot = *present[name];
  if (!scene.robots[index].simple_message || robot.simple_message) return {};
  auto more = with_messages(robot, name, scene, now);
  if (!more) return tl::unexpected(more.error());
  replace(name, *std::move(more));
  return {};
} catch (const std::exception& failure) {
  // As without memory; it is tried again.
  return fail(ErrorCode::kUnavailable, "crcl." + scene.robots[index].name, failure.what());
}

void RobotListeners::replace(const std::string& name, std::shared_ptr<Robot> robot) {
  const std::lock_guard lock(mutex_);
  robots_[name].swap(robot);
}

/// The lowest one that no open listener has: robots may have changed their places.
api::EndpointId RobotListeners::free_number() const {
  const Robots all = robots();
  api::EndpointId number = 0;
  while (std::ranges::any_of(
      all, [number](const auto& entry) { return entry.second->number == number; })) {
    ++number;
  }
  return number;
}

Result<void> RobotListeners::start() {
  const std::lock_guard updating(update_mutex_);
  const ScenePtr scene = source_.scene();
  const api::SnapshotPtr now = source_.snapshots.latest();
  for (std::size_t i = 0; i < scene->robots.size(); ++i) {
    if (auto opened = complete(*scene, i, now); !opened) return opened;
  }
  share_memory();
  followed_ = now->cell;
  return {};
}

Result<void> RobotListeners::check(const scene::Scene& next) const {
  std::map<std::string, RobotListenerOptions> wanted;
  for (std::size_t i = 0; i < next.robots.size(); ++i) {
    wanted[next.robots[i].name] = source_.options(next, i);
  }
  std::set<std::uint16_t> closing;
  std::set<std::string> staying;
  for (const auto& [name, robot] : robots()) {
    const auto found = wanted.find(name);
    const bool stays = found != wanted.end() && same_main(found->second, robot->options);
    const bool messages_stay = stays && same_messages(found->second, robot->options);
    for (const auto& [listener, port] : robot->ports) {
      const bool is_main = listener.starts_with("crcl.") || listener.starts_with("vision.");
      if (is_main ? stays : messages_stay) {
        staying.insert(listener);
      } else {
        closing.insert(port);
      }
    }
  }
  std::vector<Wanted> opening;
  for (const auto& [name, options] : wanted) {
    for (const auto& all : {main_listeners(name, options), message_listeners(name, options)}) {
      std::ranges::copy_if(all, std::back_inserter(opening), [&](const Wanted& listener) {
        return listener.options.port != 0 && !staying.contains(listener.name);
      });
    }
  }
  // All stay bound until the last one is, since two may want the same port.
  boost::asio::io_context io;
  std::vector<std::unique_ptr<protocols::TcpListener>> probes;
  std::map<std::pair<std::string, std::uint16_t>, std::string> to_be_freed;
  for (const Wanted& listener : opening) {
    if (closing.contains(listener.options.port)) {
      const auto [other, is_first] = to_be_freed.emplace(
          std::pair(listener.options.address, listener.options.port), listener.name);
      if (is_first) continue;
      return cannot_listen(
          listener.name,
          {ErrorCode::kUnavailable, "port",
           fmt::format("cannot listen on {} port {}: {} listens there", listener.options.address,
                       listener.options.port, other->second)});
    }
    probes.push_back(std::make_unique<protocols::TcpListener>(
        io, listener.name, listener.options,
        [](protocols::TcpListener::Socket, const std::string&, protocols::TcpListener::Slot) {}));
    if (const auto bound = probes.back()->listen(); !bound) {
      return cannot_listen(listener.name, bound.error());
    }
  }
  return {};
}

std::shared_ptr<const api::CellDescription> RobotListeners::update() {
  const std::lock_guard updating(update_mutex_);
  const api::SnapshotPtr now = source_.snapshots.latest();
  const bool retries = !missing_.empty() && Clock::now() >= retry_;
  if (stopped_ || (now->cell == followed_ && !retries)) return followed_;
  const ScenePtr scene = source_.scene();
  if (!shows(*now->cell, *scene)) return followed_;
  close_others(*scene, now);
  open_missing(*scene, now);
  share_memory();
  followed_ = now->cell;
  return followed_;
}

void RobotListeners::close_others(const scene::Scene& scene, const api::SnapshotPtr& now) {
  const api::CellDescription& cell = *now->cell;
  std::vector<std::function<void()>> gone;
  for (const auto& [name, robot] : robots()) {
    const auto index = api::robot_named(cell, name);
    const bool is_there = index && api::same_robot(cell.robots[*index], robot->description);
    const auto wanted = is_there ? source_.options(scene, *index) : RobotListenerOptions();
    if (is_there && same_main(wanted, robot->options)) {
      robot->move_to(static_cast<int>(*index), now);
      if (same_messages(wanted, robot->options)) continue;
      // Its CRCL clients go on. The server is destroyed before all that it refers to.
      if (robot->simple_message)
        gone.emplace_back([robot = robot] { robot->simple_message->stop(); });
      auto less = std::make_shared<Robot>(*robot);
      less->forget_messages(name);
      replace(name, std::move(less));
      continue;
    }
    gone.emplace_back([robot = robot] { robot->stop(); });
    const std::lock_guard lock(mutex_);
    robots_.erase(name);
  }
  std::vector<std::jthread> ending;
  for (const auto& end : gone) ending.emplace_back([&end] { end(); });
}

void RobotListeners::open_missing(const scene::Scene& scene, const api::SnapshotPtr& now) {
  std::set<std::string> missing;
  std::string problem;
  for (std::size_t i = 0; i < scene.robots.size(); ++i) {
    const std::string& name = scene.robots[i].name;
    const auto opened = complete(scene, i, now);
    if (opened) continue;
    problem = opened.error().field + ": " + opened.error().message;
    if (!missing_.contains(name)) spdlog::error("{}", problem);
    missing.insert(name);
  }
  missing_ = std::move(missing);
  retry_ = Clock::now() + kRetryPeriod;
  const std::lock_guard lock(mutex_);
  problem_ = std::move(problem);
}

void RobotListeners::share_memory() const {
  const Robots all = robots();
  for (const auto& [name, robot] : all) {
    robot->crcl->limit_unfinished(source_.max_unfinished_bytes / all.size());
  }
}

void RobotListeners::stop() {
  const std::lock_guard updating(update_mutex_);
  stopped_ = true;
  const Robots all = robots();
  std::vector<std::jthread> ending;
  for (const auto& [name, robot] : all) ending.emplace_back([&robot] { robot->stop(); });
}

RobotListeners::Robots RobotListeners::robots() const {
  const std::lock_guard lock(mutex_);
  return robots_;
}

std::string RobotListeners::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

Ports RobotListeners::ports() const {
  Ports all;
  for (const auto& [name, robot] : robots()) all.insert(robot->ports.begin(), robot->ports.end());
  return all;
}

template <typename Stats, typename Query>
RobotListeners::ByRobot<Stats> RobotListeners::stats_of(const Query& query) const {
  ByRobot<Stats> all;
  for (const auto& [name, robot] : robots()) query(*robot, all[name]);
  return all;
}

RobotListeners::ByRobot<crcl_server::CrclServerStats> RobotListeners::crcl_stats() const {
  return stats_of<crcl_server::CrclServerStats>(
      [](const Robot& robot, auto& stats) { stats = robot.crcl->stats(); });
}

RobotListeners::ByRobot<vision_server::VisionServerStats> RobotListeners::vision_stats() const {
  return stats_of<vision_server::VisionServerStats>(
      [](const Robot& robot, auto& stats) { stats = robot.vision->stats(); });
}

RobotListeners::ByRobot<simple_message::SimpleMessageStats> RobotListeners::simple_message_stats()
    const {
  ByRobot<simple_message::SimpleMessageStats> all;
  for (const auto& [name, robot] : robots()) {
    if (robot->simple_message) all[name] = robot->simple_message->stats();
  }
  return all;
}

namespace {

/// A robot's port together with what it refers to.
class KeptPort final : public protocols::RobotPort {
 public:
  KeptPort(std::shared_ptr<const void> keeps, protocols::RobotPort& port)
      : keeps_(std::move(keeps)), port_(port) {}
  [[nodiscard]] const std::string& robot() const override { return port_.robot(); }
  [[nodiscard]] Result<std::shared_ptr<protocols::RobotSession>> open(
      protocols::RobotSessionOptions options,
      std::shared_ptr<protocols::RobotClient> client) override {
    auto session = port_.open(std::move(options), std::move(client));
    if (!session) return session;
    const auto both = std::make_shared<KeptSession>(KeptSession{keeps_, *std::move(session)});
    return std::shared_ptr<protocols::RobotSession>(both, both->session.get());
  }

 private:
  /// The session goes first.
  struct KeptSession {
    std::shared_ptr<const void> keeps;
    std::shared_ptr<protocols::RobotSession> session;
  };
  std::shared_ptr<const void> keeps_;
  protocols::RobotPort& port_;
};

}  // namespace

std::shared_ptr<protocols::RobotPort> RobotListeners::find(const std::string& robot) const {
  const Robots all = robots();
  const auto found = all.find(robot);
  if (found == all.end()) return nullptr;
  return std::make_shared<KeptPort>(found->second, *found->second->crcl);
}

std::vector<std::string> RobotListeners::names() const {
  std::vector<std::string> names;
  for (const auto& [name, robot] : robots()) names.push_back(name);
  return names;
}

}  // namespace aprsim::server
