#pragma once

#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

/// Sliding body and its support.
enum class Slider {
  kTray,          ///< an empty tray on the belt
  kLoadedTray,    ///< a tray with four gears on the belt
  kGear,          ///< a gear on a tray without pockets, which sticks to the belt
  kGearInPocket,  ///< a gear in its pocket, free to move by the clearance
};
const char* name_of(Slider slider);

/// The belt carries it at a steady speed, then accelerates for a while, then is steady again.
struct SlideCase {
  scene::Simplification mode = scene::Simplification::kOff;
  Slider slider = Slider::kTray;
  double tilt_rad = 0;     ///< of the belt, its forward direction uphill
  double heading_rad = 0;  ///< of the belt and all on it, about the world's z
  double friction = 0.3;   ///< of the pair that slides
  double accel_m_s2 = 0;   ///< of the belt
  double accelerating_s = 0.1;
};

/// Highest acceleration at which Coulomb friction carries the slider.
double limit_accel(const SlideCase& slide);
/// How far it lags behind in the end, in continuous time; 0 below the limit.
double closed_form_slip(const SlideCase& slide);

struct SlideResult {
  double slip_m = 0;  ///< how far it lagged behind along the belt
  int breaks = 0;     ///< times that a part and its tray ceased to be simplified together
};
SlideResult slide(const SlideCase& slide);

}  // namespace aprsim::bench
