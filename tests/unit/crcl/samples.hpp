#pragma once

#include <string>

#include "crcl/documents.hpp"
#include "crcl/status.hpp"

namespace aprsim::crcl {

/// A CRCLCommandInstance with the elements of one command inside.
inline std::string instance(const std::string& type, const std::string& body,
                            const std::string& after = "") {
  return "<CRCLCommandInstance><CRCLCommand "
         "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:type=\"" +
         type + "\">" + body + "</CRCLCommand>" + after + "</CRCLCommandInstance>";
}

inline std::string with_id(const std::string& type, const std::string& body) {
  return instance(type, "<CommandID>7</CommandID>" + body);
}

inline std::string pose_xml(const std::string& point = "<X>1</X><Y>2</Y><Z>3</Z>") {
  return "<Point>" + point +
         "</Point><XAxis><I>1</I><J>0</J><K>0</K></XAxis><ZAxis><I>0</I><J>0</J><K>-1</K></ZAxis>";
}

/// Every field that a status can have, none at its default.
inline Status full_status() {
  Status status;
  status.name = "S<1>";
  status.command = {"MoveToType", 12, 345, CommandState::kError, "joint 3 & so on", "p.xml", 4,
                    22,           100};
  status.joints = {{1, 10.5, std::nullopt, std::nullopt}, {3, -0.0, 1.25, -1e-17}};
  status.pose = PoseStatus{{{1.5, -2.25, 1.0 / 3}, {0, 1, 0}, {0, 0, -1}},
                           Twist{{1, 2, 3}, {4, 5, 6}},
                           Wrench{{-1, -2, -3}, {0.1, 0.2, 0.3}},
                           "elbow up"};
  status.gripper = GripperStatus{"parallel.gripper", {{"o", "v"}}, true, ParallelGripper{44.5}};
  SettingsStatus settings;
  settings.angle_unit = AngleUnit::kDegree;
  settings.end_effector_parameters = {{"a", "1"}, {"b", "2"}};
  settings.end_effector = 1;
  settings.force_unit = ForceUnit::kPound;
  settings.joint_limits = {{1, -170, 170, 60, 450}, {2, std::nullopt, 145, std::nullopt, 1}};
  settings.intermediate_tolerance = PoseTolerance{1, std::nullopt, 2, std::nullopt, 3};
  settings.length_unit = LengthUnit::kMillimeter;
  settings.max_cartesian = Vector{1, 2, 3};
  settings.min_cartesian = Vector{-1, -2, -3};
  settings.coordinated = true;
  settings.end_tolerance = PoseTolerance{1, 2, 3, 4, 5};
  settings.robot_parameters = {{"p", "q"}};
  settings.rot_accel = Rate{false, 100};
  settings.rot_speed = Rate{true, 0.5};
  settings.torque_unit = TorqueUnit::kFootPound;
  settings.trans_accel = Rate{true, 0.25};
  settings.trans_speed = Rate{false, 200};
  settings.joint_tolerances = {{1, 0.5}, {2, 0.75}};
  status.settings = settings;
  status.sensors =
      SensorStatuses{{{{"part_present", 7, 1620650990951, {{"host", "h1"}}}, true}},
                     {{{"joint_torque_2", 8, 1620650990952, {}}, -1.5}},
                     {{{"parts", 9, 1620650990953, {}}, -3}},
                     {{{"force_torque", 10, 1620650990954, {}}, {1, 2, -3.5}, {0.1, 0.2, 0.3}}}};
  status.guards =
      GuardsStatuses{{{"down", "force_torque", "Fz", GuardLimit::kDecreaseBeyondLimit, 0.5, 20, 11,
                       1620650990955, -0.625, true, false},
                      {{}, "part_present", {}, GuardLimit::kOverMax, 0, {}, {}, {}, {}, {}, {}}},
                     1,
                     5000,
                     -0.625,
                     Pose{{1, 2, 3}, {1, 0, 0}, {0, 0, -1}}};
  return status;
}

}  // namespace aprsim::crcl
