"""Kinds of actions of the environments."""

import unittest

import numpy as np
from aprsim import BadArgument
from aprsim.envs import VELOCITY_RAD_S, PushEnv
from running_cell import WithEnvs


class Actions(WithEnvs):
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
