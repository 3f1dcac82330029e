"""Moves the Motoman's first joint to and fro along a timed trajectory, and shows how well it follows."""

import math

import numpy as np

from aprsim import Cell, Feedback, Trajectory

with Cell.connect() as cell:
    robot = cell.robot("motoman")
    start = cell.snapshot(["robots"]).robot("motoman").joints_rad
    times = np.linspace(0, 2, 21)
    swing = np.zeros((len(times), len(start)))
    swing[:, 0] = 1
    rate = 2 * math.pi / times[-1]
    trajectory = Trajectory(
        times,
        start + 0.1 * swing * (1 - np.cos(rate * times))[:, None],
        0.1 * rate * swing * np.sin(rate * times)[:, None],
    )
    errors: list[float] = []

    def note(feedback: Feedback) -> None:
        errors.append(float(np.abs(feedback.actual_rad - feedback.desired_rad).max()))

    done = robot.follow(trajectory, goal_tolerance_rad=0.001, on_feedback=note)
    print(f"{done.result}, at most {1e3 * max(errors):.3f} mrad from the trajectory")
