#pragma once

#include <string>

#include "clients/aprsim/demo/demo_cell.hpp"
#include "clients/wires/endpoints.hpp"

namespace aprsim::client {

/// Runs the belt over Modbus until it has brought the part tray that lies farthest upstream or
/// downstream of a robot before it, stops it, and checks that the tray came along by friction.
/// Returns the tray's name; empty when there is no belt or nothing on it that needs bringing.
/// The belt is commanded to stop in every case.
[[nodiscard]] Outcome<std::string> bring_tray(DemoCell& cell, const Endpoints& endpoints,
                                              const std::string& robot);

}  // namespace aprsim::client
