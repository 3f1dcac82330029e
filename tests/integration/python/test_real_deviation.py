"""Deviations of real and simulated machines, in recorded time."""

import random
import unittest

import numpy as np
from aprsim.real.base.deviation import Comparison


class ComparisonTest(unittest.TestCase):
    """Random tool paths, sampled with jitter at about 50 Hz by two readers."""

    MOST_M, MOST_S = 1.5e-3, 0.04

    def path(self, chance):
        """Smooth moves with rests, as a function of time."""
        marks = [np.zeros(3)]
        for _ in range(8):
            step = np.array([chance.uniform(-0.15, 0.15) for _ in range(3)])
            marks += [marks[-1] + step] * chance.choice([1, 2])

        def at(time_s):
            index = min(max(int(time_s), 0), len(marks) - 2)
            share = min(max(time_s - index, 0.0), 1.0)
            smooth = share**3 * (10 - 15 * share + 6 * share * share)
            return marks[index] + smooth * (marks[index + 1] - marks[index])

        return at

    def alarms(self, chance, *, off=lambda at: np.zeros(3), late_s=0.0, from_s=0.0):
        """Alarms with their times; from `from_s` the simulated robot is off and late."""
        path, comparison, at_s, out = self.path(chance), Comparison(
            most_distance_m=self.MOST_M, most_delay_s=self.MOST_S
        ), 0.0, []
        while at_s < 8:
            at_s += chance.uniform(0.015, 0.03)
            noise = [np.array([chance.gauss(0, 2e-5) for _ in range(3)]) for _ in range(2)]
            comparison.add_real(at_s, path(at_s) + noise[0])
            now_s = at_s + chance.uniform(0.001, 0.01)
            applies = now_s >= from_s
            comparison.add_simulated(
                now_s, path(now_s - (late_s if applies else 0)) + noise[1] + (off(now_s) if applies else 0)
            )
            if alarm := comparison.alarm():
                out.append((at_s, alarm))
        return out

    def test_no_alarm_while_times_are_uncertain(self):
        """Each time is wrong by up to what the sample says."""
        for seed in range(6):
            chance = random.Random(seed)
            path, at_s = self.path(chance), 0.0
            comparison = Comparison(most_distance_m=self.MOST_M, most_delay_s=self.MOST_S)
            while at_s < 6:
                at_s += chance.uniform(0.02, 0.03)
                bounds = [chance.choice([0.001, 0.001, 0.012]) for _ in range(2)]
                wrong = [chance.uniform(-bound, bound) for bound in bounds]
                comparison.add_real(at_s, path(at_s + wrong[0]), bounds[0])
                comparison.add_simulated(at_s, path(at_s + wrong[1]), bounds[1])
                self.assertEqual(comparison.alarm(), "", (seed, at_s))

    def test_no_alarm_while_they_do_the_same(self):
        for seed in range(12):
            self.assertEqual(self.alarms(random.Random(seed)), [], seed)

    def test_two_millimetres_are_told_within_a_second(self):
        for seed in range(12):
            chance = random.Random(seed)
            way = np.array([chance.gauss(0, 1) for _ in range(3)])
            way *= 2e-3 / np.linalg.norm(way)
            found = self.alarms(chance, off=lambda at, way=way: way, from_s=4.0)
            self.assertTrue(found, seed)
            self.assertGreaterEqual(found[0][0], 4.0)
            self.assertLess(found[0][0], 5.0, found[0])

    def test_fifty_milliseconds_are_told_in_the_next_motion(self):
        for seed in range(12):
            for late_s in (0.05, -0.05):
                found = self.alarms(random.Random(seed), late_s=late_s)
                self.assertTrue(found, (seed, late_s))
                words = "simulated" if late_s > 0 else "real"
                # In the first motion; later alarms may call the beginning of a motion a distance.
                self.assertTrue(any(f"the {words} one is" in text for _, text in found), found[:3])
                self.assertLess(found[0][0], 1.0)


if __name__ == "__main__":
    unittest.main()
