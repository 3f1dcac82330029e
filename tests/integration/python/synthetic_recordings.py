"""Recordings of made-up cells with hidden parameters, with the noise that sensors have."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "clients" / "python"))

from aprsim.calibration.belt_fit import speed_at, targets  # noqa: E402
from aprsim.calibration.crcl_documents import Command, Status  # noqa: E402
from aprsim.calibration.line_fit import Correction, KnownObject  # noqa: E402
from aprsim.calibration.modbus_units import RUN, SPEED, BeltRecord  # noqa: E402
from aprsim.calibration.profiles import duration, rest_to_rest  # noqa: E402
from aprsim.calibration.recordings import CameraRecord, ForceLog, RobotRecord, Sighting  # noqa: E402


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
