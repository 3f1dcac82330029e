"""An environment without a cell: it counts, and ends when the count is reached."""

import numpy as np
from aprsim.envs.spaces import Box, Env


class ToyEnv(Env):
    """The observation is the number of steps and a random number of the episode; the reward is the sum of
    the action."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 5}

    def __init__(self, length=3, render_mode=None, max_steps=None):
        self.length, self.render_mode, self.max_steps = length, render_mode, max_steps
        self.observation_space = Box(np.zeros(2), np.array([100, 1]))
        self.action_space = Box(-np.ones(2), np.ones(2))
        self.closed = 0

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.options = options
        self.count, self.drawn = 0, self.np_random.random()
        return self.look(), {"drawn": self.drawn}

    def step(self, action):
        self.count += 1
        done = self.count == self.length
        info = {"text": "last", "part": {"count": self.count}} if done else {"count": self.count}
        return self.look(), float(np.sum(action)), done, False, info

    def look(self):
        return np.array([self.count, self.drawn], dtype=np.float32)

    def render(self):
        return np.zeros((4, 6, 3), dtype=np.uint8) if self.render_mode else None

    def close(self):
        self.closed += 1
