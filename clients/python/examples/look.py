"""Looks at the cell, and lowers a robot's tool by 50 mm."""

from aprsim import Cell

with Cell.connect() as cell:
    before = cell.snapshot()
    print(f"{cell.description.scene}: {len(before.robots)} robots, {len(before.bodies)} bodies")
    fanuc = cell.robot("fanuc")
    fanuc.move_by([0, 0, -0.05])
    lowered = before.robot("fanuc").tool_in_world[2, 3] - fanuc.tool()[2, 3]
    print(f"the tool is {1e3 * lowered:.1f} mm lower")
