#include "tests/support/state_mutation.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "world/cell/state_bytes.hpp"
#include "world/physics/bodies/physics_failure.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::test {
namespace {

using archive::Layout;

std::shared_ptr<world::World> new_world(const std::string& name, scene::Simplification mode) {
  auto scene = scene::load_scene(name, scene::default_data_paths());
  if (!scene) throw std::runtime_error(scene.error().message);
  scene->physics.simplification = mode;
  auto world =
      std::make_shared<world::World>(std::make_shared<const scene::Scene>(*std::move(scene)), 1);
  world->watch_events();
  return world;
}

void inject(world::World& world, const std::string& kind, const std::string& target,
            api::FaultTrigger trigger = {}) {
  const auto done = world.apply(1, api::FaultCommand(api::InjectFault{.kind = kind,
                                                                      .target = target,
                                                                      .parameters = {},
                                                                      .trigger = std::move(trigger),
                                                                      .duration = {}}));
  if (!done) throw std::runtime_error(done.error().message);
}

/// The first gear and tray of the cell.
std::string first(const world::World& world, bool gear) {
  for (const auto& body : world.description()->bodies) {
    if ((body.kind == api::BodyKind::kGear) == gear) return body.name;
  }
  throw std::runtime_error("the cell has no such body");
}

void inject_faults(world::World& world) {
  if (world.description()->robots.empty()) return;
  const std::string robot = world.description()->robots.front().name;
  const std::string gear = first(world, true);
  inject(world, "joint-backlash", robot + ":2");
  inject(world, "encoder-bias", robot + ":1");
  inject(world, "gripper-drops", robot);
  inject(world, "camera-loses-part", robot + ":" + gear);
  inject(world, "camera-late", robot);
  inject(world, "tray-shifted", first(world, false), api::WhenReported{"never"});
  inject(world, "robot-slow", robot, api::WhenGrasped{robot, 3});
  inject(world, "part-faulty", gear,
         api::WhenCrossing{.quantity = faults::Quantity::kJointPosition,
                           .robot = robot,
                           .joint = 2,
                           .above = true,
                           .limit = 3});
  if (!world.settings().conveyor) return;
  inject(world, "belt-slip", "");
  const auto& eyes = world.settings().conveyor->photo_eyes;
  if (!eyes.empty()) inject(world, "belt-jam", "", api::WhenBeamBroken{eyes.front().name});
}

/// Streams of both kinds under way.
void stream(world::World& world, api::Ticket ticket) {
  const auto tell = [&](int robot, const api::TrajectoryAction& action) {
    const auto done = world.apply(ticket++, api::TrajectoryCommand{robot, action});
    if (!done) throw std::runtime_error(done.error().message);
  };
  api::Snapshot now;
  world.write(now);
  // A stream begins at rest.
  for (int steps = 0; steps < 5000 && (now.robots[0].moving || now.robots[1].moving); ++steps) {
    world.step();
    world.write(now);
  }
  const auto at = [&](int robot, double by) {
    const auto& reference = now.robots[static_cast<std::size_t>(robot)].motion.reference_rad;
    std::vector<double> q(reference.begin(), reference.begin() + (robot == 0 ? 6 : 7));
    q[1] += by;
    return q;
  };
  const std::vector<double> rest(7, 0.0);
  tell(1,
       api::FollowTrajectory{.commander = "tester",
                             .points = {{std::chrono::milliseconds(300), at(1, 0.02), rest, rest},
                                        {std::chrono::milliseconds(600), at(1, 0.03), rest, {}},
                                        {std::chrono::milliseconds(900), at(1, 0.01), {}, {}}},
                             .path_tolerance = std::vector<api::JointTolerance>(7, {0.5, 0}),
                             .goal_tolerance = std::vector<api::JointTolerance>(7, {0.5, 0}),
                             .goal_time_tolerance = std::chrono::seconds(1)});
  const api::Ticket moves = ticket;
  tell(0, api::ClaimMotion{"tester", api::StreamMode::kMoves});
  for (const double by : {0.1, 0.05, 0.08}) {
    tell(0, api::AppendMove{moves, at(0, by), 1, 1, 4});
  }
  for (int steps = 0; steps < 250; ++steps) world.step();
}

/// Motions of all kinds; `phase` chooses what is under way in the end.
void work(world::World& world, int phase) {
  api::Ticket ticket = 0;
  const auto tell = [&](int robot, api::RobotAction action, std::vector<api::Guard> guards = {}) {
    world.apply(++ticket, api::RobotCommand{robot, std::move(action), std::move(guards)});
  };
  const auto advance = [&world](int steps) {
    for (; steps > 0; --steps) world.step();
  };
  const int robots = static_cast<int>(world.robots().size());
  inject_faults(world);
  for (int r = 0; r < robots; ++r) tell(r, api::InitRobot{});
  world.apply(++ticket, api::ConveyorCommand{.run = true, .forward = true, .speed_m_s = 0.05});
  advance(5);
  for (int r = 0; r < robots; ++r) {
    tell(r, api::MoveJoints{{{.joint = 0, .position_rad = 0.2}, {.joint = 4, .position_rad = -1}}});
  }
  advance(phase == 0 ? 20 : 900);
  if (phase == 0) return;  // plans are being made
  api::Snapshot now;
  world.write(now);
  const api::Guard guard{
      .signal = {api::SignalKind::kForceR, 2, false}, .value = 1e6, .label = "g"};
  if (phase == 4) return stream(world, ++ticket);
  for (int r = 0; r < robots; ++r) {
    Pose pose = now.robots[static_cast<std::size_t>(r)].X_RT;
    pose.p.z() += 0.05;
    if (phase == 1) {
      tell(r, api::MoveTo{pose, true, {}, {}}, {guard});
      continue;
    }
    api::MoveThroughTo through;
    for (const double x : {0.02, 0.04}) {
      pose.p.x() += x;
      through.waypoints.push_back({pose, {}, {}});
    }
    through.straight = r == 0;
    tell(r, through);
  }
  advance(phase == 1 ? 300 : 200);
  if (phase != 3) return;
  // A tool change waits for the arm, commands for the change.
  tell(0, api::SetToolChanger{true});
  tell(0, api::SetGripper{0});
  tell(0, api::MoveJoints{{{.joint = 1, .position_rad = 0.1}}});
  world.apply(++ticket, api::SetIntruder{api::Intruder{{{0, 0, 3}, Eigen::Quaterniond::Identity()},
                                                       {0.1, 0.1, 0.1}}});
  advance(3);
}

template <typename T>
void put(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}
template <typename T>
T taken(const std::string& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

void change_real(std::string& bytes, std::size_t at, const Draw& draw) {
  const auto before = taken<double>(bytes, at);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::array<double, 16> values{std::numeric_limits<double>::quiet_NaN(),
                                      kInfinity,
                                      -kInfinity,
                                      0,
                                      -before,
                                      2 * before,
                                      before + 1,
                                      before - 1e-3,
                                      1e3,
                                      -1e3,
                                      1e9,
                                      1e29,
                                      -1e29,
                                      1e308,
                                      5e-324,
                                      before * 1e-9};
  put(bytes, at, values[draw() % values.size()]);
}

/// `T`: unsigned, for signed fields too.
template <typename T>
void change_whole(std::string& bytes, std::size_t at, const Draw& draw) {
  const auto before = taken<T>(bytes, at);
  constexpr T kMost = std::numeric_limits<T>::max();
  const std::array<T, 12> values{0,
                                 1,
                                 kMost,                      // -1
                                 static_cast<T>(kMost - 1),  // -2
                                 static_cast<T>(before + 1),
                                 static_cast<T>(before - 1),
                                 static_cast<T>(draw() % 64),
                                 static_cast<T>(draw() % 100'000),
                                 static_cast<T>(kMost / 2),      // largest signed
                                 static_cast<T>(kMost / 2 + 1),  // least signed
                                 static_cast<T>(before ^ (T{1} << (draw() % (8 * sizeof(T))))),
                                 static_cast<T>(draw())};
  put(bytes, at, values[draw() % values.size()]);
}

void change_leaf(std::string& bytes, const Layout::Leaf& leaf, const Draw& draw) {
  if (leaf.kind == Layout::Kind::kTruth) {
    return put(bytes, leaf.at, static_cast<std::uint8_t>(draw() % 4 == 0 ? draw() : draw() % 2));
  }
  if (leaf.kind == Layout::Kind::kReal && leaf.size == 8) {
    return change_real(bytes, leaf.at, draw);
  }
  if (leaf.size == 8) return change_whole<std::uint64_t>(bytes, leaf.at, draw);
  if (leaf.size == 4) return change_whole<std::uint32_t>(bytes, leaf.at, draw);
  if (leaf.size == 1) put(bytes, leaf.at, static_cast<std::uint8_t>(draw()));
}

/// Two fields of the same kind and size change places.
void swap_leaves(std::string& bytes, const Layout& layout, const Draw& draw) {
  const Layout::Leaf& one = layout.leaves[draw() % layout.leaves.size()];
  const std::size_t start = draw() % layout.leaves.size();
  for (std::size_t i = 0; i < layout.leaves.size(); ++i) {
    const Layout::Leaf& other = layout.leaves[(start + i) % layout.leaves.size()];
    if (other.kind != one.kind || other.size != one.size || other.at == one.at) continue;
    std::swap_ranges(bytes.begin() + static_cast<std::ptrdiff_t>(one.at),
                     bytes.begin() + static_cast<std::ptrdiff_t>(one.at + one.size),
                     bytes.begin() + static_cast<std::ptrdiff_t>(other.at));
    return;
  }
}

/// An element is left out or doubled, with the right count. Later offsets do not fit then.
void change_list(std::string& bytes, const Layout& layout, const Draw& draw) {
  const Layout::List& list = layout.lists[draw() % layout.lists.size()];
  const std::size_t count = list.begins.size() - 1;
  if (count == 0) return;
  const std::size_t i = draw() % count;
  const std::size_t begin = list.begins[i], end = list.begins[i + 1];
  if (draw() % 2 == 0) {
    put(bytes, list.count_at, static_cast<std::uint64_t>(count - 1));
    bytes.erase(begin, end - begin);
  } else {
    put(bytes, list.count_at, static_cast<std::uint64_t>(count + 1));
    bytes.insert(end, bytes.substr(begin, end - begin));
  }
}

}  // namespace

std::vector<GenuineState> genuine_states() {
  using Mode = scene::Simplification;
  const std::array<std::tuple<const char*, Mode, int>, 8> cases{{{"aprs", Mode::kDormant, 0},
                                                                 {"aprs", Mode::kDormant, 1},
                                                                 {"aprs", Mode::kMerge, 2},
                                                                 {"aprs", Mode::kVirtualJoints, 1},
                                                                 {"aprs", Mode::kOff, 2},
                                                                 {"aprs", Mode::kDormant, 4},
                                                                 {"aprs_lab", Mode::kDormant, 3},
                                                                 {"table1", Mode::kDormant, 1}}};
  std::vector<GenuineState> all;
  for (const auto& [name, mode, phase] : cases) {
    GenuineState& state = all.emplace_back();
    state.name = std::string(name) + " " + std::to_string(phase);
    state.world = new_world(name, mode);
    work(*state.world, phase);
    state.state = state.world->save();
    state.bytes = world::to_bytes(state.state, &state.layout);
  }
  return all;
}

std::string mutated(const GenuineState& state, const Draw& draw) {
  std::string bytes = state.bytes;
  for (std::uint64_t left = 1 + draw() % 3; left > 0; --left) {
    if (draw() % 8 == 0) {
      swap_leaves(bytes, state.layout, draw);
    } else {
      change_leaf(bytes, state.layout.leaves[draw() % state.layout.leaves.size()], draw);
    }
  }
  if (draw() % 8 == 0) change_list(bytes, state.layout, draw);
  return bytes;
}

bool survives(const GenuineState& state, const std::string& bytes, int steps) {
  const auto read = world::from_bytes(bytes, state.state);
  if (!read) return false;
  state.world->restore(*read);
  if (world::to_bytes(state.world->save()) != bytes) return false;
  try {
    api::Snapshot now;
    for (int i = 0; i < steps; ++i) {
      state.world->step();
      state.world->write(now);
    }
    static_cast<void>(world::to_bytes(state.world->save()));
  } catch (const physics::PhysicsFailure&) {
    // The simulation stops such a world until it is reset.
  }
  return true;
}

}  // namespace aprsim::test
