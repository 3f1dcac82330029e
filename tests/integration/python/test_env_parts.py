"""Tasks with scenes of their own: insert a peg, sort gears from the moving belt."""

import math
import unittest

import numpy as np
from aprsim import AprsimError, BadArgument
from aprsim.envs import InsertEnv, SortEnv, check_env, make, make_vec
from aprsim.poses import matrix
from test_env_tasks import episode


def hold_still(opened):
    return np.array([0, 0, 0, 0, 1 if opened else -1], dtype=np.float32)


class Insert(unittest.TestCase):
    def make(self, **keywords):
        env = make("aprsim/Insert-v0", **keywords)
        self.addCleanup(env.close)
        return env

    def hole_m(self, env):
        """The place of the peg in its hole, from the scene alone."""
        hole, snapshot = env.hole, env.cell.snapshot()
        tray = next(body for body in env.cell.description.bodies if body.name == hole.tray)
        slot = next(slot for slot in tray.tray.slots if slot.name == hole.name)
        return (snapshot.body(hole.tray).pose @ matrix(slot.slot_in_tray))[:3, 3]

    def test_each_peg_is_in_its_hole_to_its_end(self):
        env = self.make()
        for seed, peg in enumerate(("peg_8_1", "peg_12_1", "peg_16_1")):
            with self.subTest(peg):
                _, begin = env.reset(seed=seed, options={"peg": peg})
                self.assertEqual(env.cell.snapshot().robot("fanuc").held_body, peg)
                observation, over = env._state(), False
                while not over:
                    observation, _, terminated, truncated, info = env.step(
                        env.scripted_action(observation)
                    )
                    over = terminated or truncated
                self.assertTrue(info["is_success"])
                self.assertEqual(info["peg"], begin["peg"])
                body = env.cell.snapshot().body(peg)
                away = body.position_m - self.hole_m(env)
                self.assertLess(np.linalg.norm(away[:2]), 0.00006, "half the clearance, and a bit")
                self.assertLess(abs(away[2]), 0.0002, "on the ground of the hole")
                self.assertTrue(body.resting)
                self.assertIsNone(env.cell.snapshot().robot("fanuc").held_body)

    def test_seeds(self):
        env = self.make(hole_error_m=0.0005)
        traces = []
        for seed in range(8):
            trace, info = episode(env, seed)
            self.assertTrue(info["is_success"], seed)
            traces.append(trace)
        self.assertEqual(episode(env, 3)[0], traces[3], "the same seed, bit for bit")
        self.assertEqual(len({trace[0][0] for trace in traces}), 8)
        self.assertEqual(episode(self.make(hole_error_m=0.0005), 3)[0], traces[3])

    def test_the_hole_is_observed_with_an_error(self):
        env, far = self.make(hole_error_m=0.002), 0.0
        for seed in range(6):
            observation, _ = env.reset(seed=seed)
            peg = env.cell.snapshot().body(env.hole.peg).position_m
            error = observation[:3] - (self.hole_m(env) - peg)
            self.assertLess(np.abs(error).max(), 0.002 + 1e-6)
            self.assertLess(abs(error[2]), 1e-6)
            far = max(far, np.abs(error).max())
        self.assertGreater(far, 0.0005)

    def test_a_peg_beside_its_hole_is_no_success(self):
        env = self.make(hole_error_m=0)
        observation, _ = env.reset(seed=2)
        forces = []
        for _ in range(14):
            aside = observation.copy()
            aside[0] += 0.005
            observation, _, terminated, _, info = env.step(env.scripted_action(aside))
            forces.append(np.linalg.norm(observation[8:11]))
            self.assertFalse(info["is_success"])
            if terminated:
                break
        height = env.cell.snapshot().body(env.hole.peg).position_m[2] - self.hole_m(env)[2]
        self.assertGreater(height, 0.02, "the peg stands on the board")
        self.assertGreater(max(forces), 5, "the tool feels it")

    def test_invalid_arguments(self):
        env = self.make()
        with self.assertRaisesRegex(AprsimError, "no episode has begun"):
            env.hole
        with self.assertRaisesRegex(BadArgument, "options: peg 'x', where peg_8_1, peg_12_1"):
            env.reset(options={"peg": "x"})
        with self.assertRaisesRegex(BadArgument, "hole_error_m: -1, where a number from 0 to 0.01"):
            InsertEnv(hole_error_m=-1)
        with self.assertRaisesRegex(AprsimError, "no part with a free hole"):
            InsertEnv(scene="sorting")

    def test_the_check(self):
        check_env(self.make())

    def test_side_by_side(self):
        vector = make_vec("aprsim/Insert-v0", 2)
        self.addCleanup(vector.close)
        seen, _ = vector.reset(seed=4)
        alone = self.make()
        np.testing.assert_array_equal(alone.reset(seed=5)[0], seen[1])


class Sort(unittest.TestCase):
    def make(self, **keywords):
        env = make("aprsim/Sort-v0", **keywords)
        self.addCleanup(env.close)
        return env

    def test_every_gear_rests_in_the_bin_of_its_type(self):
        env = self.make()
        first, info = episode(env, 1)
        self.assertTrue(info["is_success"])
        state = env.cell.snapshot()
        bins = {f.name: matrix(f.fixture_in_world)[:3, 3] for f in env.cell.description.fixtures}
        gears = [body for body in state.bodies.values() if body.type.startswith("sku_part")]
        self.assertEqual(len(gears), 4)
        for gear in gears:
            away = gear.position_m - bins[f"bin_{gear.type}"]
            self.assertTrue(np.all(np.abs(away[:2]) < [0.11, 0.08]), (gear.name, away))
            self.assertTrue(0 < away[2] < 0.04, (gear.name, away))
            self.assertTrue(gear.resting)
        self.assertIsNone(state.robot("fanuc").held_body)
        self.assertTrue(state.conveyor.run)
        self.assertTrue(0.018 <= state.conveyor.speed_m_s <= 0.03)
        self.assertEqual(episode(env, 1)[0], first, "the same seed, bit for bit")
        other, info = episode(env, 2)
        self.assertTrue(info["is_success"])
        self.assertNotEqual(other[0], first[0])

    def test_a_gear_that_passes_the_robot_is_lost(self):
        env = self.make(belt_m_s=0.1)
        env.reset(seed=1)
        over = False
        while not over:
            _, reward, terminated, truncated, info = env.step(hold_still(opened=True))
            over = terminated or truncated
        self.assertTrue(terminated)
        self.assertFalse(info["is_success"])
        self.assertLess(reward, -0.9)
        self.assertGreater(env._state()[env.observation_names.index("along_belt_m")], 0.45)

    def test_the_other_bin_is_no_success(self):
        env = self.make()
        _, info = env.reset(seed=1)
        own = info["bin"]
        frames = {f.name: matrix(f.fixture_in_world) for f in env.cell.description.fixtures}
        done = {}
        for name in sorted(frames, key=lambda name: name == own):
            place = frames[name].copy()
            place[2, 3] += 0.0172
            env.cell.move_body(info["gear"], place)
            for _ in range(3):
                _, _, _, _, after = env.step(hold_still(opened=True))
            done[name] = after["gear"] != info["gear"]
        self.assertEqual(done, {name: name == own for name in frames})

    def test_the_fingers_close_along_the_belt(self):
        env = self.make()
        for seed in range(4):
            observation, _ = env.reset(seed=seed)
            tool = env.cell.snapshot().robot("fanuc").tool_in_world
            turn = observation[env.observation_names.index("turn_to_belt_rad")]
            along = abs(math.cos(math.atan2(tool[1, 1], tool[0, 1])))
            self.assertAlmostEqual(math.cos(turn), along, 5)
            self.assertLess(abs(turn), 0.11)

    def test_invalid_arguments(self):
        with self.assertRaisesRegex(BadArgument, "belt_m_s: 1, where a number"):
            SortEnv(belt_m_s=1)
        with self.assertRaisesRegex(AprsimError, "'taskboard' has no belt"):
            SortEnv(scene="taskboard")
        with self.assertRaisesRegex(AprsimError, "no gear on a belt with a fixture bin_TYPE"):
            SortEnv(scene="aprs")

    def test_the_check(self):
        check_env(self.make())


if __name__ == "__main__":
    unittest.main()
