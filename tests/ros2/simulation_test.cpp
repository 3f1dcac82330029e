// The services of simulation_interfaces of aprsim-ros2, used by a client of Fast DDS beside the
// real daemon.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/ros2/ros2_fixture.hpp"
#include "tests/support/cell_client.hpp"

namespace aprsim::test {
namespace {

constexpr int kUnsupported = 0, kOk = 1, kNotFound = 2, kFailed = 4;
constexpr int kStopped = 0, kPlaying = 1, kPaused = 2;

void write_filter(CdrWriter& out, const std::string& pattern,
                  const std::vector<std::uint8_t>& categories) {
  out.text(pattern).number(static_cast<std::uint32_t>(categories.size()));
  for (const auto category : categories) out.number(category);
  out.texts({}).number(std::uint8_t{0});                 // tags
  out.number(std::uint8_t{0}).number(std::uint32_t{0});  // bounds
}

void write_pose(CdrWriter& out, const std::vector<double>& position, double w = 1) {
  for (const double value : position) out.number(value);
  out.number(0.0).number(0.0).number(0.0).number(w);
}

void write_spawn(CdrWriter& out, const std::string& name, const std::string& uri, bool rename) {
  out.text(name).number(static_cast<std::uint8_t>(rename)).text(uri).text("").text("");
  out.time(0).text("world");
  write_pose(out, {0, 0, 3});
}

void write_move(CdrWriter& out, const std::string& name, double w) {
  out.text(name).time(0).text("world");
  write_pose(out, {0.1, 0.2, 3}, w);
  for (int i = 0; i < 12; ++i) out.number(0.0);  // motion
  out.number(std::uint8_t{1}).number(std::uint8_t{0}).number(std::uint8_t{0});
}

/// A service's type, and a request that changes nothing.
struct ServiceCase {
  std::string type;
  void (*write)(CdrWriter&);
};

const std::map<std::string, ServiceCase> kServices = {
    {"get_simulator_features",
     {"GetSimulatorFeatures", [](CdrWriter& out) { out.number(std::uint8_t{0}); }}},
    {"get_simulation_state",
     {"GetSimulationState", [](CdrWriter& out) { out.number(std::uint8_t{0}); }}},
    {"set_simulation_state",
     {"SetSimulationState", [](CdrWriter& out) { out.number(std::uint8_t{7}); }}},
    {"step_simulation", {"StepSimulation", [](CdrWriter& out) { out.number(std::uint64_t{0}); }}},
    {"reset_simulation", {"ResetSimulation", [](CdrWriter& out) { out.number(std::uint8_t{1}); }}},
    {"get_entities", {"GetEntities", [](CdrWriter& out) { write_filter(out, "", {}); }}},
    {"get_entities_states",
     {"GetEntitiesStates", [](CdrWriter& out) { write_filter(out, "", {}); }}},
    {"get_entity_state", {"GetEntityState", [](CdrWriter& out) { out.text("nobody"); }}},
    {"get_entity_info", {"GetEntityInfo", [](CdrWriter& out) { out.text("nobody"); }}},
    {"set_entity_state", {"SetEntityState", [](CdrWriter& out) { write_move(out, "nobody", 1); }}},
    {"spawn_entity",
     {"SpawnEntity", [](CdrWriter& out) { write_spawn(out, "a", "no_type", false); }}},
    {"delete_entity", {"DeleteEntity", [](CdrWriter& out) { out.text("nobody"); }}},
    {"get_spawnables", {"GetSpawnables", [](CdrWriter& out) { out.texts({}); }}},
};

class Ros2Simulation : public Ros2 {
 protected:
  Ros2Simulation() : cell_(daemon_->port("grpc")) {
    for (const auto& [service, one] : kServices) {
      const std::string name = "simulation_interfaces::srv::dds_::" + one.type;
      fast_dds_->subscribe("rr/" + service + "Reply", name + "_Response_", false, "clientid=t;");
      fast_dds_->advertise("rq/" + service + "Request", name + "_Request_", "clientid=t;");
    }
    for (const auto& [service, one] : kServices) greet(service, one);
  }

  /// Asks until the service answers: a server may not know a new client yet that knows the server,
  /// and misses its requests then.
  void greet(const std::string& service, const ServiceCase& one) {
    int looks = 0;
    EXPECT_TRUE(wait_for([&] {
      if (!fast_dds_->is_matched("rr/" + service + "Reply") ||
          !fast_dds_->is_matched("rq/" + service + "Request")) {
        return false;
      }
      if (looks++ % 200 == 0) send(service, one.write);
      return !fast_dds_->take("rr/" + service + "Reply").empty();
    })) << service;
  }

  void send(const std::string& service, const std::function<void(CdrWriter&)>& fill) {
    CdrWriter out;
    out.number(kClient).number(++sequence_);
    fill(out);
    fast_dds_->write("rq/" + service + "Request", out.bytes());
  }

  /// The reply to a request that `fill` writes, read by `read`.
  void call(const std::string& service, const std::function<void(CdrWriter&)>& fill,
            const std::function<void(CdrReader&)>& read) {
    send(service, fill);
    const auto is_mine = [&](const auto& sample) {
      CdrReader in(sample);
      if (in.template number<std::uint64_t>() != kClient) return false;
      if (in.template number<std::int64_t>() != sequence_) return false;
      read(in);
      EXPECT_TRUE(in.at_end()) << service;
      return true;
    };
    EXPECT_TRUE(take_until("rr/" + service + "Reply", is_mine)) << service;
  }

  /// The code of a simulation_interfaces/msg/Result; its words go to words_.
  int result(CdrReader& in) {
    const int code = in.number<std::uint8_t>();
    words_ = in.text();
    EXPECT_EQ(words_.empty(), code == kOk) << words_;
    return code;
  }

  /// The code of a service whose reply is a result only.
  int simple(const std::string& service, const std::function<void(CdrWriter&)>& fill) {
    int code = -1;
    call(service, fill, [&](auto& in) { code = result(in); });
    return code;
  }

  int set_state(int state) {
    return simple("set_simulation_state",
                  [&](auto& out) { out.number(static_cast<std::uint8_t>(state)); });
  }
  int state() {
    int state = -1;
    call(
        "get_simulation_state", [](auto& out) { out.number(std::uint8_t{0}); },
        [&](auto& in) {
          state = in.template number<std::uint8_t>();
          EXPECT_EQ(result(in), kOk);
        });
    return state;
  }

  std::vector<std::string> entities(const std::string& pattern,
                                    const std::vector<std::uint8_t>& categories = {}) {
    std::vector<std::string> names;
    call(
        "get_entities", [&](auto& out) { write_filter(out, pattern, categories); },
        [&](auto& in) {
          code_ = result(in);
          names = in.texts();
        });
    return names;
  }

  int spawn(const std::string& name, const std::string& uri, bool rename,
            std::string* given = nullptr) {
    int code = -1;
    call(
        "spawn_entity", [&](auto& out) { write_spawn(out, name, uri, rename); },
        [&](auto& in) {
          code = result(in);
          const auto text = in.text();
          if (given) *given = text;
        });
    return code;
  }

  static constexpr std::uint64_t kClient = 42;
  CellClient cell_;
  std::int64_t sequence_ = 0;
  std::string words_;
  int code_ = -1;
};

TEST_F(Ros2Simulation, StateStepsAndReset) {
  std::vector<std::uint16_t> features;
  call(
      "get_simulator_features", [](auto& out) { out.number(std::uint8_t{0}); },
      [&](auto& in) {
        features.resize(in.template number<std::uint32_t>());
        for (auto& one : features) one = in.template number<std::uint16_t>();
        EXPECT_TRUE(in.texts().empty());
        EXPECT_FALSE(in.text().empty());
      });
  EXPECT_TRUE(std::ranges::count(features, 0) == 1 && std::ranges::count(features, 32) == 1);
  EXPECT_EQ(std::ranges::count(features, 40), 0) << "worlds cannot be loaded";
  const auto step = [&](std::uint64_t steps) {
    return simple("step_simulation", [&](auto& out) { out.number(steps); });
  };
  EXPECT_EQ(state(), kPaused);
  EXPECT_EQ(step(25), kOk);
  EXPECT_EQ(cell_.snapshot().step(), 25U);
  EXPECT_EQ(step(0), kFailed);
  EXPECT_EQ(set_state(kPaused), 101);  // is in that state
  EXPECT_EQ(set_state(7), kUnsupported);
  EXPECT_EQ(set_state(kPlaying), kOk);
  EXPECT_EQ(state(), kPlaying);
  EXPECT_EQ(step(1), kFailed) << "only a paused cell is stepped";
  EXPECT_EQ(set_state(kStopped), kOk);
  EXPECT_EQ(state(), kStopped);
  EXPECT_EQ(cell_.snapshot().step(), 0U);
  EXPECT_EQ(step(5), kOk);
  EXPECT_EQ(state(), kPaused);
  const auto reset = [&](std::uint8_t scope) {
    return simple("reset_simulation", [&](auto& out) { out.number(scope); });
  };
  EXPECT_EQ(reset(1), kUnsupported) << "time alone cannot be reset";
  EXPECT_EQ(cell_.snapshot().step(), 5U);
  EXPECT_EQ(reset(0), kOk);
  EXPECT_EQ(cell_.snapshot().step(), 0U);
}

TEST_F(Ros2Simulation, EntitiesAreFoundAndMoved) {
  const auto snapshot = cell_.snapshot();
  EXPECT_EQ(entities("").size(),
            static_cast<std::size_t>(snapshot.robots_size() + snapshot.bodies_size()));
  EXPECT_EQ(entities("^(fanuc|motoman)$"), (std::vector<std::string>{"fanuc", "motoman"}));
  EXPECT_EQ(entities("", {1}), (std::vector<std::string>{"fanuc", "motoman"}));
  EXPECT_TRUE(entities("(").empty());
  EXPECT_EQ(code_, kFailed);
  const auto body = snapshot.bodies(0);
  const auto read_state = [&](const std::string& name, std::vector<double>& position) {
    int code = -1;
    call(
        "get_entity_state", [&](auto& out) { out.text(name); },
        [&](auto& in) {
          code = result(in);
          in.time();
          EXPECT_EQ(in.text(), "world");
          for (int i = 0; i < 3; ++i) position.push_back(in.template number<double>());
          for (int i = 0; i < 16; ++i) in.template number<double>();  // turn and motion
        });
    return code;
  };
  std::vector<double> position;
  EXPECT_EQ(read_state("nobody", position), kNotFound);
  position.clear();
  EXPECT_EQ(read_state(body.name(), position), kOk);
  const auto& there = body.body_in_world().position_m();
  EXPECT_EQ(position, (std::vector<double>{there.x(), there.y(), there.z()}));
  const auto move = [&](const std::string& name, double w) {
    return simple("set_entity_state", [&](auto& out) { write_move(out, name, w); });
  };
  EXPECT_EQ(move(body.name(), 0), 101) << "no rotation";
  EXPECT_EQ(move("fanuc", 1), kUnsupported);
  EXPECT_EQ(move(body.name(), 1), kOk) << words_;
  EXPECT_NEAR(cell_.snapshot().bodies(0).body_in_world().position_m().x(), 0.1, 1e-9);
}

TEST_F(Ros2Simulation, BodiesAreSpawnedAndDeleted) {
  std::vector<std::string> types;
  call(
      "get_spawnables", [](auto& out) { out.texts({}); },
      [&](auto& in) {
        EXPECT_EQ(result(in), kOk);
        types.resize(in.template number<std::uint32_t>());
        for (auto& type : types) {
          type = in.text();
          for (int i = 0; i < 2; ++i) EXPECT_EQ(in.text(), "");
          in.template number<std::uint8_t>();
          EXPECT_EQ(in.template number<std::uint32_t>(), 0U);
        }
      });
  const auto cell = cell_.cell();
  EXPECT_TRUE(std::ranges::equal(types, cell.body_types()));
  EXPECT_EQ(spawn("new_one", "no_type", false), 104);
  EXPECT_EQ(spawn("", types[0], false), 102);
  std::string name;
  EXPECT_EQ(spawn("new_one", types[0], false, &name), kOk) << words_;
  EXPECT_EQ(name, "new_one");
  EXPECT_EQ(spawn("new_one", types[0], false), 101);
  EXPECT_EQ(spawn("new_one", types[0], true, &name), kOk) << words_;
  EXPECT_EQ(name, "new_one_1");
  EXPECT_EQ(entities("^new_one").size(), 2U);
  const auto remove = [&](const std::string& which) {
    return simple("delete_entity", [&](auto& out) { out.text(which); });
  };
  EXPECT_EQ(remove("new_one"), kOk);
  EXPECT_EQ(remove("new_one"), kNotFound);
  EXPECT_EQ(remove("fanuc"), kFailed);
  EXPECT_EQ(entities("^new_one"), std::vector<std::string>{"new_one_1"});
}

}  // namespace
}  // namespace aprsim::test
