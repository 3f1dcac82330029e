"""Environments side by side: seeds, autoreset, infos, errors, in one thread and in many."""

import threading
import unittest

import numpy as np
from aprsim import AprsimError, BadArgument
from aprsim.envs import AutoresetMode, EnvSpec, SyncVectorEnv, ThreadedVectorEnv, make, make_vec
from aprsim.envs import register, spec, specs
from toy_env import ToyEnv

KINDS = (SyncVectorEnv, ThreadedVectorEnv)
NOTHING = np.zeros((3, 2))


def lengths(*counts):
    """Functions that make environments with episodes of these lengths."""
    return [lambda count=count: ToyEnv(count) for count in counts]


class Vector(unittest.TestCase):
    def each(self, *counts, **keywords):
        for kind in KINDS:
            with self.subTest(kind.__name__):
                vector = kind(lengths(*counts), **keywords)
                self.addCleanup(vector.close)
                yield vector

    def test_seeds(self):
        for vector in self.each(3, 3, 3):
            first, infos = vector.reset(seed=5)
            for i in range(3):
                alone, info = ToyEnv().reset(seed=5 + i)
                np.testing.assert_array_equal(first[i], alone)
                self.assertEqual(infos["drawn"][i], info["drawn"])
            self.assertTrue(infos["_drawn"].all())
            self.assertEqual(vector.np_random_seed, (5, 6, 7))
            self.assertIn(first, vector.observation_space)
            listed, _ = vector.reset(seed=[7, None, 5])
            np.testing.assert_array_equal(listed[[2, 0]], first[[0, 2]])
            with self.assertRaisesRegex(BadArgument, "seed: .*a list of 3"):
                vector.reset(seed=[1, 2])

    def test_next_step(self):
        for vector in self.each(1, 2, 9):
            self.assertEqual(vector.metadata["autoreset_mode"], AutoresetMode.NEXT_STEP)
            vector.reset(seed=1)
            seen, rewards, ended, cut, infos = vector.step(np.ones((3, 2)))
            self.assertEqual(ended.tolist(), [True, False, False])
            self.assertFalse(cut.any())
            self.assertEqual(rewards.tolist(), [2, 2, 2])
            self.assertEqual(infos["text"].tolist(), ["last", None, None])
            self.assertEqual(infos["part"]["count"].tolist(), [1, 0, 0])
            self.assertEqual(infos["_count"].tolist(), [False, True, True])
            seen, rewards, ended, _, infos = vector.step(np.ones((3, 2)))
            self.assertEqual(seen[:, 0].tolist(), [0, 2, 2], "the first begins its next episode")
            self.assertEqual(rewards.tolist(), [0, 2, 2], "its action is ignored")
            self.assertEqual(ended.tolist(), [False, True, False])
            self.assertEqual(infos["_drawn"].tolist(), [True, False, False])

    def test_same_step(self):
        for vector in self.each(1, 2, 9, autoreset_mode="SameStep"):
            first, _ = vector.reset(seed=1)
            seen, rewards, ended, _, infos = vector.step(NOTHING)
            self.assertEqual(ended.tolist(), [True, False, False])
            self.assertEqual(seen[:, 0].tolist(), [0, 1, 1])
            self.assertEqual(infos["final_obs"][0][0], 1, "of the end")
            self.assertIsNone(infos["final_obs"][1])
            self.assertEqual(infos["final_info"]["part"]["count"].tolist(), [1, 0, 0])
            self.assertEqual(infos["_final_info"].tolist(), [True, False, False])
            self.assertNotEqual(seen[0, 1], first[0, 1], "another episode")

    def test_disabled(self):
        for vector in self.each(1, 2, 9, autoreset_mode=AutoresetMode.DISABLED):
            before, _ = vector.reset(seed=1)
            vector.step(NOTHING)
            with self.assertRaisesRegex(AprsimError, r"the episodes of \[0\] are over"):
                vector.step(NOTHING)
            options = {"reset_mask": np.array([True, False, False]), "other": 1}
            seen, _ = vector.reset(options=options)
            self.assertIn("reset_mask", options, "the caller's dictionary is unchanged")
            self.assertEqual(seen[:, 0].tolist(), [0, 1, 1])
            self.assertEqual(vector.get_attr("options"), ({"other": 1}, None, None))
            self.assertEqual(vector.step(NOTHING)[2].tolist(), [True, True, False])
            for mask in ([True] * 3, np.ones(3), np.zeros(3, dtype=bool), np.ones(2, dtype=bool)):
                with self.assertRaisesRegex(BadArgument, "options: reset_mask"):
                    vector.reset(options={"reset_mask": mask})

    def test_an_error_of_one_comes_after_the_steps_of_all(self):
        def fail(action):
            raise AprsimError("it fails")

        for vector in self.each(9, 9, 9):
            vector.reset(seed=1)
            vector.envs[1].step = fail
            with self.assertRaisesRegex(AprsimError, "it fails"):
                vector.step(NOTHING)
            self.assertEqual([vector.envs[i].count for i in (0, 2)], [1, 1])

    def test_order_and_arguments(self):
        for vector in self.each(9, 9, 9):
            with self.assertRaisesRegex(AprsimError, "no episodes have begun"):
                vector.step(NOTHING)
            vector.reset()
            with self.assertRaisesRegex(AprsimError, "6 finite numbers"):
                vector.step(np.zeros(5))
            with self.assertRaisesRegex(BadArgument, "an array of shape"):
                vector.step(np.zeros((2, 3)))
            with self.assertRaisesRegex(BadArgument, "values: "):
                vector.set_attr("length", [1, 2])
            vector.set_attr("length", [4, 5, 6])
            self.assertEqual(vector.get_attr("length"), (4, 5, 6))
        for kind in KINDS:
            with self.assertRaisesRegex(BadArgument, "env_fns"):
                kind([])
            with self.assertRaisesRegex(BadArgument, "NextStep or SameStep or Disabled"):
                kind(lengths(1), autoreset_mode="Never")

    def test_close(self):
        for vector in self.each(9, 9, 9):
            envs = vector.envs
            vector.close()
            vector.close()
            self.assertEqual([env.closed for env in envs], [1, 1, 1])

    def test_environments_that_cannot_be_made_close_the_others(self):
        made = []

        def good():
            made.append(ToyEnv())
            return made[-1]

        def bad():
            raise AprsimError("no daemon")

        for kind in KINDS:
            made.clear()
            with self.assertRaisesRegex(AprsimError, "no daemon"):
                kind([good, bad])
            self.assertEqual([env.closed for env in made], [1])

    def test_threads(self):
        seen = set()

        class Noting(ToyEnv):
            def step(self, action):
                seen.add(threading.get_ident())
                met.wait(60)  # all are in their step at the same time
                return super().step(action)

        met = threading.Barrier(3)
        vector = ThreadedVectorEnv([Noting] * 3)
        self.addCleanup(vector.close)
        vector.reset(seed=1)
        vector.step(NOTHING)
        vector.step(NOTHING)
        self.assertEqual(len(seen), 3, "the same thread for each step of an environment")

    def test_pictures(self):
        for kind in KINDS:
            vector = kind([lambda: ToyEnv(render_mode="rgb_array")] * 2)
            self.addCleanup(vector.close)
            self.assertEqual([picture.shape for picture in vector.render()], [(4, 6, 3)] * 2)
            self.assertEqual(vector.render_mode, "rgb_array")


class Registry(unittest.TestCase):
    def test_names(self):
        tasks = {f"aprsim/{name}-v0" for name in ("Pick", "Place", "Kit", "TwoArms", "BeltPick", "Push")}
        self.assertEqual(tasks & set(specs), tasks)
        self.assertEqual(spec("aprsim/Kit-v0").max_episode_steps, 600)
        with self.assertRaisesRegex(BadArgument, "id: 'aprsim/None-v0', where one of aprsim/BeltPick-v0"):
            make("aprsim/None-v0")

    def test_own_environments(self):
        if "toy/Count-v0" not in specs:
            register(EnvSpec("toy/Count-v0", "toy_env:ToyEnv", 7, {"length": 4}))
        env = make("toy/Count-v0")
        self.assertEqual((env.length, env.max_steps), (4, 7))
        self.assertEqual(make("toy/Count-v0", max_episode_steps=2, length=1).max_steps, 2)
        with self.assertRaisesRegex(BadArgument, "toy/Count-v0: .*colour"):
            make("toy/Count-v0", colour=1)
        with self.assertRaisesRegex(BadArgument, "registered already"):
            register(EnvSpec("toy/Count-v0", "toy_env:ToyEnv"))
        for mode in ("sync", "threaded"):
            with make_vec("toy/Count-v0", 2, vectorization_mode=mode).envs[0] as first:
                self.assertEqual(first.length, 4)
        with self.assertRaisesRegex(BadArgument, "vectorization_mode"):
            make_vec("toy/Count-v0", 2, vectorization_mode="forked")
        with self.assertRaisesRegex(BadArgument, "num_envs"):
            make_vec("toy/Count-v0", 0)
        with self.assertRaisesRegex(BadArgument, "one cell cannot serve several"):
            make_vec("toy/Count-v0", 2, cell=object())


if __name__ == "__main__":
    unittest.main()
