#pragma once

#include <vector>

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scenario/scenario.hpp"

/// Checks a scenario against its scene. Errors name the place in the file.
namespace aprsim::scenario {

/// Checks that the scene has enough trays of the type, the slots, and gears that fit.
void check_order(const yaml::Map& keys, const Order& order, const scene::Scene& scene);
/// Checks that no more kits of a type are open at once than there are trays.
void check_counts(const yaml::Node& orders, const Scenario& scenario);
/// Checks kind, target, parameters and duration.
void check_fault(const yaml::Map& keys, const Fault& fault, const scene::Scene& scene);
/// Checks types, robots, photo-eyes and events in a trigger.
void check_when(const yaml::Node& node, const faults::FaultWhen& when, const Scenario& scenario);
/// Checks names of orders and faults in moments.
void check_moment(const yaml::Node& node, const Moment& moment, const Scenario& scenario);

}  // namespace aprsim::scenario
