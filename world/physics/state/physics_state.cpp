#include "world/physics/state/physics_state.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "world/api/snapshot/snapshot_fields.hpp"
#include "world/archive/archive.hpp"
#include "world/physics/bodies/divergence.hpp"
#include "world/physics/model/physics_model.hpp"
#include "world/physics/model/tool_changes.hpp"
#include "world/physics/step/physics_step.hpp"

namespace aprsim::physics {

struct PhysicsState::Data {
  struct Body {
    BodyMotion motion;
    Eigen::Vector3d origin_B;
    Eigen::Isometry3d X_WB;
    Eigen::Vector3d v_com_W, omega_W;
    Aabb bounds;
    std::optional<std::uint64_t> lost_step;
    bool mounted = false, decoupled_from_belt = false;

    void restore(FreeBody& body) const;

    static constexpr bool kAsMany = true;  ///< as the scene has
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [motion, origin_B, X_WB, v_com_W, omega_W, bounds, lost_step, mounted,
             decoupled_from_belt] = self;
      io(motion, origin_B, X_WB, v_com_W, omega_W, bounds, lost_step, mounted, decoupled_from_belt);
    }
    template <typename In>
    void require_valid(In& in) const {
      in.require(
          !has_diverged(motion) && !has_diverged(BodyMotion{.v_W = v_com_W, .omega_W = omega_W}),
          "a body that is faster than anything in a cell");
    }
  };
  std::vector<Body> bodies;
  std::vector<GripperMechanism::State> grippers, parked;
  std::vector<int> tool_of_robot;
  std::vector<ArmLinks::State> arms;
  Simplification::State simplification;
  std::vector<ContactConstraint> constraints;
  double belt_speed_m_s = 0;
  PhysicsStep::State step;

  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [bodies, grippers, parked, tool_of_robot, arms, simplification, constraints,
           belt_speed_m_s, step] = self;
    io(bodies, grippers, parked, tool_of_robot, arms, simplification, constraints, belt_speed_m_s,
       step);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.one_for_each(In::kRobot, tool_of_robot.size());
    for (const int tool : tool_of_robot) in.index_or_none(In::kTool, tool);
    for (std::size_t r = 0; r < arms.size(); ++r) {
      const auto links = static_cast<std::size_t>(in.counts().robots[r].links);
      in.require(arms[r].X_WL_before.size() == links && arms[r].X_WL.size() == links &&
                     arms[r].X_WL_next.size() == links,
                 "an arm with another number of links");
    }
    const std::size_t parts = bodies.size() - parked.size();
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const auto tool = static_cast<int>(i) - static_cast<int>(parts);
      const auto robots = tool < 0 ? 0 : std::ranges::count(tool_of_robot, tool);
      in.require(robots == (bodies[i].mounted ? 1 : 0),
                 "a tool that is not where its robot has it");
    }
  }
};

/// Lost and mounted bodies are marked before.
void PhysicsState::Data::Body::restore(FreeBody& body) const {
  body.origin_B = origin_B;
  body.X_WB = X_WB;
  body.v_com_W = v_com_W;
  body.omega_W = omega_W;
  body.bounds = bounds;
  body.decoupled_from_belt = decoupled_from_belt;
  body.body.restore(motion);
}

PhysicsState::PhysicsState(const PhysicsModel& model, const PhysicsStep& step) {
  // Everything that a later step reads must be in Data: resumed and uninterrupted runs agree bit
  // for bit.
  Data data{.simplification = model.simplification.save()};
  for (const auto& body : model.bodies) {
    data.bodies.push_back({body.body.motion(), body.origin_B, body.X_WB, body.v_com_W, body.omega_W,
                           body.bounds, body.lost_step, body.mounted, body.decoupled_from_belt});
  }
  for (const auto& gripper : model.grippers) data.grippers.push_back(gripper.save());
  for (const auto& gripper : model.parked) data.parked.push_back(gripper.save());
  data.tool_of_robot = model.tool_of_robot;
  for (const auto& arm : model.arms) data.arms.push_back(arm.save());
  data.constraints = model.constraints;
  data.belt_speed_m_s = model.belt_speed_m_s;
  data.step = step.save();
  data_ = std::make_shared<const Data>(std::move(data));
}

void PhysicsState::restore(PhysicsModel& model, PhysicsStep& step) const {
  if (!data_) throw std::invalid_argument("physics state: empty");
  const Data& data = *data_;
  if (data.bodies.size() != model.bodies.size() || data.arms.size() != model.arms.size()) {
    throw std::invalid_argument(
        "physics state: of " + std::to_string(data.bodies.size()) + " bodies and " +
        std::to_string(data.arms.size()) + " robots, but the scene has " +
        std::to_string(model.bodies.size()) + " and " + std::to_string(model.arms.size()));
  }
  for (std::size_t i = 0; i < data.bodies.size(); ++i) {
    model.bodies[i].lost_step = data.bodies[i].lost_step;
    model.bodies[i].mounted = data.bodies[i].mounted;
  }
  // Composites before poses: they decide what each rigid body moves.
  model.simplification.restore(data.simplification);
  for (std::size_t i = 0; i < data.bodies.size(); ++i) {
    data.bodies[i].restore(model.bodies[i]);
  }
  model.simplification.sleeping().record_poses();
  arrange_tools(model, data.tool_of_robot);
  for (std::size_t r = 0; r < data.arms.size(); ++r) {
    model.arms[r].restore(data.arms[r]);
    model.grippers[r].restore(data.grippers[r]);
  }
  for (std::size_t t = 0; t < data.parked.size(); ++t) model.parked[t].restore(data.parked[t]);
  model.open_tools();
  model.constraints = data.constraints;
  model.belt_speed_m_s = data.belt_speed_m_s;
  step.restore(data.step);
}

void PhysicsState::advance_clock(std::uint64_t steps) {
  auto data = std::make_shared<Data>(*data_);
  data->step.results.count += steps;
  data_ = std::move(data);
}

int PhysicsState::tool_of(int robot) const {
  return data_->tool_of_robot.at(static_cast<std::size_t>(robot));
}

std::size_t PhysicsState::bytes() const {
  if (!data_) return 0;
  // Capacity, not size: the heap memory that the state occupies.
  const auto held = [](const auto& values) { return values.capacity() * sizeof values[0]; };
  std::size_t cache_bytes = held(data_->step.cache);
  for (const auto& manifold : data_->step.cache) cache_bytes += held(manifold.points);
  return sizeof *data_ + held(data_->bodies) + held(data_->grippers) + held(data_->parked) +
         held(data_->arms) + held(data_->constraints) + cache_bytes +
         held(data_->step.solver.contacts);
}

void PhysicsState::write(archive::Writer& out) const { out(*data_); }

void PhysicsState::read(archive::Reader& in) {
  auto data = std::make_shared<Data>(*data_);
  in(*data);
  data_ = std::move(data);
}

}  // namespace aprsim::physics
