"""Cells in the process of the test: the bits of a daemon, arrays, states, errors, and threads."""

import gc
import resource
import threading
import unittest

import numpy as np
from aprsim import AprsimError, BadArgument, Cell, Daemon, Refused, RobotError, Unreachable, World
from aprsim.envs import make, make_vec
from running_cell import PATIENCE


def work(cell):
    """Some commands of all kinds; returns the hash and the step at the end."""
    fanuc, motoman = cell.robot("fanuc"), cell.robot("motoman")
    fanuc.move_by([0, 0, -0.05])
    fanuc.close_gripper()
    cell.set_conveyor(run=True, speed_m_s=0.1)
    motoman.move_by([0.05, 0, 0.02])
    cell.spawn("sku_part_small_gear", "extra", _above_the_table())
    cell.step(300, ["step"])
    fanuc.move_by([0, 0.08, 0.02])
    end = cell.snapshot(["step", "state_hash"])
    return end.step, end.state_hash


def _above_the_table():
    pose = np.eye(4)
    pose[:3, 3] = [0.6, 0.1, 0.3]
    return pose


class WorldTest(unittest.TestCase):
    def setUp(self):
        self.world = World("aprs", seed=5)
        self.addCleanup(self.world.close)

    def test_gives_the_bits_of_a_daemon(self):
        with Daemon(scene="aprs", speed="stepped", start_s=60 * PATIENCE) as daemon:
            with Cell.connect(daemon.ports_file) as cell:
                cell.reset(seed=5)
                expected = work(cell)
        self.assertEqual(work(self.world), expected)

    def test_arrays_are_those_of_the_snapshot(self):
        self.world.robot("fanuc").move_by([0, 0, -0.03], wait=False)
        poses = self.world.body_poses
        self.world.advance(120)
        self.assertIs(self.world.body_poses, poses)
        now = self.world.snapshot()
        names = [body.name for body in self.world.description.bodies]
        for row, name in zip(self.world.body_poses, names):
            np.testing.assert_array_equal(row[:3], now.body(name).position_m)
        robots = [now.robot(robot.name) for robot in self.world.description.robots]
        positions = np.concatenate([robot.joints_rad for robot in robots])
        np.testing.assert_array_equal(self.world.joints[:, 0], positions)
        tools = [robot.tool_in_world[:3, 3] for robot in robots]
        np.testing.assert_array_equal(self.world.tool_poses[:, :3], tools)
        openings = [robot.separation_m for robot in robots]
        np.testing.assert_array_equal(self.world.grippers[:, 0], openings)
        self.assertEqual(self.world.state_hash, now.state_hash)
        self.assertEqual(self.world.step_count, now.step)

    def test_arrays_follow_the_bodies(self):
        count = len(self.world.body_poses)
        self.world.spawn("sku_part_small_gear", "extra", _above_the_table())
        self.assertEqual(len(self.world.body_poses), count + 1)
        self.world.reset()
        self.assertEqual(len(self.world.body_poses), count)
        self.assertEqual(len(self.world.body_velocities), count)

    def test_goes_back_to_the_kept_state(self):
        self.world.advance(10)
        self.world.keep()
        self.world.robot("fanuc").move_by([0, 0, -0.03], wait=False)
        self.world.advance(200)
        once = self.world.state_hash
        self.world.go_back()
        self.assertEqual(self.world.step_count, 10)
        self.world.robot("fanuc").forget_session()
        self.world.robot("fanuc").move_by([0, 0, -0.03], wait=False)
        self.world.advance(200)
        self.assertEqual(self.world.state_hash, once)

    def test_refuses(self):
        with self.assertRaisesRegex(AprsimError, "no_such_scene"):
            World("no_such_scene")
        with self.assertRaises(BadArgument):
            World("aprs", seed=-1)
        with self.assertRaisesRegex(Refused, "no state is saved as 'x'"):
            self.world.load("x")
        with self.assertRaisesRegex(Refused, "no clock"):
            self.world.resume()
        with self.assertRaisesRegex(Refused, "no streams"):
            next(self.world.stream())
        with self.assertRaisesRegex(Refused, "no such call"):
            self.world.cameras()
        with self.assertRaises(RobotError):
            self.world.robot("fanuc").move_by([5, 0, 0])
        self.world.robot("fanuc").initialise()

    def test_is_over_after_close(self):
        robot = self.world.robot("fanuc")
        robot.move_by([0, 0, -0.01])
        self.world.close()
        self.world.close()
        self.assertEqual(self.world.body_poses.shape, (0, 7))
        for call in (self.world.snapshot, self.world.observe, self.world.keep, robot.status):
            with self.assertRaises(Unreachable):
                call()

    def test_arrays_outlive_the_cell_and_its_bodies(self):
        before = self.world.body_poses
        shape = before.shape
        for number in range(5):
            self.world.spawn("sku_part_small_gear", f"extra_{number}", _above_the_table())
            self.world.advance(10)
        self.world.close()
        gc.collect()
        self.assertEqual(before.shape, shape)
        self.assertTrue(np.isfinite(before).all())

    def test_frees_its_memory(self):
        def once():
            with World("aprs") as world:
                world.robot("fanuc").move_by([0, 0, -0.01])
            del world
            gc.collect()

        for _ in range(5):
            once()
        before_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for _ in range(30):
            once()
        self.assertLess(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before_kb, 20_000)

    def test_worlds_in_threads(self):
        results = {}

        def run(number):
            with World("aprs", seed=5) as world:
                results[number] = work(world)

        threads = [threading.Thread(target=run, args=(number,)) for number in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(set(results.values()), {work(self.world)})


class EnvironmentTest(unittest.TestCase):
    def episode(self, **keywords):
        with make("aprsim/Pick-v0", **keywords) as env:
            observation, info = env.reset(seed=3)
            hashes, over = [info["state_hash"]], False
            while not over:
                action = env.scripted_action(observation)
                observation, _, terminated, truncated, info = env.step(action)
                hashes.append(info["state_hash"])
                over = terminated or truncated
        self.assertTrue(info["is_success"])
        return hashes

    def test_the_same_episode_in_both_places(self):
        self.assertEqual(self.episode(), self.episode(in_process=False))

    def test_pictures_need_a_daemon(self):
        with make("aprsim/Pick-v0", render_mode="rgb_array") as env:
            env.reset(seed=1)
            self.assertEqual(env.render().shape[2], 3)
        with self.assertRaisesRegex(Refused, "no such call"):
            make("aprsim/Pick-v0", render_mode="rgb_array", in_process=True)

    def test_side_by_side(self):
        vector = make_vec("aprsim/Push-v0", 3, vectorization_mode="threaded")
        self.addCleanup(vector.close)
        vector.reset(seed=1)
        _, _, _, _, infos = vector.step(np.zeros((3, 5)))
        self.assertEqual(len(set(infos["state_hash"].tolist())), 3)


if __name__ == "__main__":
    unittest.main()
