"""Copies of real robots, in simulated time: how they go on, join, and how late they are."""

import collections
import math
import random
import unittest
from unittest import mock

import numpy as np
from aprsim.errors import Refused
from aprsim.joint_stream import Taken
from aprsim.real.copies import copy_stream
from aprsim.real.copies.coast import coast
from aprsim.real.copies.copy_stream import CopyStream
from aprsim.real.copies.joining import Motion, join, motion
from aprsim.real.copies.joint_bounds import JointBounds
from aprsim.real.copies.pacing import Pacing

BOUNDS = JointBounds(np.array([-3.0, -2.0]), np.array([3.0, 2.5]), np.array([2.0, 3.0]))
PERIOD_S, DELAY_S = 0.02, 0.025


def cubic(a, b, time_s):
    """Position and velocity between two knots (time, position, velocity)."""
    T, s = b[0] - a[0], (time_s - a[0]) / (b[0] - a[0])
    step = b[1] - a[1] - T * a[2]
    bend, twist = 3 * step - T * (b[2] - a[2]), T * (b[2] - a[2]) - 2 * step
    return a[1] + T * a[2] * s + bend * s**2 + twist * s**3, a[2] + (2 * bend * s + 3 * twist * s**2) / T


class FakeStream:
    """A stream of the cell: curves of third degree, in the time of `clock`."""

    def __init__(self, clock, here):
        self._clock, self._knots = clock, [(0.0, here, 0 * here)]
        self._begun_s = None

    def time_s(self):
        return 0.0 if self._begun_s is None else min(self._clock[0] - self._begun_s, self._knots[-1][0])

    def state(self):
        now_s = self.time_s()
        for a, b in zip(self._knots, self._knots[1:], strict=False):
            if now_s <= b[0]:
                return cubic(a, b, now_s)
        return self._knots[-1][1:]

    def follow(self, points, ends_at_s=None):
        now_s = self.time_s()
        knots = self._knots
        if now_s < knots[-1][0] and ends_at_s is not None and max(ends_at_s, now_s + 1e-3) < knots[-1][0]:
            cut_s = max(ends_at_s, now_s + 1e-3)
            after = next(i for i, knot in enumerate(knots) if knot[0] >= cut_s)
            knots = [*knots[:after], (cut_s, *cubic(knots[after - 1], knots[after], cut_s))]
        if points[0].time_s <= knots[-1][0]:
            raise Refused(f"point 1: time {points[0].time_s} s, must be above {knots[-1][0]} s")
        if now_s >= knots[-1][0]:
            assert not knots[-1][2].any(), "the cell would stop the robot"
            self._begun_s = self._clock[0] - knots[-1][0]
        self._knots = [*knots, *((one.time_s, one.positions_rad, one.velocities_rad_s) for one in points)]
        assert (np.diff([knot[0] for knot in self._knots]) > 0).all()
        return Taken(now_s, self._knots[-1][0])

    def restart(self):
        here = self.state()[0]
        self._knots, self._begun_s = [(0.0, here, 0 * here)], None


class CopyTest(unittest.TestCase):
    def random_state(self, chance):
        here = np.array([chance.uniform(low, high) for low, high in zip(BOUNDS.lower_rad, BOUNDS.upper_rad, strict=True)])
        velocity = np.array([chance.uniform(-1, 1) * speed for speed in BOUNDS.copy_speed_rad_s])
        return here, velocity

    def test_goes_on_and_rests_within_the_ranges(self):
        chance = random.Random(1)
        for _ in range(500):
            here, velocity = self.random_state(chance)
            behind = coast(BOUNDS, here, velocity)
            times = np.linspace(0, behind.lasts_s, 200)
            states = [behind.at(time_s) for time_s in times]
            for a, b, step_s in zip(states, states[1:], np.diff(times), strict=False):
                np.testing.assert_allclose(b[0] - a[0], (a[1] + b[1]) / 2 * step_s, atol=1e-6 + 0.02 * step_s)
                self.assertTrue((np.abs(b[1]) <= np.abs(a[1]) + 1e-12).all())
            if behind.brake_s > 0:
                np.testing.assert_allclose(states[0][1], velocity)
            self.assertFalse(states[-1][1].any())
            self.assertTrue((states[-1][0] >= BOUNDS.lower_rad - 1e-9).all())
            self.assertTrue((states[-1][0] <= BOUNDS.upper_rad + 1e-9).all())
            # Away from the ends of the ranges the brake is that of a copy.
            if behind.coast_s > 0.049:
                self.assertLessEqual((np.abs(velocity) / behind.brake_s / BOUNDS.acceleration_rad_s2).max(), 1 + 1e-9)
            # Curves through the points are the motion itself.
            knots = [(0.0, here, states[0][1]), *behind.points()]
            for a, b in zip(knots, knots[1:], strict=False):
                middle = (a[0] + b[0]) / 2
                np.testing.assert_allclose(cubic(a, b, middle)[0], behind.at(middle)[0], atol=1e-9)

    def test_joins_a_motion_within_the_bounds(self):
        chance, found = random.Random(2), 0
        for _ in range(500):
            here, velocity = self.random_state(chance)
            target = BOUNDS.inside(here + np.array([chance.gauss(0, 0.05) for _ in here]))
            target_rad_s = np.clip(velocity + np.array([chance.gauss(0, 0.5) for _ in here]), -1.9, 1.9)
            due_s = chance.uniform(-0.1, 0.05)
            bend = np.array([chance.gauss(0, 2) for _ in here])
            if (joined := join(BOUNDS, here, velocity, Motion(target, target_rad_s, bend), due_s)) is None:
                continue
            found += 1
            T, last, last_rad_s = joined
            free = target + (T - due_s) * target_rad_s + (T - due_s) ** 2 / 2 * bend
            np.testing.assert_allclose(last, BOUNDS.inside(free), atol=1e-12)
            speed = np.clip(target_rad_s + (T - due_s) * bend, -BOUNDS.copy_speed_rad_s, BOUNDS.copy_speed_rad_s)
            np.testing.assert_allclose(last_rad_s, np.where(free == BOUNDS.inside(free), speed, 0), atol=1e-12)
            a, b = (0.0, here, velocity), (T, last, last_rad_s)
            states = [cubic(a, b, time_s)[1] for time_s in np.linspace(0, T, 400)]
            self.assertTrue((np.abs(states) <= BOUNDS.speed_rad_s).all())
            accelerations = np.abs(np.diff(states, axis=0)) / (T / 399)
            self.assertTrue((accelerations <= 1.01 * BOUNDS.acceleration_rad_s2).all())
        self.assertGreater(found, 300)
        far = Motion(np.array([2.0, 0.0]), np.zeros(2), np.zeros(2))
        self.assertIsNone(join(BOUNDS, np.zeros(2), np.zeros(2), far, 0.0))

    def test_the_motion_of_measurements_is_exact_on_a_parabola(self):
        chance = random.Random(3)
        for count in (2, 3, 5):
            here, velocity = 0.1 * np.ones(2), np.array([chance.uniform(-1, 1) for _ in range(2)])
            bend = np.array([chance.uniform(-3, 3) for _ in range(2)]) if count > 2 else np.zeros(2)
            times = np.cumsum([chance.uniform(0.01, 0.05) for _ in range(count)])
            rows = [(t, here + (t - times[-1]) * velocity + (t - times[-1]) ** 2 / 2 * bend) for t in times]
            found = motion(BOUNDS, rows)
            np.testing.assert_allclose(found.position_rad, here)
            np.testing.assert_allclose(found.velocity_rad_s, velocity, atol=1e-9)
            np.testing.assert_allclose(found.acceleration_rad_s2, bend, atol=1e-7)

    def latencies(self, seed, hiccup_s):
        """For each millisecond of a copy of a swinging robot, where each fifteenth answer is late by up to that: the
        time between the robot's state and the copy's, and the largest acceleration of the copy."""
        chance, clock = random.Random(seed), [100.0]
        rate, phase = chance.uniform(0.5, 2), chance.uniform(0, 6)
        size = np.array([0.6, -0.4])

        def place(at_s):
            return size * math.sin(rate * at_s + phase), size * rate * math.cos(rate * at_s + phase)

        out, accelerations, velocity = [], [], None
        stream = FakeStream(clock, place(clock[0])[0])

        def until(time_s):
            nonlocal velocity
            while clock[0] < time_s:
                clock[0] = min(clock[0] + 1e-3, time_s)
                here, now_rad_s = stream.state()
                if velocity is not None:
                    accelerations.append(np.abs(now_rad_s - velocity).max() / 1e-3)
                velocity = now_rad_s
                if clock[0] > 101 and abs(math.cos(rate * clock[0] + phase)) > 0.5:
                    true, speed = place(clock[0])
                    out.append(float((true - here) @ speed / (speed @ speed)))

        with mock.patch.object(copy_stream.time, "monotonic", lambda: clock[0]):
            copy = CopyStream(stream, BOUNDS, Pacing(BOUNDS, DELAY_S), place(clock[0])[0], collections.deque())
            copy.measure(clock[0], place(clock[0])[0])
            next_s = clock[0] + PERIOD_S
            until(next_s)
            for number in range(400):
                asked_s = clock[0]
                until(asked_s + 5e-4)
                if hiccup_s and number % 15 == 7:
                    until(clock[0] + chance.uniform(0, hiccup_s))
                self.assertTrue(copy.add(asked_s, place(asked_s)[0], keeps_time=False), number)
                next_s = max(next_s + PERIOD_S, clock[0])
                until(next_s)
        return np.array(out), np.array(accelerations)

    def test_is_late_by_one_question_and_5_ms_whatever_comes_late(self):
        for seed in range(3):
            for hiccup_s in (0.0, 0.03, 0.1):
                late_s, accelerations = self.latencies(seed, hiccup_s)
                words = f"{seed} {hiccup_s}"
                self.assertLessEqual(np.median(late_s), DELAY_S + 2e-3, words)
                self.assertGreater(np.median(late_s), DELAY_S - 3e-3, words)
                self.assertLessEqual(np.percentile(late_s, 95), DELAY_S + 2e-3 + hiccup_s, words)
                self.assertLessEqual(np.percentile(accelerations, 97), 1.2 * BOUNDS.acceleration_rad_s2.max(), words)


if __name__ == "__main__":
    unittest.main()
