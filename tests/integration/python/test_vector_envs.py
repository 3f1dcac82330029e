"""Environments of daemons side by side, and the check of their rules."""

import importlib.util
import unittest

import numpy as np
from aprsim.envs import AutoresetMode, check_env, make, make_vec


class Rules(unittest.TestCase):
    def test_the_check(self):
        for name, keywords in {
            "Pick": {"render_mode": "rgb_array"},
            "Push": {"action": "joint_velocity", "rate_hz": 100},
        }.items():
            with self.subTest(name):
                check_env(make(f"aprsim/{name}-v0", **keywords))

    def test_time_limit(self):
        with make("aprsim/Push-v0", max_episode_steps=2) as env:
            env.reset(seed=1)
            ends = [env.step(np.zeros(5))[2:4] for _ in range(2)]
        self.assertEqual(ends, [(False, False), (False, True)])


@unittest.skipUnless(importlib.util.find_spec("gymnasium"), "Gymnasium is not installed")
class InGymnasium(unittest.TestCase):
    def test_its_own_check_and_time_limit(self):
        import gymnasium
        from gymnasium.utils import env_checker

        env = gymnasium.make("aprsim/Push-v0", max_episode_steps=2)
        env_checker.check_env(env.unwrapped)
        env.reset(seed=1)
        ends = [env.step(env.action_space.sample())[3] for _ in range(2)]
        env.close()
        self.assertEqual(ends, [False, True])


class Vector(unittest.TestCase):
    def run_one(self, mode):
        """Observations, ends and hashes of some steps across the ends of episodes."""
        vector = make_vec(
            "aprsim/Pick-v0", 2, vectorization_mode=mode,
            autoreset_mode=AutoresetMode.SAME_STEP, max_episode_steps=3,
        )
        self.addCleanup(vector.close)
        seen, infos = vector.reset(seed=5)
        trace = [(seen.tobytes(), infos["state_hash"].tolist())]
        for _ in range(4):
            actions = [env.scripted_action(row) for env, row in zip(vector.envs, seen)]
            seen, _, ended, cut, infos = vector.step(np.stack(actions))
            self.assertIn(seen, vector.observation_space)
            trace.append((seen.tobytes(), ended.tolist(), cut.tolist(), infos["state_hash"].tolist()))
        return vector, trace

    def test_threads_have_the_same_bits(self):
        threaded, trace = self.run_one("threaded")
        self.assertEqual([cut for _, _, cut, _ in trace[1:]], [[False] * 2] * 2 + [[True] * 2, [False] * 2])
        vector, same = self.run_one("sync")
        self.assertEqual(same, trace)
        self.assertNotEqual(*trace[0][1], "each environment has a seed of its own")
        for envs in (threaded, vector):
            envs.close()

    def test_daemons_end_with_the_environments(self):
        vector = make_vec("aprsim/Push-v0", 2, vectorization_mode="threaded", in_process=False)
        daemons = [env._daemon.process for env in vector.envs]
        vector.close()
        self.assertTrue(all(daemon.poll() is not None for daemon in daemons))


if __name__ == "__main__":
    unittest.main()
