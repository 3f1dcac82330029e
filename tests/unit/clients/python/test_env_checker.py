"""The check of environments: a correct one passes, and each broken rule is named."""

import unittest

import numpy as np
from aprsim.envs import EnvCheckError, check_env
from aprsim.envs.spaces import Box
from toy_env import ToyEnv


def with_method(name, method):
    """An environment with another method."""
    return type("Broken", (ToyEnv,), {name: method})()


def with_step(change):
    """An environment whose steps return something else."""

    def step(self, action):
        return change(*ToyEnv.step(self, action))

    return with_method("step", step)


def with_reset(change):
    """An environment whose resets return something else."""

    def reset(self, *, seed=None, options=None):
        return change(*ToyEnv.reset(self, seed=seed, options=options))

    return with_method("reset", reset)


def with_attribute(name, value):
    """An environment with another attribute."""
    env = ToyEnv()
    setattr(env, name, value)
    return env


def ignores_seed(self, *, seed=None, options=None):
    return ToyEnv.reset(self, options=options)


def without_options(self, *, seed=None):
    return ToyEnv.reset(self, seed=seed)


def with_default_seed(self, *, seed=7, options=None):
    return ToyEnv.reset(self, seed=seed, options=options)


def random_step(self, action):
    self.drawn = np.random.default_rng().random()
    return ToyEnv.step(self, action)


def closes_once(self):
    if self.closed:
        raise RuntimeError("closed")
    self.closed = 1


def pictures(picture):
    env = with_method("render", lambda self: picture)
    env.render_mode = "rgb_array"
    return env


BROKEN = {
    "no Box": lambda: with_attribute("observation_space", "numbers"),
    "action_space is missing": lambda: with_attribute("action_space", None),
    "not below the upper": lambda: with_attribute("action_space", Box(-np.ones(2), -np.ones(2))),
    "bounds are not -1": lambda: with_attribute("action_space", Box(-2 * np.ones(2), 2 * np.ones(2))),
    "a bound is infinite": lambda: with_attribute(
        "action_space", Box(np.array([-np.inf, -1]), np.ones(2))
    ),
    "bytes from 0 to 255": lambda: with_attribute(
        "observation_space", Box(np.zeros((2, 2, 3)), np.ones((2, 2, 3)))
    ),
    "no list of texts": lambda: with_attribute("metadata", {"render_modes": None}),
    "render_fps": lambda: with_attribute("metadata", {"render_modes": ["rgb_array"]}),
    "render_mode 'human'": lambda: with_attribute("render_mode", "human"),
    "the method seed": lambda: with_method("seed", lambda self, seed: None),
    "takes no options": lambda: with_method("reset", without_options),
    "the default of seed is 7": lambda: with_method("reset", with_default_seed),
    "no tuple of observation and info": lambda: with_reset(lambda seen, info: seen),
    "the info is no dictionary": lambda: with_reset(lambda seen, info: (seen, None)),
    "the same seed gives another observation": lambda: with_method("reset", ignores_seed),
    "outside its space": lambda: with_reset(lambda seen, info: (seen - 1, info)),
    "has float64": lambda: with_reset(lambda seen, info: (seen.astype(np.float64), info)),
    "no numpy array": lambda: with_reset(lambda seen, info: (seen.tolist(), info)),
    "no tuple of five": lambda: with_step(lambda *result: result[:4]),
    "no finite number": lambda: with_step(lambda o, r, te, tr, i: (o, np.nan, te, tr, i)),
    "terminated is 0": lambda: with_step(lambda o, r, te, tr, i: (o, r, 0, tr, i)),
    "step\\(\\): the info": lambda: with_step(lambda o, r, te, tr, i: (o, r, te, tr, [])),
    "truncated after one step": lambda: with_step(lambda o, r, te, tr, i: (o, r, te, True, i)),
    "actions give another observation": lambda: with_method("step", random_step),
    "no array of bytes": lambda: pictures(np.zeros((2, 2, 3))),
    "not height x width x 3": lambda: pictures(np.zeros((2, 2), dtype=np.uint8)),
    "the second close": lambda: with_method("close", closes_once),
}


class Checker(unittest.TestCase):
    def test_a_correct_environment_passes(self):
        for mode in (None, "rgb_array"):
            env = ToyEnv(render_mode=mode)
            check_env(env)
            self.assertEqual(env.closed, 2)
        env = ToyEnv()
        check_env(env, skip_close=True)
        self.assertEqual(env.closed, 0)

    def test_each_broken_rule_is_named(self):
        for words, make in BROKEN.items():
            with self.subTest(words), self.assertRaisesRegex(EnvCheckError, words):
                check_env(make())


if __name__ == "__main__":
    unittest.main()
