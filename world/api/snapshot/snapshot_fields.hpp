#pragma once

#include "world/api/commands/command_fields.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/api/values/value_fields.hpp"
#include "world/base/fields.hpp"

/// The fields of a snapshot; see world/base/fields.hpp.
namespace aprsim::api {

APRSIM_FIELDS(VisionDetection, BY_HAND(body), FIELD(x_m), FIELD(y_m), FIELD(rotation_rad),
              FIELD(score))
APRSIM_FIELDS(VisionFrame, FIELD(number), FIELD_AS(time, sim_time), BY_HAND(detections))

APRSIM_FIELDS(JointSnapshot, FIELD(position_rad), FIELD(velocity_rad_s), FIELD(torque_nm),
              NOWHERE(tool_lever_m))
APRSIM_FIELDS(GripperSnapshot, FIELD(setting), FIELD(separation_m), FIELD(travel_m), FIELD(force_n),
              FIELD(holding), BY_HAND(held_body), FIELD(palm_deflection_m), NOWHERE(max_force_n),
              FIELD(vacuum_pa))
APRSIM_FIELDS(ActionStatus, FIELD(ticket), FIELD(state), FIELD(description), FIELD(kind))
APRSIM_FIELDS(StreamEnd, FIELD(stream), FIELD(result), FIELD(text))
APRSIM_FIELDS(MotionSnapshot, FIELD(source), FIELD(phase), FIELD(commander), FIELD(stream),
              FIELD(points_left), FIELD(points_done), FIELD(time), FIELD(end_time),
              BY_HAND(reference_rad), BY_HAND(reference_rad_s), FIELD(alarm), BY_HAND(ends))
APRSIM_FIELDS(RobotSnapshot, BY_HAND(joints), FIELD_AS(X_WT, tool_in_world),
              FIELD_AS(X_RT, tool_in_reference), FIELD_AS(v_RT, tool_velocity_m_s),
              FIELD_AS(omega_RT, tool_angular_velocity_rad_s), FIELD_AS(force_T_R, tool_force_n),
              FIELD_AS(torque_T_R, tool_torque_nm), BY_HAND(gripper), NOWHERE(trans_speed),
              NOWHERE(trans_accel), NOWHERE(rot_speed), NOWHERE(rot_accel),
              NOWHERE(override_fraction), NOWHERE(tool_mounted), FIELD(tool), FIELD(action),
              FIELD(planning), FIELD_AS(planned_path, planned_path_m),
              FIELD_AS(X_RG, goal_in_reference), FIELD(initialized), FIELD(protective_stop),
              FIELD(moving), FIELD(drives_on), NOWHERE(light_curtain_broken), NOWHERE(posture),
              NOWHERE(guards), FIELD(motion), BY_HAND(vision))

APRSIM_FIELDS(PhotoEyeSnapshot, FIELD(broken), FIELD(count))
APRSIM_FIELDS(ConveyorSnapshot, FIELD(run), FIELD(forward), FIELD(speed_setting_m_s),
              FIELD(speed_m_s), FIELD(travel_m), FIELD(emergency_stop), FIELD(fault),
              FIELD(motor_current_a), FIELD(load_kg), BY_HAND(photo_eyes))

APRSIM_FIELDS(BodySnapshot, FIELD_AS(X_WB, body_in_world), FIELD_AS(v_W, velocity_m_s),
              FIELD_AS(omega_W, angular_velocity_rad_s), FIELD(resting), FIELD(group_kind),
              FIELD(group), FIELD(lost_step))
APRSIM_FIELDS(ToolSnapshot, FIELD_AS(X_WT, tool_in_world), FIELD(robot), FIELD(separation_m),
              FIELD(resting), FIELD(lost_step))

APRSIM_FIELDS(DeviceSnapshot, BY_HAND(signals), FIELD(fault))

APRSIM_FIELDS(ContactSide, BY_HAND(kind), BY_HAND(index), BY_HAND(part))
APRSIM_FIELDS(ContactSnapshot, BY_HAND(first), BY_HAND(second), FIELD_AS(p_W, point_m),
              FIELD_AS(f_W, force_n))
APRSIM_FIELDS(UnintendedContact, BY_HAND(first), BY_HAND(second), FIELD(begin_step),
              FIELD(last_step), FIELD(max_force_n))

APRSIM_FIELDS(SolverFailures, FIELD(not_converged), FIELD(max_residual_m_s))
APRSIM_FIELDS(SolverStep, FIELD(iterations), FIELD(residual_m_s))

APRSIM_FIELDS(VirtualTimeState, FIELD(paced), FIELD(pacers), FIELD(awaited), FIELD(expired),
              FIELD(fallbacks))

APRSIM_FIELDS(Snapshot, BY_HAND(cell), FIELD(epoch), NOWHERE(loaded_state), FIELD(step),
              FIELD_AS(time, sim_time), FIELD_AS(applied, applied_ticket), NOWHERE(failures),
              FIELD(paused), FIELD(speed_target), FIELD(virtual_time), FIELD(real_time_factor),
              FIELD(missed_steps), BY_HAND(step_time_s), FIELD(plan_waits), NOWHERE(saved_states),
              NOWHERE(runs), BY_HAND(robots), BY_HAND(conveyor), BY_HAND(light_curtain),
              FIELD(intruder), BY_HAND(faults), BY_HAND(bodies), BY_HAND(tools), BY_HAND(devices),
              FIELD(contact_count), BY_HAND(contacts), BY_HAND(unintended_contacts),
              FIELD(virtual_joint_count), FIELD(max_penetration_m), FIELD(physics_faults),
              FIELD(solver_failures), FIELD(solver_step), FIELD(world_fault), FIELD(world_stops),
              FIELD(last_event))

}  // namespace aprsim::api
