#include "server/replay/wire_moments.hpp"

namespace aprsim::server::journal {

bool WireMoments::add(world::RunTime time, const api::Snapshot& snapshot) {
  // A request before a reset may be answered after it.
  const bool follows = !empty() && (time.epoch == now().epoch
                                        ? time.step == now().step || time.step == now().step + 1
                                        : time.epoch == now().epoch + 1);
  if (!follows) moments_.clear();
  api::Snapshot& kept = moments_.emplace_back(Moment{time, {}}).snapshot;
  kept.cell = snapshot.cell;
  kept.step = snapshot.step;
  kept.time = snapshot.time;
  kept.robots = snapshot.robots;
  for (api::RobotSnapshot& robot : kept.robots) robot.vision = {};
  kept.conveyor = snapshot.conveyor;
  kept.light_curtain = snapshot.light_curtain;
  kept.devices = snapshot.devices;
  kept.world_fault = snapshot.world_fault;
  if (moments_.size() > kMost) moments_.pop_front();
  return follows;
}

void WireMoments::each_back(world::RunTime from, world::RunTime to,
                            const std::function<bool(const api::Snapshot&)>& visit) const {
  for (auto moment = moments_.rbegin(); moment != moments_.rend() && moment->time >= from;
       ++moment) {
    if (moment->time <= to && !visit(moment->snapshot)) return;
  }
}

}  // namespace aprsim::server::journal
