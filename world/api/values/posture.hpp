#pragma once

namespace aprsim::api {

/// Which of the joint vectors that reach one tool pose an arm is in, as signs.
struct Posture {
  /// A 6-axis arm: +1 facing its wrist, -1 reaching over its back. A 7-axis arm: of joint 2.
  int shoulder = 1;
  /// A 6-axis arm: +1 elbow above the line from shoulder to wrist. A 7-axis arm: of joint 4, of the
  /// elbow's bend where it has an offset. A SCARA: +1 elbow to the left.
  int elbow = 1;
  int wrist = 1;  ///< of the angle of the middle wrist joint
  /// A 7-axis arm's elbow about the line from shoulder to wrist; of arms as Franka's the angle of
  /// joint 7; of other seven-axis arms that of the joint that serves best.
  double elbow_rad = 0;
};

}  // namespace aprsim::api
