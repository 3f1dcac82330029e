#include "world/render/camera_faults.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::render {
namespace {

using faults::Kind;

/// Adds one fault. False where the camera takes no pictures.
bool add(const api::InjectedFault& fault, scene::Camera& camera) {
  const auto value = [&fault](std::string_view parameter) {
    return api::InjectedFaults::value(fault, parameter);
  };
  switch (fault.kind) {
    case Kind::kPictureOutage:
      return false;
    case Kind::kPictureDirt:
      camera.dirt.push_back({.share = value("share"),
                             .spots = static_cast<int>(value("spots")),
                             .size = value("size"),
                             .pattern = fault.id});
      return true;
    case Kind::kPictureFlicker:
      camera.flicker.push_back({.share = value("share"), .rate_hz = value("rate")});
      return true;
    case Kind::kPictureNoise:
      camera.noise = std::hypot(camera.noise, value("deviation"));
      return true;
    case Kind::kPictureLate:
      camera.latency_s += value("delay");
      return true;
    case Kind::kPictureSlow:
      camera.rate_hz = std::min(camera.rate_hz, value("rate"));
      return true;
    case Kind::kPictureQuality:
      camera.jpeg_quality = std::min(camera.jpeg_quality, static_cast<int>(value("quality")));
      return true;
    default:
      return true;
  }
}

}  // namespace

std::optional<scene::Camera> with_faults(scene::Camera camera, const api::InjectedFaults* faults) {
  if (faults == nullptr) return camera;
  for (const api::InjectedFault& fault : faults->all) {
    if (fault.state != api::FaultState::kActive || fault.target != camera.name ||
        faults::info(fault.kind).target != faults::Target::kCamera) {
      continue;
    }
    if (!add(fault, camera)) return std::nullopt;
  }
  return camera;
}

}  // namespace aprsim::render
