"""Injects a fault at an event, and sees it wait, last and end."""

from aprsim import Cell, faults

with Cell.connect() as cell:
    was_running = not cell.paused
    cell.pause()
    fault = cell.inject_fault(
        "gripper-leak", "fanuc", {"over": 0.5}, when=faults.Reported("shift-begins"), duration_s=1
    )
    for event in (None, "shift-begins", None, None):
        if event:
            cell.report_event(event)
        snapshot = cell.step(600)
        now = {f.id: f for f in snapshot.injected_faults}[fault.id]
        print(f"{snapshot.sim_time_s:6.2f} s  {now.kind}: state {now.state}")
    if was_running:
        cell.resume()
