"""Tasks beside those with resting gears and one robot: push a tray, pick from the moving belt, two robots
at once."""

import unittest

import numpy as np
from aprsim import AprsimError, BadArgument
from aprsim.envs import BeltPickEnv, PushEnv, TwoArmsEnv
from running_cell import WithEnvs


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


class Tasks(WithEnvs):
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

    def test_picks_from_the_moving_belt(self):
        env, info = self.check_seeds(BeltPickEnv)
        state = env.cell.snapshot()
        self.assertEqual(state.robot("motoman").held_body, info["gear"])
        speed = state.body(info["slot"].split("/")[0]).velocity_m_s[0]
        self.assertTrue(0.002 <= abs(speed) <= 0.01, speed)
        self.assertAlmostEqual(env._state()[10], speed, 5)
        with self.assertRaisesRegex(BadArgument, "belt_m_s: 1, where a number"):
            BeltPickEnv(env.cell, belt_m_s=1)
        with self.assertRaisesRegex(AprsimError, "no kit tray"):
            BeltPickEnv(env.cell, reach_m=0.1)

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


if __name__ == "__main__":
    unittest.main()
