#pragma once

#include <array>
#include <optional>
#include <vector>

#include "world/api/description/cell_description.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/scene/model/free_body.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::sensors {

/// What the belt's sensors see of the free bodies: light barriers straight across the belt, and the
/// mass over it. Bodies only: arms and grippers do not break a beam. Thread: one at a time.
class PhotoEyes {
 public:
  explicit PhotoEyes(const scene::Conveyor& conveyor);

  /// Whether a body at a pose is in the beam of one of the eyes.
  [[nodiscard]] bool breaks(std::size_t eye, const scene::FreeBody& body, const Pose& X_WB) const;
  /// Whether a body stands over the belt, near enough above it to be carried.
  [[nodiscard]] bool carries(const Pose& X_WB) const;

  /// From the next look on the eyes say this, whatever is in their beams; none = what they see.
  void set_stuck(const std::array<std::optional<bool>, api::kMaxPhotoEyes>& stuck) {
    stuck_ = stuck;
  }

  /// Starts to look anew at all bodies of one instant: `see` each of them, then `finish`.
  void begin();
  void see(const scene::FreeBody& body, const Pose& X_WB);
  /// Counts the beams that have become broken since the last look. The first look counts none.
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
