#include "server/embedded/cell_library.h"

#include <algorithm>
#include <array>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include "protocols/messages/state_hash.hpp"
#include "protocols/messages/status_code.hpp"
#include "server/embedded/embedded_calls.hpp"
#include "server/embedded/embedded_cell.hpp"
#include "server/embedded/embedded_robot.hpp"
#include "world/api/description/robot_identity.hpp"
#include "world/scene/scene_loader.hpp"

namespace {

using aprsim::embedded::CallStatus;
using aprsim::embedded::EmbeddedCell;
using aprsim::embedded::EmbeddedRobot;
namespace api = aprsim::api;

thread_local std::string error_text;

constexpr int kOk = 0;
constexpr int kInternal = 13;
constexpr const char* kKeptState = "kept";

int failed(const CallStatus& status) {
  error_text = status.text;
  return status.code;
}

/// Runs work whose exceptions must not leave the library.
template <typename Work>
int guarded(const Work& work) {
  try {
    return work();
  } catch (const std::exception& failure) {
    return failed({kInternal, failure.what()});
  }
}

/// A library writes no log of its own accord; warnings are for the standard error stream.
void set_up_log() {
  static std::once_flag once;
  std::call_once(once, [] {
    spdlog::set_default_logger(spdlog::stderr_logger_mt("aprsim"));
    spdlog::set_level(spdlog::level::err);
  });
}

/// Numbers of the state, row by row.
class Arrays {
 public:
  void write(const api::Snapshot& now);
  [[nodiscard]] const std::vector<double>& of(int array) const {
    return all_[static_cast<std::size_t>(array)];
  }

 private:
  using All = std::array<std::vector<double>, APRSIM_ARRAY_COUNT>;
  All all_, next_;
  std::vector<std::vector<double>> retired_;  ///< of other sizes: callers may still read them
};

/// Puts numbers one after another.
class Row {
 public:
  explicit Row(std::vector<double>& out) : out_(out) { out_.clear(); }

  void put(double number) { out_.push_back(number); }
  void put(const Eigen::Vector3d& v) {
    for (const double number : {v.x(), v.y(), v.z()}) put(number);
  }
  void put(const aprsim::Pose& pose) {
    put(pose.p);
    for (const double number : {pose.q.w(), pose.q.x(), pose.q.y(), pose.q.z()}) put(number);
  }

 private:
  std::vector<double>& out_;
};

void Arrays::write(const api::Snapshot& now) {
  Row poses(next_[APRSIM_BODY_POSE]), velocities(next_[APRSIM_BODY_VELOCITY]);
  for (const api::BodySnapshot& body : now.bodies) {
    poses.put(body.X_WB);
    velocities.put(body.v_W);
    velocities.put(body.omega_W);
  }
  Row joints(next_[APRSIM_JOINT]), tools(next_[APRSIM_TOOL_POSE]), loads(next_[APRSIM_TOOL_LOAD]),
      grippers(next_[APRSIM_GRIPPER]);
  for (std::size_t i = 0; i < now.robots.size(); ++i) {
    const api::RobotSnapshot& robot = now.robots[i];
    for (std::size_t j = 0; j < now.cell->robots[i].joints.size(); ++j) {
      joints.put(robot.joints[j].position_rad);
      joints.put(robot.joints[j].velocity_rad_s);
      joints.put(robot.joints[j].torque_nm);
    }
    tools.put(robot.X_WT);
    loads.put(robot.force_T_R);
    loads.put(robot.torque_T_R);
    grippers.put(robot.gripper.separation_m);
    for (const double force_n : robot.gripper.force_n) grippers.put(force_n);
    grippers.put(robot.gripper.holding ? 1 : 0);
    grippers.put(robot.gripper.held_body);
  }
  for (std::size_t i = 0; i < all_.size(); ++i) {
    if (all_[i].size() == next_[i].size()) {
      std::copy(next_[i].begin(), next_[i].end(), all_[i].begin());
    } else {
      retired_.push_back(std::exchange(all_[i], next_[i]));
    }
  }
}

}  // namespace

struct aprsim_cell {
  aprsim_cell(std::shared_ptr<const aprsim::scene::Scene> scene, std::uint64_t seed)
      : cell(scene, seed) {
    follow_robots();
    arrays.write(*cell.latest());
  }

  EmbeddedCell cell;
  std::deque<EmbeddedRobot> robots;
  std::shared_ptr<const api::CellDescription> known;  ///< whose robots these are
  Arrays arrays;
  std::string answer;
  const aprsim::embedded::AfterStep after_step = [this] {
    bool runs = false;
    for (EmbeddedRobot& robot : robots) runs = robot.advance() || runs;
    return runs;
  };

  /// After a reset to a scene with other robots, or a load of such a state, they begin anew.
  void follow_robots() {
    const auto& now = cell.world().description();
    if (now == known) return;
    const bool same =
        known && std::ranges::equal(now->robots, known->robots, [](const auto& a, const auto& b) {
          return api::same_robot(a, b);
        });
    known = now;
    if (same) return;
    robots.clear();
    for (int i = 0; i < static_cast<int>(now->robots.size()); ++i) {
      robots.emplace_back(i, cell, cell);
    }
  }
  [[nodiscard]] int submit(api::SimulationCommand command) {
    const auto ticket = cell.submit({0, std::move(command)});
    follow_robots();
    if (ticket) return kOk;
    return failed({aprsim::protocols::status_code(ticket.error().code),
                   aprsim::protocols::status_text(ticket.error())});
  }
  [[nodiscard]] EmbeddedRobot* robot(std::size_t index) {
    if (index < robots.size()) return &robots[index];
    error_text = "robot: " + std::to_string(index) + " is not below " +
                 std::to_string(robots.size()) + ", the robots of this cell";
    return nullptr;
  }
};

void aprsim_cell_add_extensions(const char* directory) {
  (void)guarded([&] {
    aprsim::scene::add_extension_directories({directory});
    return kOk;
  });
}

aprsim_cell* aprsim_cell_open(const char* scene, const uint64_t* seed) {
  set_up_log();
  try {
    auto loaded = aprsim::scene::load_scene(scene, aprsim::scene::default_data_paths());
    if (!loaded) {
      error_text = loaded.error().message;
      return nullptr;
    }
    auto shared = std::make_shared<const aprsim::scene::Scene>(std::move(*loaded));
    const std::uint64_t own = shared->seed;
    return new aprsim_cell(std::move(shared), seed != nullptr ? *seed : own);
  } catch (const std::exception& failure) {
    error_text = failure.what();
    return nullptr;
  }
}

void aprsim_cell_close(aprsim_cell* cell) { delete cell; }

const char* aprsim_error(void) { return error_text.c_str(); }

int aprsim_cell_call(aprsim_cell* cell, const char* method, const void* request, size_t size,
                     const void** answer, size_t* answer_size) {
  return guarded([&] {
    const std::string_view bytes(static_cast<const char*>(request), size);
    const CallStatus status =
        aprsim::embedded::call(cell->cell, method, bytes, cell->after_step, cell->answer);
    cell->follow_robots();
    if (status.code != kOk) return failed(status);
    *answer = cell->answer.data();
    *answer_size = cell->answer.size();
    return kOk;
  });
}

int aprsim_robot_send(aprsim_cell* cell, size_t robot, const void* documents, size_t size,
                      const void** statuses, size_t* statuses_size) {
  return guarded([&] {
    EmbeddedRobot* const port = cell->robot(robot);
    if (port == nullptr) return aprsim::protocols::status_code(aprsim::ErrorCode::kNotFound);
    const auto sent = port->send({static_cast<const char*>(documents), size});
    if (!sent) {
      return failed({aprsim::protocols::status_code(sent.error().code),
                     aprsim::protocols::status_text(sent.error())});
    }
    cell->answer = port->take_statuses();
    *statuses = cell->answer.data();
    *statuses_size = cell->answer.size();
    return kOk;
  });
}

int aprsim_robot_connect(aprsim_cell* cell, size_t robot) {
  return guarded([&] {
    EmbeddedRobot* const port = cell->robot(robot);
    if (port == nullptr) return aprsim::protocols::status_code(aprsim::ErrorCode::kNotFound);
    port->reconnect();
    return kOk;
  });
}

int aprsim_cell_step(aprsim_cell* cell, uint64_t steps) {
  return guarded([&] {
    if (const int code = cell->submit(api::StepBy{steps}); code != kOk) return code;
    cell->cell.take_steps(cell->after_step);
    const std::string why = cell->cell.problem();
    return why.empty() ? kOk : failed({aprsim::protocols::kAbortedStatus, why});
  });
}

int aprsim_cell_keep(aprsim_cell* cell) {
  return guarded([&] { return cell->submit(api::SaveState{kKeptState, {}}); });
}

int aprsim_cell_return(aprsim_cell* cell) {
  return guarded([&] { return cell->submit(api::LoadState{kKeptState, {}}); });
}

const double* aprsim_cell_array(aprsim_cell* cell, int array, size_t* size) {
  if (array < 0 || array >= APRSIM_ARRAY_COUNT) return nullptr;
  const std::vector<double>& numbers = cell->arrays.of(array);
  *size = numbers.size();
  return numbers.data();
}

void aprsim_cell_observe(aprsim_cell* cell) {
  (void)guarded([&] {
    cell->arrays.write(*cell->cell.latest());
    return kOk;
  });
}

uint64_t aprsim_cell_step_count(const aprsim_cell* cell) { return cell->cell.world().step_count(); }

uint64_t aprsim_cell_state_hash(const aprsim_cell* cell) {
  return aprsim::protocols::state_hash(*cell->cell.latest());
}
