#pragma once

#include <vector>

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scenario/scenario.hpp"

/// Checks of a scenario against its scene. An error names its place in the file.
namespace aprsim::scenario {

/// Kit trays enough of the type, slots that it has, gears that fit.
void check_order(const yaml::Map& keys, const Order& order, const scene::Scene& scene);
/// More kits of a type ordered at once than there are trays.
void check_counts(const yaml::Node& orders, const Scenario& scenario);
/// Kind, target, parameters and duration.
void check_fault(const yaml::Map& keys, const Fault& fault, const scene::Scene& scene);
/// Types, robots, photo-eyes and events that a trigger names.
void check_when(const yaml::Node& node, const faults::FaultWhen& when, const Scenario& scenario);
/// Orders and faults that moments name.
void check_moment(const yaml::Node& node, const Moment& moment, const Scenario& scenario);

}  // namespace aprsim::scenario
