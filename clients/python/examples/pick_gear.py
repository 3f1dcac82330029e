"""Takes a gear by its peg, lifts it and puts it back."""

from aprsim import Cell
from aprsim.envs.layout import Layout
from aprsim.poses import yaw_of

GEAR, ABOVE_M = "part_medium_gear_1", 0.06

with Cell.connect() as cell:
    fanuc = cell.robot("fanuc")
    yaw = yaw_of(fanuc.tool())
    gear = Layout(cell.description, cell.snapshot()).gears[GEAR]
    grasp = gear.position_m + [0, 0, gear.grasp_height_m]
    above = grasp + [0, 0, ABOVE_M]
    fanuc.set_speed(0.4)
    fanuc.open_gripper()
    fanuc.move_to(above, yaw)
    fanuc.move_to(grasp, yaw, straight=True)
    fanuc.close_gripper()
    fanuc.dwell(0.3)
    fanuc.move_to(above, yaw, straight=True)
    state = cell.snapshot()
    lifted = state.body(GEAR).position_m[2] - gear.position_m[2]
    print(f"holds {state.robot('fanuc').held_body}, {1e3 * lifted:.1f} mm over its tray")
    fanuc.move_to(grasp, yaw, straight=True)
    fanuc.open_gripper()
    fanuc.dwell(0.3)
    fanuc.move_to(above, yaw, straight=True)
