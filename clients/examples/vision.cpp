// Reads one frame of a robot's overhead camera: the objects that it sees, in its vision frame.
//
//   aprsimd --any-port --ports-file ports.json &
//   APRSIM_PORTS_FILE=ports.json ./vision [ROBOT]

#include <chrono>
#include <iostream>
#include <string>

#include "clients/wires/endpoints.hpp"
#include "clients/wires/vision_feed.hpp"

namespace client = aprsim::client;
using namespace std::chrono_literals;

namespace {

client::Outcome<void> run(const std::string& robot) {
  const auto endpoints = client::find_endpoints({});
  if (!endpoints) return tl::unexpected(endpoints.error());
  auto camera = client::VisionFeed::connect(*endpoints, robot);
  if (!camera) return tl::unexpected(camera.error());

  // The frames before the first exposure are empty.
  auto frame = camera->next(10s);
  while (frame && frame->empty()) frame = camera->next(10s);
  if (!frame) return tl::unexpected(frame.error());

  for (const auto& object : *frame) {
    if (!object.detected) continue;
    std::cout << object.kind << ' ' << object.name << " at (" << 1e3 * object.x_m << ", "
              << 1e3 * object.y_m << ") mm, turned by " << object.rotation_rad << " rad\n";
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  const auto done = run(argc > 1 ? argv[1] : "fanuc");
  if (!done) std::cerr << "vision: " << done.error().message << '\n';
  return done ? 0 : 1;
}
