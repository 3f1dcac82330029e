"""Timed joint trajectories over gRPC: blocking and asyncio robots, results, one commander, replay."""

import asyncio
import math
import pathlib
import subprocess
import tempfile
import threading
import unittest

import numpy as np
from aprsim import (
    BadArgument,
    Cell,
    Refused,
    RobotError,
    TimedOut,
    Trajectory,
    TrajectoryError,
    aio,
)
from aprsim.binaries import find_binary
from running_cell import PATIENCE, WithCell, await_that


def swing(start, by=0.2, duration=2.0, count=21, joint=0):
    """A joint goes `by` rad and back, from rest to rest."""
    times = np.linspace(0, duration, count)
    rate = 2 * math.pi / duration
    positions = np.tile(np.asarray(start), (count, 1))
    velocities = np.zeros_like(positions)
    positions[:, joint] += by / 2 * (1 - np.cos(rate * times))
    velocities[:, joint] = by / 2 * rate * np.sin(rate * times)
    velocities[-1] = 0
    return Trajectory(times, positions, velocities)


class FollowTest(WithCell):
    def joints(self, name="motoman"):
        return self.cell.snapshot(["robots"]).robot(name).joints_rad

    def test_reaches_the_goal_without_a_session(self):
        robot = self.cell.robot("motoman")
        start = self.joints()
        seen = []
        done = robot.follow(swing(start), on_feedback=seen.append, feedback_s=0.2)
        self.assertEqual(done.result, "SUCCESSFUL")
        np.testing.assert_allclose(self.joints(), start, atol=1e-12)
        self.assertGreater(len(seen), 2)
        self.assertAlmostEqual(max(f.desired_rad[0] for f in seen) - start[0], 0.2, delta=0.05)
        for feedback in seen:
            np.testing.assert_allclose(feedback.actual_rad, feedback.desired_rad, atol=1e-9)
        self.assertFalse(self.cell.snapshot().robot("motoman").message.initialized)

    def test_gives_the_same_bits_each_time(self):
        hashes = []
        for _ in range(2):
            self.cell.reset()
            self.cell.robot("motoman").follow(swing(self.joints()))
            snapshot = self.cell.snapshot()
            hashes.append((snapshot.step, snapshot.state_hash))
        self.assertEqual(hashes[0], hashes[1])

    def test_names_give_the_order(self):
        robot = self.cell.robot("fanuc")
        names = [joint.name for joint in robot.description.joints][::-1]
        trajectory = swing(self.joints("fanuc")[::-1], joint=5, by=0.1)
        named = Trajectory(
            trajectory.times_s, trajectory.positions_rad, trajectory.velocities_rad_s, joints=names
        )
        robot.follow(named)
        wrong = Trajectory([1.0], [[0.0] * 6], joints=["a", *names[1:]])
        with self.assertRaisesRegex(TrajectoryError, "no joint is called 'a'") as caught:
            robot.follow(wrong)
        self.assertEqual(caught.exception.result, "INVALID_JOINTS")

    def test_refusals_name_joint_value_and_limit(self):
        robot = self.cell.robot("fanuc")
        start = self.joints("fanuc")
        far = start.copy()
        far[1] = 3.0
        cases = (
            (Trajectory([10.0], [far]), "INVALID_GOAL", "joint_2: position 3 rad.* limit 2.5"),
            (swing(start, by=2.0, duration=0.5), "INVALID_GOAL", "joint_1: speed"),
            (Trajectory([0.0, 1.0], [start + 0.1, start]), "INVALID_GOAL", "the robot is at"),
        )
        for trajectory, result, text in cases:
            with self.assertRaisesRegex(TrajectoryError, text) as caught:
                robot.follow(trajectory)
            self.assertEqual(caught.exception.result, result)
        self.cell.step(10)
        with self.assertRaises(TrajectoryError) as caught:
            robot.follow(swing(start), start_s=0.001)
        self.assertEqual(caught.exception.result, "OLD_HEADER_TIMESTAMP")

    def test_errors_name_argument_shape_and_unit(self):
        robot = self.cell.robot("fanuc")
        cases = (
            (lambda: Trajectory([0, 1], np.zeros((3, 6))), "positions_rad.*2 x joints.*rad"),
            (lambda: Trajectory([1, 1], np.zeros((2, 6))), "times_s.*increasing numbers.* s"),
            (lambda: Trajectory([1], [[0.0] * 6], [[0.0] * 5]), "velocities_rad_s.*1 x 6.*rad/s"),
            (lambda: robot.follow(Trajectory([1], [[0.0] * 7])), "trajectory.*6 joints in rad"),
            (lambda: robot.follow([[0.0] * 6]), "trajectory.*aprsim.Trajectory"),
            (
                lambda: robot.follow(swing([0.0] * 6), path_tolerance_rad=[1, 2]),
                "path_tolerance_rad.*6 finite numbers in rad",
            ),
            (lambda: robot.follow(swing([0.0] * 6), goal_time_s=-1), "goal_time_s.* s"),
        )
        for call, text in cases:
            with self.assertRaisesRegex(BadArgument, text):
                call()

    def test_one_commander_at_a_time(self):
        robot = self.cell.robot("fanuc")
        self.cell.resume()
        failures = []

        def follow():
            try:
                robot.follow(swing(start, duration=600.0))
            except TrajectoryError as error:
                failures.append(error)

        start = self.joints("fanuc")
        follower = threading.Thread(target=follow)
        follower.start()
        with Cell.connect(self.daemon.ports_file) as other:
            await_that(
                lambda: other.snapshot().robot("fanuc").commander, "the stream has not begun"
            )
            self.assertIn("gRPC", other.snapshot().robot("fanuc").commander)
            with self.assertRaisesRegex(Refused, "busy: .* has the robot") as caught:
                other.robot("fanuc").follow(swing(start))
            self.assertEqual(caught.exception.code, "FAILED_PRECONDITION")
            with self.assertRaisesRegex(RobotError, "busy: .* has the robot"):
                other.robot("fanuc").take()
            self.assertIn("has the robot by a stream", other.robot("fanuc").status().description or "")
            other.robot("fanuc").stop()
        follower.join(60 * PATIENCE)
        self.assertEqual([error.result for error in failures], ["STOPPED"])
        self.assertEqual(self.cell.snapshot().robot("fanuc").commander, "")

    def test_a_timeout_stops_the_robot(self):
        robot = self.cell.robot("fanuc")
        with self.assertRaisesRegex(TimedOut, "has not ended within 0.5 s"):
            robot.follow(swing(self.joints("fanuc")), timeout_s=0.5)
        self.cell.step(1)
        await_that(
            lambda: not self.cell.step(10).robot("fanuc").commander, "the stream has not ended"
        )
        ends = self.cell.snapshot().robot("fanuc").message.motion.ends
        self.assertEqual(ends[-1].text, "cancelled")

    def test_a_stop_ends_it_and_a_reset_continues(self):
        robot = self.cell.robot("fanuc")
        start = self.joints("fanuc")
        self.cell.inject_fault("protective-stop", "fanuc")
        with self.assertRaisesRegex(TrajectoryError, "Protective stop") as caught:
            robot.follow(swing(start))
        self.assertEqual(caught.exception.result, "STOPPED")
        self.cell.step(500)
        self.assertIn("Protective stop", self.cell.snapshot().robot("fanuc").alarm)
        with self.assertRaisesRegex(Refused, "alarm: Protective stop"):
            robot.follow(swing(self.joints("fanuc")))
        done = robot.follow(swing(self.joints("fanuc")), reset=True)
        self.assertEqual(done.result, "SUCCESSFUL")

    def test_a_saved_state_continues_bit_for_bit(self):
        robot = self.cell.robot("motoman")
        start = self.joints()
        trajectory = swing(start, duration=4.0)
        hashes = []

        def save(feedback):
            if feedback.time_s > 1 and not hashes:
                self.cell.save("middle")
                hashes.append(0)

        robot.follow(trajectory, on_feedback=save)
        end = self.cell.step(100)
        self.cell.load("middle")
        again = self.cell.step(end.step - self.cell.snapshot().step)
        self.assertEqual(again.state_hash, end.state_hash)
        ends = again.robot("motoman").message.motion.ends
        self.assertEqual(len(ends), 1)

    def test_a_replay_gives_the_same_bits(self):
        self.cell.robot("motoman").follow(swing(self.joints()))
        self.cell.robot("fanuc").follow(swing(self.joints("fanuc"), by=-0.3))
        self.cell.step(50)
        with tempfile.TemporaryDirectory() as folder:
            journal = pathlib.Path(folder, "incident.journal")
            journal.write_bytes(self.cell.incident(60))
            done = subprocess.run(
                [find_binary("aprsim"), "replay", str(journal)],
                capture_output=True, text=True, timeout=120 * PATIENCE,
            )
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_asyncio_follows_two_robots_at_once(self):
        async def both():
            async with await aio.Cell.connect(self.daemon.ports_file) as cell:
                await cell.set_speed(math.inf)
                await cell.resume()
                robots = [await cell.robot(name) for name in ("fanuc", "motoman")]
                state = await cell.snapshot(["robots"])
                done = await asyncio.gather(
                    *(robot.follow(swing(state.robot(robot.name).joints_rad)) for robot in robots)
                )
                await cell.pause()
                with self.assertRaises(TrajectoryError):
                    await robots[0].follow(Trajectory([1.0], [[9.0] * 6]))
                paused = await robots[0].follow(swing(state.robot("fanuc").joints_rad))
                return [one.result for one in (*done, paused)]

        self.assertEqual(asyncio.run(both()), ["SUCCESSFUL"] * 3)

    def test_a_cancelled_task_stops_the_robot(self):
        async def cancel():
            async with await aio.Cell.connect(self.daemon.ports_file) as cell:
                await cell.resume()
                robot = await cell.robot("fanuc")
                start = (await cell.snapshot(["robots"])).robot("fanuc").joints_rad
                begun = asyncio.Event()
                task = asyncio.create_task(
                    robot.follow(swing(start, duration=600.0), on_feedback=lambda _: begun.set())
                )
                await asyncio.wait_for(begun.wait(), 60 * PATIENCE)
                task.cancel()
                with self.assertRaises(asyncio.CancelledError):
                    await task

        asyncio.run(cancel())
        await_that(
            lambda: not self.cell.snapshot().robot("fanuc").commander, "the robot still moves"
        )


if __name__ == "__main__":
    unittest.main()
