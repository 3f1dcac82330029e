"""Tasks beside those with one gear: push a tray, two robots at once, joint velocities."""

import unittest

import numpy as np
from aprsim import AprsimError, BadArgument, Cell, Daemon
from aprsim.envs import VELOCITY_RAD_S, PushEnv, TwoArmsEnv
from running_cell import PATIENCE


def episode(env, seed):
    """Observations, rewards and hashes of an episode by the scripted policy, and its last info."""
    observation, info = env.reset(seed=seed)
    trace, over = [(observation.tobytes(), 0.0, int(info["state_hash"]))], False
    while not over:
        assert observation in env.observation_space, observation
        action = env.scripted_action(observation)
        assert action in env.action_space, action
        observation, reward, terminated, truncated, info = env.step(action)
        trace.append((observation.tobytes(), reward, int(info["state_hash"])))
        over = terminated or truncated
    return trace, info


class Tasks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(scene="aprs", speed="stepped", start_s=60 * PATIENCE)
        cls.addClassCleanup(cls.daemon.close)

    def make(self, kind, **arguments):
        cell = Cell.connect(self.daemon.ports_file)
        self.addCleanup(cell.close)
        cell.reset()
        env = kind(cell, **arguments)
        self.addCleanup(env.close)
        return env

    def check_seeds(self, kind):
        """Returns an environment after an episode that is done, with the same bits by the same seed."""
        env = self.make(kind)
        first, info = episode(env, 1)
        self.assertTrue(info["is_success"])
        self.assertGreater(sum(reward for _, reward, _ in first), 1, "its worth")
        self.assertNotEqual(env.reset(seed=2)[0].tobytes(), first[0][0])
        again, info = episode(env, 1)
        self.assertEqual(again, first, "the same seed, bit for bit")
        return env, info

    def test_pushes_a_tray(self):
        env, info = self.check_seeds(PushEnv)
        names = [body.name for body in env.cell.description.bodies]
        tray = env.snapshot().body(info["tray"])
        self.assertIn(info["tray"], names)
        middle = env.observation_names.index("goal_from_tray_x_m")
        self.assertLess(np.linalg.norm(env._state()[middle : middle + 2]), 0.004)
        self.assertTrue(tray.resting)
        self.assertFalse(env.cell.snapshot().robot("fanuc").held_body)
        env.cell.reset()
        self.assertIn("part_medium_gear_1", env.cell.snapshot().bodies, "a reset brings all back")

    def test_pressing_on_the_tray_is_told_and_got_over(self):
        env = self.make(PushEnv)
        begin, _ = env.reset(seed=1)
        observation, refused = begin, None
        for _ in range(8):
            x, y = np.clip(observation[:2] / 0.05, -1, 1)
            observation, _, terminated, _, info = env.step([x, y, -1, 0, -1])
            refused = refused or info.get("refused")
            self.assertFalse(info["is_success"])
            if terminated or refused:
                break
        self.assertRegex(refused, "Protective stop")
        again, _ = env.reset(seed=1)
        self.assertEqual(again.tobytes(), begin.tobytes())
        self.assertNotIn("refused", env.step([0, 0, 0.5, 0, -1])[4])

    def test_two_robots_at_once(self):
        env, info = self.check_seeds(TwoArmsEnv)
        self.assertEqual(env.action_space.shape, (10,))
        self.assertEqual(len(env.observation_names), 20)
        self.assertEqual(set(info["gear"]), {"fanuc", "motoman"})
        state = env.cell.snapshot()
        for robot, gear in info["gear"].items():
            tray, slot = info["slot"][robot].split("/")
            pose = state.body(tray).pose @ env._slots[tray, slot]
            self.assertLess(np.linalg.norm(pose[:3, 3] - state.body(gear).position_m), 0.001)
            self.assertIsNone(state.robot(robot).held_body)
        with self.assertRaisesRegex(AprsimError, "0.1 m of motoman"):
            self.make(TwoArmsEnv, reach_m=(0.62, 0.1))

    def test_joint_velocities(self):
        env = self.make(PushEnv, action="joint_velocity", rate_hz=50)
        self.assertEqual(env.action_space.shape, (7,))
        wanted = np.array([0.2, -0.1, 0.05, 0.0, 0.0, 0.3])

        def run():
            hashes = []
            _, info = env.reset(seed=3)
            begin_s = info["sim_time_s"]
            for _ in range(8):
                _, _, _, _, info = env.step([*wanted, -1])
                hashes.append(int(info["state_hash"]))
            self.assertAlmostEqual(info["sim_time_s"] - begin_s, 8 / 50, 9)
            return hashes

        hashes = run()
        moving = env.snapshot().robot("fanuc").joint_velocities_rad_s
        np.testing.assert_allclose(moving, wanted * VELOCITY_RAD_S, atol=0.005)
        self.assertEqual(run(), hashes)
        for _ in range(8):
            env.step([0] * 6 + [-1])
        rest = env.snapshot().robot("fanuc")
        np.testing.assert_allclose(rest.joint_velocities_rad_s, 0, atol=0.001)

    def test_invalid_arguments(self):
        env = self.make(PushEnv)
        with self.assertRaisesRegex(BadArgument, "options: .'tray'., where none are known"):
            env.reset(options={"tray": "x"})
        for words, arguments in {
            '"pose" or "joint_velocity"': {"action": "torque"},
            "rate_hz: 0.5, where a number from 1 to 250 in Hz": {
                "action": "joint_velocity", "rate_hz": 0.5,
            },
            "rate_hz: 60.0, where a rate whose period": {"action": "joint_velocity", "rate_hz": 60},
            "rate_hz: 50, where None": {"rate_hz": 50},
        }.items():
            with self.subTest(words), self.assertRaisesRegex(BadArgument, words):
                PushEnv(env.cell, **arguments)


if __name__ == "__main__":
    unittest.main()
