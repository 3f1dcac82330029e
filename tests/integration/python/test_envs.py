"""The environments: the tasks can be done, seeds give the same bits, and resets are exact."""

import unittest

import numpy as np
from aprsim import AprsimError, BadArgument
from aprsim.envs import KitEnv, PickEnv, PlaceEnv, scripted_action
from running_cell import WithEnvs


def episode(env, seed, policy=scripted_action, **options):
    """Every observation, reward and hash of the state, and the end."""
    observation, info = env.reset(seed=seed, **options)
    trace = [(observation.tobytes(), 0.0, info["state_hash"])]
    while True:
        assert env.observation_space.contains(observation), observation
        observation, reward, terminated, truncated, info = env.step(policy(observation))
        trace.append((observation.tobytes(), reward, info["state_hash"]))
        if terminated or truncated:
            return trace, terminated, info


class Tasks(WithEnvs):
    def test_picks(self):
        env = self.make(PickEnv)
        trace, terminated, info = episode(env, 1)
        self.assertTrue(info["is_success"])
        self.assertTrue(terminated)
        self.assertEqual(env.cell.snapshot().robot("fanuc").held_body, info["gear"])
        self.assertGreater(sum(reward for _, reward, _ in trace), 2, "what it is worth")
        again, _, _ = episode(env, 1)
        self.assertEqual(again, trace, "the same seed, bit for bit")
        other, _, info = episode(env, 2)
        self.assertTrue(info["is_success"])
        self.assertNotEqual(other[0], trace[0])

    def test_places_and_others_with_its_seed_find_the_same(self):
        env = self.make(PlaceEnv)
        trace, _, info = episode(env, 5)
        self.assertTrue(info["is_success"])
        self.assertIsNone(env.cell.snapshot().robot("fanuc").held_body)
        env.close()
        left = [s.name for s in env.cell.saved_states() if s.name.startswith("PlaceEnv")]
        self.assertEqual(left, [], "it forgets what it has saved")
        again, _, _ = episode(self.make(PlaceEnv), 5)
        self.assertEqual(again, trace)

    def test_fills_a_kit(self):
        env = self.make(KitEnv)
        trace, terminated, info = episode(env, 3, options={"tray": "kit_m2l1_vessel_1"})
        self.assertTrue(terminated)
        self.assertTrue(info["is_success"])
        self.assertGreater(sum(reward for _, reward, _ in trace), 3, "one for each of three gears")
        state = env.cell.snapshot()
        tray = state.body("kit_m2l1_vessel_1").position_m
        near = [
            body.type for body in state.bodies.values()
            if body.type.startswith("sku_part") and np.linalg.norm(body.position_m - tray) < 0.1
        ]
        self.assertEqual(
            sorted(near), ["sku_part_large_gear", "sku_part_medium_gear", "sku_part_medium_gear"]
        )

    def test_random_actions_never_break_it(self):
        env = self.make(PickEnv, max_steps=15)
        env.action_space.seed(11)
        env.reset(seed=11)
        ends = 0
        for _ in range(40):
            observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
            self.assertIn(observation, env.observation_space)
            self.assertTrue(np.isfinite(reward))
            if terminated or truncated:
                ends += 1
                env.reset()
        self.assertGreaterEqual(ends, 2)

    def test_a_refusal_is_told_and_got_over(self):
        env = self.make(PickEnv)
        env.reset(seed=1)
        away = np.array([0, 0, 1, 0, 1], dtype=np.float32)
        refused = None
        for _ in range(30):
            _, _, _, _, info = env.step(away)
            refused = refused or info.get("refused")
        self.assertIsNotNone(refused, "no arm reaches 1.5 m higher")
        before = env.cell.snapshot().robot("fanuc").tool_in_world[2, 3]
        env.step(-away)
        self.assertLess(env.cell.snapshot().robot("fanuc").tool_in_world[2, 3], before - 0.02)
        self.assertTrue(episode(env, 1)[2]["is_success"])

    def test_invalid_arguments(self):
        env = self.make(PickEnv)
        with self.assertRaisesRegex(AprsimError, "tray 'x', where kit_m2l1_vessel_1"):
            env.reset(options={"tray": "x"})
        with self.assertRaisesRegex(AprsimError, "where tray and slot are known"):
            env.reset(options={"gear": "x"})
        env.reset(seed=0, options={"tray": "kit_m2l1_vessel_1", "slot": "lg_1"})
        self.assertEqual(env.transfer.slot, "lg_1")
        with self.assertRaisesRegex(AprsimError, "5 finite numbers"):
            env.step([1, 2])
        with self.assertRaisesRegex(AprsimError, "no kit tray"):
            self.make(PickEnv, reach_m=0.1)


class Order(WithEnvs):
    def test_a_step_needs_an_episode(self):
        env = self.make(PickEnv)
        action = [0, 0, 0, 0, 1]
        self.assertIsNone(env.transfer)
        with self.assertRaisesRegex(AprsimError, r"step: no episode has begun; call reset\(\) first"):
            env.step(action)
        env.reset(seed=1)
        env.step(action)
        with self.assertRaisesRegex(AprsimError, "options"):
            env.reset(options={"gear": "x"})
        with self.assertRaisesRegex(AprsimError, "no episode has begun"):
            env.step(action)
        with self.assertRaisesRegex(BadArgument, "seed: -1"):
            env.reset(seed=-1)
        env.close()
        for call in (lambda: env.step(action), env.reset):
            with self.assertRaisesRegex(AprsimError, "the environment is closed"):
                call()
        with self.assertRaisesRegex(BadArgument, "reach_m: 0, where a number above 0 in m"):
            PickEnv(env.cell, reach_m=0)


class Policy(unittest.TestCase):
    def test_refuses_a_picture(self):
        with self.assertRaisesRegex(BadArgument, "observation: .*10 finite numbers"):
            scripted_action(np.zeros((4, 4, 3), dtype=np.uint8))


class Own(unittest.TestCase):
    def test_runs_and_ends_a_daemon_of_its_own(self):
        env = PickEnv(in_process=False)
        daemon = env._daemon.process
        env.reset(seed=1)
        env.close()
        self.assertIsNotNone(daemon.poll())
        env.close()


if __name__ == "__main__":
    unittest.main()
