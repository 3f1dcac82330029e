#include "clients/ros2/dds/simulation_server.hpp"

#include <algorithm>
#include <aprsim_ros2_messages.h>
#include <aprsim_ros2_type_hashes.hpp>
#include <cstdint>
#include <utility>

#include "clients/ros2/cell/frames.hpp"
#include "clients/ros2/dds/samples.hpp"

// Request and reply of a service of simulation_interfaces, as TopicType and as C type.
#define APRSIM_SIMULATION_SERVICE(name)                                  \
  SimulationService<simulation_interfaces_srv_dds__##name##_Request_,    \
                    simulation_interfaces_srv_dds__##name##_Response_> { \
    {simulation_interfaces_srv_dds__##name##_Request__desc,              \
     type_hash::k_simulation_interfaces_srv_##name##_Request},           \
        {simulation_interfaces_srv_dds__##name##_Response__desc,         \
         type_hash::k_simulation_interfaces_srv_##name##_Response},      \
  }

namespace aprsim::ros2 {
namespace {

using RosResult = simulation_interfaces_msg_dds__Result_;
using RosState = simulation_interfaces_msg_dds__EntityState_;

/// A service with the C types of its request and its reply.
template <typename Request, typename Reply>
struct SimulationService {
  TopicType request, reply;
};

constexpr const char* kNoDaemon = "the daemon is away";

RosResult ros_result(const SimulationResult& result) {
  return {result.code, text_of(result.message)};
}

v1::Pose pose_of(const geometry_msgs_msg_dds__Pose_& pose) {
  v1::Pose out;
  out.mutable_position_m()->set_x(pose.position.x);
  out.mutable_position_m()->set_y(pose.position.y);
  out.mutable_position_m()->set_z(pose.position.z);
  out.mutable_orientation()->set_w(pose.orientation.w);
  out.mutable_orientation()->set_x(pose.orientation.x);
  out.mutable_orientation()->set_y(pose.orientation.y);
  out.mutable_orientation()->set_z(pose.orientation.z);
  return out;
}

v1::Vector3 vector_of(const geometry_msgs_msg_dds__Vector3_& vector) {
  v1::Vector3 out;
  out.set_x(vector.x);
  out.set_y(vector.y);
  out.set_z(vector.z);
  return out;
}

/// A state that refers to the frame's name.
RosState ros_state(const EntityState& state, const std::string& frame) {
  const auto& p = state.pose.position_m();
  const auto& q = state.pose.orientation();
  RosState out{};
  out.header.stamp = stamp_of(state.stamp);
  out.header.frame_id = text_of(frame);
  out.pose.position = {p.x(), p.y(), p.z()};
  out.pose.orientation = {q.x(), q.y(), q.z(), q.w()};
  out.twist.linear = {state.linear.x(), state.linear.y(), state.linear.z()};
  out.twist.angular = {state.angular.x(), state.angular.y(), state.angular.z()};
  return out;
}

EntityFilter filter_of(const simulation_interfaces_msg_dds__EntityFilters_& filters) {
  EntityFilter filter{.pattern = filters.filter,
                      .categories = {},
                      .has_tags = filters.tags.tags._length > 0,
                      .bounds = filters.bounds.type};
  for (const auto& category : values_of(filters.categories)) {
    filter.categories.push_back(category.category);
  }
  return filter;
}

std::vector<std::string> names_of(const std::vector<Entity>& entities) {
  std::vector<std::string> names;
  for (const auto& entity : entities) names.push_back(entity.name);
  return names;
}

std::vector<char*> texts_of(const std::vector<std::string>& texts) {
  std::vector<char*> out;
  for (const auto& text : texts) out.push_back(text_of(text));
  return out;
}

/// Collects the services of a node.
template <typename Entry>
class Services {
 public:
  Services(Node& node, std::string ros_namespace, const Wakeup& wakeup, std::vector<Entry>& entries)
      : node_(node), namespace_(std::move(ros_namespace)), wakeup_(wakeup), entries_(entries) {}

  /// `answer`: fills in a reply by a request, and returns what the reply refers to.
  template <typename Request, typename Reply, typename Answer>
  void add(const std::string& name, const SimulationService<Request, Reply>& types, Answer answer) {
    auto service =
        std::make_unique<Service>(node_, namespace_ + "/" + name, types.request, types.reply);
    wakeup_.attach(service->requests());
    entries_.push_back({std::move(service), [answer](Simulation* simulation, const void* sample) {
                          return answer(simulation, *static_cast<const Request*>(sample));
                        }});
  }

 private:
  Node& node_;
  std::string namespace_;
  const Wakeup& wakeup_;
  std::vector<Entry>& entries_;
};

/// Writes a reply with its header.
template <typename Reply>
void write_reply(dds_entity_t writer, const ServiceHeader& header, Reply& reply) {
  reply.rmw_client = header.client;
  reply.rmw_sequence = header.sequence;
  write_sample(writer, &reply);
}

/// A reply that has a result only.
template <typename Reply>
Service::WriteReply result_reply(SimulationResult result) {
  return [result = std::move(result)](auto writer, const auto& header) {
    Reply reply{};
    reply.result = ros_result(result);
    write_reply(writer, header, reply);
  };
}

/// The result of a call; kFailed without a simulation.
template <typename Call>
SimulationResult call(Simulation* simulation, const Call& make) {
  return simulation ? make(*simulation) : SimulationResult{kFailed, kNoDaemon};
}

/// The same for entities.
template <typename Query>
FoundEntities query(Simulation* simulation, const Query& what) {
  return simulation ? simulation->find(what) : FoundEntities{{kFailed, kNoDaemon}, {}};
}

template <typename Services>
void add_features(Services& services) {
  services.add("get_simulator_features", APRSIM_SIMULATION_SERVICE(GetSimulatorFeatures),
               [](Simulation*, const auto&) -> Service::WriteReply {
                 return [](auto writer, const auto& header) {
                   const auto features = Simulation::features();
                   const std::string info =
                       "aprsim: a resource's uri is a type of gears, trays or parts";
                   simulation_interfaces_srv_dds__GetSimulatorFeatures_Response_ reply{};
                   refer(reply.features.features, features);
                   reply.features.custom_info = text_of(info);
                   write_reply(writer, header, reply);
                 };
               });
}

template <typename Services>
void add_state(Services& services) {
  services.add("get_simulation_state", APRSIM_SIMULATION_SERVICE(GetSimulationState),
               [](Simulation* simulation, const auto&) -> Service::WriteReply {
                 std::uint8_t state = 0;
                 const auto result =
                     call(simulation, [&](auto& cell) { return cell.read_state(state); });
                 return [result, state](auto writer, const auto& header) {
                   simulation_interfaces_srv_dds__GetSimulationState_Response_ reply{};
                   reply.state.state = state;
                   reply.result = ros_result(result);
                   write_reply(writer, header, reply);
                 };
               });
  services.add(
      "set_simulation_state", APRSIM_SIMULATION_SERVICE(SetSimulationState),
      [](Simulation* simulation, const auto& request) {
        return result_reply<simulation_interfaces_srv_dds__SetSimulationState_Response_>(
            call(simulation, [&](auto& cell) { return cell.set_state(request.state.state); }));
      });
  services.add("step_simulation", APRSIM_SIMULATION_SERVICE(StepSimulation),
               [](Simulation* simulation, const auto& request) {
                 return result_reply<simulation_interfaces_srv_dds__StepSimulation_Response_>(
                     call(simulation, [&](auto& cell) { return cell.step(request.steps); }));
               });
  services.add("reset_simulation", APRSIM_SIMULATION_SERVICE(ResetSimulation),
               [](Simulation* simulation, const auto& request) {
                 return result_reply<simulation_interfaces_srv_dds__ResetSimulation_Response_>(
                     call(simulation, [&](auto& cell) { return cell.reset(request.scope); }));
               });
}

template <typename Services>
void add_entities(Services& services) {
  services.add("get_entities", APRSIM_SIMULATION_SERVICE(GetEntities),
               [](Simulation* simulation, const auto& request) -> Service::WriteReply {
                 return [found = query(simulation, filter_of(request.filters))](
                            auto writer, const auto& header) {
                   const auto names = names_of(found.entities);
                   const auto texts = texts_of(names);
                   simulation_interfaces_srv_dds__GetEntities_Response_ reply{};
                   reply.result = ros_result(found.result);
                   refer(reply.entities, texts);
                   write_reply(writer, header, reply);
                 };
               });
  services.add("get_entities_states", APRSIM_SIMULATION_SERVICE(GetEntitiesStates),
               [](Simulation* simulation, const auto& request) -> Service::WriteReply {
                 return [found = query(simulation, filter_of(request.filters))](
                            auto writer, const auto& header) {
                   const std::string world = kWorldFrame;
                   const auto names = names_of(found.entities);
                   const auto texts = texts_of(names);
                   std::vector<RosState> states;
                   for (const auto& entity : found.entities) {
                     states.push_back(ros_state(entity.state, world));
                   }
                   simulation_interfaces_srv_dds__GetEntitiesStates_Response_ reply{};
                   reply.result = ros_result(found.result);
                   refer(reply.entities, texts);
                   refer(reply.states, states);
                   write_reply(writer, header, reply);
                 };
               });
}

/// The entity of a query, or one without values.
Entity first_of(const FoundEntities& found) {
  return found.entities.empty() ? Entity{} : found.entities.front();
}

template <typename Services>
void add_entity(Services& services) {
  services.add("get_entity_state", APRSIM_SIMULATION_SERVICE(GetEntityState),
               [](Simulation* simulation, const auto& request) -> Service::WriteReply {
                 return [found = query(simulation, std::string(request.entity))](
                            auto writer, const auto& header) {
                   const std::string world = kWorldFrame;
                   simulation_interfaces_srv_dds__GetEntityState_Response_ reply{};
                   reply.result = ros_result(found.result);
                   reply.state = ros_state(first_of(found).state, world);
                   write_reply(writer, header, reply);
                 };
               });
  services.add("get_entity_info", APRSIM_SIMULATION_SERVICE(GetEntityInfo),
               [](Simulation* simulation, const auto& request) -> Service::WriteReply {
                 return [found = query(simulation, std::string(request.entity))](
                            auto writer, const auto& header) {
                   const Entity entity = first_of(found);
                   simulation_interfaces_srv_dds__GetEntityInfo_Response_ reply{};
                   reply.result = ros_result(found.result);
                   reply.info.category.category = entity.category;
                   reply.info.description = text_of(entity.description);
                   write_reply(writer, header, reply);
                 };
               });
  services.add("set_entity_state", APRSIM_SIMULATION_SERVICE(SetEntityState),
               [](Simulation* simulation, const auto& request) {
                 const auto& state = request.state;
                 const StateChange change{.entity = request.entity,
                                          .state = {{},
                                                    pose_of(state.pose),
                                                    vector_of(state.twist.linear),
                                                    vector_of(state.twist.angular)},
                                          .set_pose = request.set_pose,
                                          .set_twist = request.set_twist,
                                          .set_acceleration = request.set_acceleration};
                 return result_reply<simulation_interfaces_srv_dds__SetEntityState_Response_>(
                     call(simulation, [&](auto& cell) { return cell.set_entity_state(change); }));
               });
}

template <typename Services>
void add_spawning(Services& services) {
  services.add(
      "spawn_entity", APRSIM_SIMULATION_SERVICE(SpawnEntity),
      [](Simulation* simulation, const auto& request) -> Service::WriteReply {
        const SpawnRequest spawn{.name = request.name,
                                 .allow_renaming = request.allow_renaming,
                                 .uri = request.entity_resource.uri,
                                 .resource_string = request.entity_resource.resource_string,
                                 .entity_namespace = request.entity_namespace,
                                 .frame = request.initial_pose.header.frame_id,
                                 .pose = pose_of(request.initial_pose.pose)};
        std::string name;
        const auto result = call(simulation, [&](auto& cell) { return cell.spawn(spawn, name); });
        return [result, name](auto writer, const auto& header) {
          simulation_interfaces_srv_dds__SpawnEntity_Response_ reply{};
          reply.result = ros_result(result);
          reply.entity_name = text_of(name);
          write_reply(writer, header, reply);
        };
      });
  services.add("delete_entity", APRSIM_SIMULATION_SERVICE(DeleteEntity),
               [](Simulation* simulation, const auto& request) {
                 return result_reply<simulation_interfaces_srv_dds__DeleteEntity_Response_>(
                     call(simulation, [&](auto& cell) { return cell.remove(request.entity); }));
               });
  services.add("get_spawnables", APRSIM_SIMULATION_SERVICE(GetSpawnables),
               [](Simulation* simulation, const auto&) -> Service::WriteReply {
                 std::vector<std::string> types;
                 const auto result =
                     call(simulation, [&](auto& cell) { return cell.read_spawnables(types); });
                 return [result, types](auto writer, const auto& header) {
                   const std::string none;
                   std::vector<simulation_interfaces_msg_dds__Spawnable_> spawnables(types.size());
                   for (std::size_t i = 0; i < types.size(); ++i) {
                     spawnables[i].entity_resource = {text_of(types[i]), text_of(none)};
                     spawnables[i].description = text_of(none);
                   }
                   simulation_interfaces_srv_dds__GetSpawnables_Response_ reply{};
                   reply.result = ros_result(result);
                   refer(reply.spawnables, spawnables);
                   write_reply(writer, header, reply);
                 };
               });
}

}  // namespace

SimulationServer::SimulationServer(Node& node, const std::string& ros_namespace,
                                   const Wakeup& wakeup) {
  Services<Entry> services(node, ros_namespace, wakeup, entries_);
  add_features(services);
  add_state(services);
  add_entities(services);
  add_entity(services);
  add_spawning(services);
}

void SimulationServer::serve(Simulation* simulation) {
  for (const auto& entry : entries_) {
    entry.service->take([&](const Caller& caller, const void* sample) {
      entry.service->reply(caller, entry.answer(simulation, sample));
    });
  }
}

}  // namespace aprsim::ros2
