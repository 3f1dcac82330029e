"""Recordings of made-up cells with hidden parameters, with the noise that sensors have."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "clients" / "python"))

from aprsim.calibration.belt_fit import speed_at, targets  # noqa: E402
from aprsim.calibration.carried_fit import GRAVITY_M_S2  # noqa: E402
from aprsim.calibration.crcl_documents import Command, Status  # noqa: E402
from aprsim.calibration.line_fit import Correction, KnownObject  # noqa: E402
from aprsim.calibration.modbus_units import RUN, SPEED, BeltRecord  # noqa: E402
from aprsim.calibration.profiles import duration, rest_to_rest  # noqa: E402
from aprsim.calibration.recordings import CameraRecord, ForceLog, RobotRecord, Sighting  # noqa: E402
from aprsim.calibration.simple_message_wires import JointRecord, Point  # noqa: E402


def robot(random):
    """Straight moves of a robot: its record, and the hidden parameters by the estimates' names."""
    speed, accel = random.uniform(0.1, 0.5), random.uniform(0.5, 4)
    ramp, noise, spread = random.uniform(0.2, 0.8) * speed / accel, 2e-5, 0.004
    latency = random.uniform(0.02, 0.2)
    record = RobotRecord()
    now, place = 1.0, np.array([0.3, 0.0, 0.2])
    for number in range(1, 7):
        way = random.uniform(1.3, 3) * speed**2 / accel + 0.05
        target = place + np.array([0.0, way if number % 2 else -way, 0.0])
        record.commands.append(Command(now, "MoveTo", number, straight=True, target_m=target))
        begin = now + random.normal(latency, spread)
        end = begin + duration(way, speed, accel, ramp) + 0.1
        for time in np.arange(now - 0.02, end, 0.03) + random.uniform(0, 0.01):
            s = float(rest_to_rest(np.array([time - begin]), way, speed, accel, ramp)[0])
            at = place + (target - place) * s / way + random.normal(0, noise, 3)
            record.statuses.append(Status(float(time), number, "Working", np.array([]), at, None, None))
            record.status_connections.append(1)
        now, place = end + 0.3, target
    base = "robots.fanuc"
    return record, {
        f"{base}.tool_speed_m_s": speed,
        f"{base}.tool_accel_m_s2": accel,
        f"{base}.tool_accel_ramp_s": ramp,
        f"{base}.command_latency_s": latency,
    }


LIMITS_RAD_S = (7.8, 6.6, 7.2, 9.6, 9.6, 15.0)  # of the joints of the robot of `moves`


def moves(random):
    """Moves from rest to rest of a Fanuc by Simple Message, whose states come with jitter."""
    share, latency, accel = random.uniform(0.05, 0.4), random.uniform(0.02, 0.15), random.uniform(5, 20)
    record, place, now = JointRecord(), np.zeros(10), 1.0
    for number in range(12):
        joint = number % 2
        speed = share * LIMITS_RAD_S[joint]
        way, ramp = random.uniform(1.5, 3) * speed**2 / accel + 0.3 * speed, random.uniform(0.2, 0.6) * speed / accel
        target = place.copy()
        target[joint] += way if number % 4 < 2 else -way
        record.points.append(Point(now, number + 1, target))
        begin = now + random.normal(latency, 0.003)
        end = begin + duration(way, speed, accel, ramp) + 0.2
        states(record, random, now - 0.1, end, 0.024, lambda t: place + (target - place) * float(
            rest_to_rest(np.array([t - begin]), way, speed, accel, ramp)[0]) / way)
        now, place = end + 0.15, target
    base = "robots.fanuc"
    return record, {
        f"{base}.servers.simple_message.joint_speed": share,
        f"{base}.motion_latency_s": latency,
        f"{base}.joint_1_accel_rad_s2": accel,
        f"{base}.joint_2_accel_rad_s2": accel,
    }


def trajectories(random):
    """Streamed trajectories of a Motoman, which follows late and at a pace of its own."""
    latency, pace = random.uniform(0.02, 0.4), random.uniform(0.7, 1.1)
    record, place, now = JointRecord(), np.zeros(10), 1.0
    for _ in range(6):
        turn = np.concatenate([random.uniform(-0.4, 0.4, 7), np.zeros(3)])
        lasts = random.uniform(1.5, 3)
        for number in range(21):
            share = number / 20
            record.points.append(Point(
                now + 0.01 * number, number, place + share * share * (3 - 2 * share) * turn, lasts * share,
                6 * share * (1 - share) / lasts * turn,
            ))  # fmt: skip
        begin, end = now + 0.01 + random.normal(latency, 0.004), now + latency + lasts / pace + 0.3

        def at(t, place=place, turn=turn, begin=begin, lasts=lasts):
            share = min(max((t - begin) * pace / lasts, 0.0), 1.0)
            return place + share * share * (3 - 2 * share) * turn

        states(record, random, now - 0.1, end, 0.025, at)
        now, place = end + 0.15, place + turn
    base = "robots.motoman"
    return record, {f"{base}.motion_latency_s": latency, f"{base}.trajectory_pace": pace}


def states(record, random, begin, end, period, at):
    """States of joints with the noise of encoders, at times that the network changes."""
    for time in np.arange(begin, end, period):
        record.state_times_s.append(float(time + abs(random.normal(0, 3e-4))))
        record.states_rad.append(at(time) + np.concatenate([random.normal(0, 2e-6, 6), np.zeros(4)]))


def belt(random):
    """A belt that is set to some speeds and stopped."""
    gain, accel = random.uniform(0.8e-5, 1.2e-5), random.uniform(0.1, 0.6)
    decel, latency = random.uniform(0.1, 0.6), random.uniform(0.02, 0.15)
    record = BeltRecord()
    now = 0.5
    for counts in random.integers(8000, 30000, 4):
        record.writes += [(now, SPEED, int(counts)), (now, RUN, 1), (now + 4.0, RUN, 0)]
        now += 8.0
    times = np.arange(0, now, 0.05) + random.uniform(0, 0.01)
    speeds = speed_at(times, targets(record), gain, accel, decel, latency)
    record.readings = [
        (float(t), float(v + random.normal(0, 5e-4)), None) for t, v in zip(times, speeds)
    ]
    base = "conveyor"
    return record, {
        f"{base}.m_s_per_count": gain,
        f"{base}.max_accel_m_s2": accel,
        f"{base}.max_decel_m_s2": decel,
        f"{base}.latency_s": latency,
    }


def camera(random):
    """Frames of a camera, the objects that are there, and its errors. Each object is off its place by as
    much as people put it."""
    shift, turn = random.uniform(-0.01, 0.01, 2), random.uniform(-0.03, 0.03)
    noise, rotation, drop, placing = random.uniform(3e-5, 3e-4), 0.2, random.uniform(0.01, 0.1), 2e-4
    places = [(x, y) for x in (0.1, 0.25, 0.4) for y in (-0.2, 0.0, 0.2)]
    known = [KnownObject("sku_part_large_gear", x, y, 0.0) for x, y in places]
    true = np.array(places)
    seen = Correction(true.mean(axis=0), shift, turn).reported(true + random.normal(0, placing, true.shape))
    record = CameraRecord()
    for frame in range(40):
        record.times_s.append(0.1 * frame)
        record.frames.append(
            [
                Sighting(
                    "sku_part_large_gear", "P", math.radians(random.normal(0, rotation)),
                    x + random.normal(0, noise), y + random.normal(0, noise),
                )
                for x, y in seen
                if random.random() > drop
            ]
        )
    base = "robots.fanuc.vision"
    return (record, known), {
        f"{base}.bias_x_m": shift[0],
        f"{base}.bias_y_m": shift[1],
        f"{base}.bias_yaw_rad": turn,
        f"{base}.position_noise_m": noise,
        f"{base}.rotation_noise_deg": rotation,
        f"{base}.drop_rate": drop,
    }


def carried(random, friction=None):
    """A camera over a belt, whose starts and stops are too fast for the trays on it."""
    latency, noise = random.uniform(0.03, 0.4), random.uniform(5e-5, 3e-4)
    friction = random.uniform(0.02, 0.05) if friction is None else friction
    accel, angle = random.uniform(0.6, 1.5), random.uniform(-math.pi, math.pi)
    step = 1e-3
    time = np.arange(0, 24, step)
    wanted = np.zeros(len(time))
    for number in range(5):
        wanted[(time > 1 + 4 * number) & (time < 3 + 4 * number)] = random.uniform(0.12, 0.3) * (1 if number % 2 else -1)
    belt, tray = np.zeros(len(time)), np.zeros(len(time))
    most = friction * GRAVITY_M_S2 * step
    for i in range(1, len(time)):
        belt[i] = belt[i - 1] + np.clip(wanted[i] - belt[i - 1], -accel * step, accel * step)
        tray[i] = tray[i - 1] + np.clip(belt[i] - tray[i - 1], -most, most)
    ways = [np.concatenate([[0], np.cumsum(0.5 * (v[1:] + v[:-1]) * step)]) for v in (belt, tray)]
    record = BeltRecord()
    for at in np.arange(0, 23.9, 0.02) + random.uniform(0, 0.01):
        record.readings.append((float(at), float(np.interp(at, time, belt)), float(np.interp(at, time, ways[0]))))
    lines = CameraRecord()
    places = random.uniform(-0.3, 0.3, (3, 2))
    for at in np.arange(0.5, 23.5, 0.1) + random.uniform(0, 0.05):
        way = np.interp(at - latency, time, ways[1]) * np.array([math.cos(angle), math.sin(angle)])
        lines.times_s.append(float(at))
        lines.frames.append([
            Sighting(f"sku_kit_{i}", "KT", 0.0, *(place + way + random.normal(0, noise, 2)))
            for i, place in enumerate(places)
        ])  # fmt: skip
    return (lines, record), {"robots.fanuc.vision.latency_s": latency, "physics.friction.tray_belt": friction}


def force(random):
    """A tool that is pressed down until a guard stops it, and held, several times."""
    bias, drift = random.uniform(-40, 40, 3), random.uniform(-0.01, 0.01, 3)
    noise, guard = random.uniform(0.01, 0.05), 0.5
    stiffness, damping = random.uniform(4e3, 2e4), random.uniform(100, 600)
    share, tau = random.uniform(0.08, 0.2), random.uniform(0.8, 2)
    delay, speed, period = random.uniform(0.03, 0.12), 0.01, 0.012
    rows = []
    now = 0.0
    for press in range(6):
        contact = -0.1085 + random.uniform(-4e-4, 4e-4)
        start = contact + random.uniform(0.008, 0.009)
        touch = now + (start - contact) / speed
        trigger = touch + max(guard - damping * speed, 0.0) / stiffness / speed
        stop = trigger + delay
        rest = start - speed * (stop - now)
        for time in np.arange(now, stop + 5.0, period) + random.uniform(0, 1e-3):
            z = max(start - speed * (time - now), rest)
            load = stiffness * max(contact - z, 0.0)
            if contact > z and time < stop:
                load += damping * speed
            if time >= stop:
                load *= 1 - share * (1 - math.exp(-(time - stop) / tau))
            rows.append((time, load, z, 2 * press))
        now = stop + 5.0
        for time in np.arange(now, now + 3.0, 0.08):
            rows.append((time, 0.0, start, 2 * press + 1))
        now += 3.0
    time = np.array([row[0] for row in rows])
    readings = bias + np.outer(time, drift) + random.normal(0, noise, (len(rows), 3))
    readings[:, 2] -= [row[1] for row in rows]
    tool = np.column_stack([np.full(len(rows), 0.279), np.full(len(rows), -0.257), [row[2] for row in rows]])
    base = "robots.fanuc"
    hidden = {f"{base}.force_sensor.bias_n[{i}]": bias[i] for i in range(3)}
    hidden |= {f"{base}.force_sensor.drift_n_s[{i}]": drift[i] for i in range(3)}
    return ForceLog(time, readings, tool, np.array([row[3] for row in rows]), guard), hidden | {
        f"{base}.force_sensor.noise_n": noise,
        f"{base}.gripper.palm_relaxation.share": share,
        f"{base}.gripper.palm_relaxation.time_s": tau,
        f"{base}.gripper.palm_stiffness_n_m": stiffness,
        f"{base}.gripper.palm_damping_ns_m": damping,
        f"{base}.guard_delay_s": delay,
    }
