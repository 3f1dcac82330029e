#pragma once

#include "world/api/description/cell_description.hpp"
#include "world/api/values/value_fields.hpp"
#include "world/base/fields.hpp"

/// The fields of the description of a cell; see world/base/fields.hpp.
namespace aprsim::api {

APRSIM_FIELDS(JointDescription, FIELD(name), FIELD(lower_rad), FIELD(upper_rad),
              FIELD(max_speed_rad_s), FIELD(max_torque_nm), FIELD(prismatic))
APRSIM_FIELDS(GripperDescription, FIELD(stroke_m), FIELD(gap_open_m), FIELD(gap_closed_m),
              FIELD(force_n), NOWHERE(proportional), FIELD(cup_radius_m), NOWHERE(names))
APRSIM_FIELDS(RobotDescription, FIELD(name), FIELD(model), FIELD(joints), NOWHERE(links),
              NOWHERE(wire_joints), NOWHERE(clamps_targets), FIELD_AS(X_WB, base_in_world),
              FIELD_AS(X_BR, reference_in_base), FIELD_AS(X_RV, vision_in_reference),
              FIELD_AS(X_FT, tool_in_flange), FIELD_AS(X_FQ, coupling_in_flange),
              FIELD_AS(tool_point_F, tool_point_in_flange), FIELD(gripper), NOWHERE(reach_min_R),
              NOWHERE(reach_max_R), FIELD(max_trans_speed_m_s), FIELD(max_trans_accel_m_s2),
              FIELD(max_rot_speed_rad_s), FIELD(max_rot_accel_rad_s2))
APRSIM_FIELDS(BoxDescription, FIELD_AS(centre, centre_m), FIELD_AS(size, size_m))
APRSIM_FIELDS(ToolDescription, FIELD(name), FIELD(mass_kg), FIELD(gripper),
              FIELD_AS(X_QT, tool_in_coupling), FIELD(listed), FIELD(palm), FIELD(neck),
              FIELD_AS(finger_size, finger_size_m), BY_HAND(cup), FIELD(v_half_angle_rad))
APRSIM_FIELDS(SlotDescription, FIELD(name), FIELD(gear_type), FIELD_AS(X_PS, slot_in_tray),
              FIELD(pocket_depth_m), BY_HAND(pocket_outline))
APRSIM_FIELDS(BodyDescription, FIELD(name), FIELD(type), FIELD(kind), FIELD(mass_kg),
              BY_HAND(slots), BY_HAND(disc_radius_m), BY_HAND(disc_height_m), BY_HAND(peg_radius_m),
              BY_HAND(peg_top_m), BY_HAND(box_min), BY_HAND(box_max), BY_HAND(outline),
              BY_HAND(label_size_m), BY_HAND(label_depth_m), BY_HAND(pieces), BY_HAND(material))
APRSIM_FIELDS(PhotoEyeDescription, FIELD(name), FIELD(x_m), FIELD(height_m))
APRSIM_FIELDS(ConveyorDescription, FIELD_AS(X_WC, belt_in_world), FIELD(length_m), FIELD(width_m),
              FIELD(max_speed_m_s), FIELD(max_accel_m_s2), FIELD(max_decel_m_s2),
              FIELD(emergency_decel_m_s2), FIELD(photo_eyes))
APRSIM_FIELDS(CameraDescription, FIELD(name), FIELD(robot), FIELD(carrier), BY_HAND(X_PC),
              FIELD(width_px), FIELD(height_px), FIELD(focal_x_px), FIELD(focal_y_px),
              FIELD(centre_x_px), FIELD(centre_y_px), FIELD(distortion), FIELD(rate_hz),
              FIELD(latency_s))
APRSIM_FIELDS(InputDescription, FIELD(signal), FIELD(min), FIELD(max), FIELD(unit))
APRSIM_FIELDS(DeviceDescription, FIELD(name), FIELD(extension), FIELD(signals), FIELD(inputs))
APRSIM_FIELDS(Register, FIELD(signal), FIELD(area), FIELD(address), FIELD(encoding),
              FIELD(word_order), FIELD(scale), FIELD(offset), FIELD(writable))
APRSIM_FIELDS(RegisterMap, FIELD(name), FIELD(registers))
APRSIM_FIELDS(CellDescription, FIELD(scene), NOWHERE(scene_text), BY_HAND(revision), FIELD(seed),
              FIELD(step_size), FIELD(robots), BY_HAND(has_conveyor), BY_HAND(conveyor),
              FIELD(light_curtain), BY_HAND(bodies), BY_HAND(tools), FIELD(body_types),
              FIELD(fixed), BY_HAND(fixtures), BY_HAND(cameras), FIELD(devices),
              FIELD(modbus_servers))

}  // namespace aprsim::api
