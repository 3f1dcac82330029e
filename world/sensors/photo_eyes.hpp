#pragma once

#include <array>
#include <optional>
#include <vector>

#include "world/api/description/cell_description.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/scene/model/free_body.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::sensors {

/// Sensors of the belt: light barriers straight across it, and the mass over it. They detect free
/// bodies only: arms and grippers do not break a beam. Thread: one at a time.
class PhotoEyes {
 public:
  explicit PhotoEyes(const scene::Conveyor& conveyor);

  /// Whether a body at a pose is in the beam of one of the eyes.
  [[nodiscard]] bool breaks(std::size_t eye, const scene::FreeBody& body, const Pose& X_WB) const;
  /// Whether a body is over the belt, low enough to be carried.
  [[nodiscard]] bool carries(const Pose& X_WB) const;

  /// From the next reading on, overrides the eyes' readings; none = as measured.
  void set_stuck(const std::array<std::optional<bool>, api::kMaxPhotoEyes>& stuck) {
    stuck_ = stuck;
  }

  /// Begins a reading of all bodies at one instant: `see` each of them, then `finish`.
  void begin();
  void see(const scene::FreeBody& body, const Pose& X_WB);
  /// Counts the beams that have become broken since the last reading. The first one counts none.
  void finish();

  [[nodiscard]] const std::array<api::PhotoEyeSnapshot, api::kMaxPhotoEyes>& eyes() const {
    return eyes_;
  }
  [[nodiscard]] double load_kg() const { return load_kg_; }

  static constexpr bool kAsMany = true;  ///< as the scene has
  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [beams, X_WC, X_CW, half_length_m, half_width_m, eyes, broken, stuck, load_kg, looked] =
        self;
    io(eyes, broken, stuck, load_kg, looked);
  }

 private:
  std::vector<scene::PhotoEye> beams_;
  Eigen::Isometry3d X_WC_, X_CW_;
  double half_length_m_, half_width_m_;
  std::array<api::PhotoEyeSnapshot, api::kMaxPhotoEyes> eyes_;
  std::array<bool, api::kMaxPhotoEyes> broken_{};
  std::array<std::optional<bool>, api::kMaxPhotoEyes> stuck_{};
  double load_kg_ = 0;
  bool looked_ = false;
};

}  // namespace aprsim::sensors
