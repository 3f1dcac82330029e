"""The example that learns: soft actor-critic solves a small task without a cell, and the program learns and
plays in a cell. Both need torch."""

import csv
import importlib.util
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from aprsim.envs import SyncVectorEnv
from aprsim.envs.spaces import Box, Env
from running_cell import PACKAGE, PATIENCE

PROGRAM = PACKAGE / "examples" / "learn.py"


class Reach(Env):
    """A point that has to come within 10 mm of the origin; an action of 1 moves it by 50 mm."""

    def __init__(self):
        self.observation_space = Box(-np.ones(2), np.ones(2))
        self.action_space = Box(-np.ones(2), np.ones(2))

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.point, self.steps = self.np_random.uniform(-0.1, 0.1, 2), 0
        return self.look(), {}

    def look(self):
        return self.point.astype(np.float32)

    def step(self, action):
        before = np.linalg.norm(self.point)
        self.point = self.point + 0.05 * np.clip(action, -1, 1)
        after = np.linalg.norm(self.point)
        self.steps += 1
        done = bool(after < 0.01)
        cut = not done and self.steps >= 5
        return self.look(), float(before - after + done), done, cut, {"is_success": done}


@unittest.skipUnless(importlib.util.find_spec("torch"), "torch is not installed")
class Learning(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        sys.path.insert(0, str(PROGRAM.parent))
        import learn
        import torch

        torch.set_num_threads(1)
        cls.learn = learn

    def learn_to_reach(self, steps):
        envs = SyncVectorEnv([Reach] * 2, "SameStep")
        settings = self.learn.Settings(demonstrations=0, hidden=32, batch=64, random_steps=200)
        return self.learn.learn(envs, steps, 1, settings)

    def test_a_policy_becomes_better(self):
        novice, _ = self.learn_to_reach(2)
        agent, curve = self.learn_to_reach(1400)
        before, after = (self.learn.evaluate(each, Reach(), 100, 9) for each in (novice, agent))
        self.assertLess(before, 0.3)
        self.assertGreater(after, 0.9)
        first, last = (np.mean([e["return"] for e in part]) for part in (curve[:40], curve[-40:]))
        self.assertGreater(last, first + 0.3)

    def test_the_same_seed_learns_the_same(self):
        one, other = (self.learn_to_reach(300)[0] for _ in range(2))
        seen = np.random.default_rng(1).uniform(-0.1, 0.1, (20, 2))
        np.testing.assert_array_equal(one.act(seen, random=False), other.act(seen, random=False))
        self.assertGreater(np.abs(one.act(seen, random=False)).max(), 0)

    def test_a_policy_file_holds_the_policy(self):
        agent, _ = self.learn_to_reach(260)
        seen = np.random.default_rng(2).uniform(-0.1, 0.1, (20, 2))
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "policy.npz")
            agent.save(path)
            again = self.learn.Agent.load(path)
        np.testing.assert_array_equal(again.act(seen, random=False), agent.act(seen, random=False))


@unittest.skipUnless(importlib.util.find_spec("torch"), "torch is not installed")
class Program(unittest.TestCase):
    def run_it(self, *arguments):
        done = subprocess.run(
            [sys.executable, str(PROGRAM), *arguments],
            capture_output=True, text=True, timeout=200 * PATIENCE,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_learns_and_plays(self):
        with tempfile.TemporaryDirectory() as folder:
            policy, curve = (os.path.join(folder, name) for name in ("policy.npz", "curve.csv"))
            self.run_it(
                "--steps", "340", "--demonstrations", "2", "--policy", policy, "--curve", curve
            )
            with open(curve, encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
            self.assertGreaterEqual(len(rows), 340 // 30 - 2)
            self.assertTrue(all(float(row["length"]) <= 30 for row in rows))
            self.assertLessEqual(float(rows[-1]["steps"]), 340)
            said = self.run_it("--play", policy, "--episodes", "1")
            self.assertRegex(said, r"Pick: \d+\.0 % of 1 episodes succeed")


if __name__ == "__main__":
    unittest.main()
