"""Calibration and noise of a camera, from its lines and the true places of objects."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from ..poses import Array
from . import estimates
from .estimates import Estimate
from .recordings import CameraRecord

_NEAR_M = 0.03  # distance within which sightings are of one object
_SAME_M = 0.05  # distance of a sighting to the true place of its object
_MOST_USUAL = 6  # robust standard deviations, beyond which a difference is no noise


@dataclass(frozen=True)
class KnownObject:
    """An object of the scene in the camera's vision frame."""

    kind: str
    """Name in the camera's lines."""
    x_m: float
    y_m: float
    yaw_rad: float


@dataclass(frozen=True)
class Track:
    """Sightings of one object over the frames."""

    kind: str
    points_m: Array
    """(n, 2)"""
    yaws_rad: Array


@dataclass(frozen=True)
class Correction:
    """Rigid map from true to reported places in the plane, about the middle of the objects."""

    middle_m: Array
    shift_m: Array
    turn_rad: float

    def reported(self, points_m: Array) -> Array:
        """Where a camera with this error reports points (n, 2)."""
        c, s = math.cos(self.turn_rad), math.sin(self.turn_rad)
        R = np.array([[c, -s], [s, c]])
        out: Array = (points_m - self.middle_m) @ R.T + self.middle_m + self.shift_m
        return out


def fit_camera(
    name: str, record: CameraRecord, known: Sequence[KnownObject], scene: dict[str, float]
) -> tuple[list[Estimate], Correction | None]:
    """All estimates of a camera, and its error of calibration where the data tell it. `scene`:
    position_noise_m, rotation_noise_deg, drop_rate and rate_hz of the scene."""
    base = f"robots.{name}.vision"
    tracks = tracks_of(record)
    bias, correction = _bias(base, tracks, known)
    out = [*bias, *_noise(base, tracks, scene), _drops(base, record, tracks, scene), _rate(base, record, scene)]
    out.append(
        estimates.untold(
            f"{base}.latency_s", "s", "needs a tray that the belt carries, and readings of the belt", "vision.latency_s", scene.get("latency_s")
        )
    )
    return out, correction


def tracks_of(record: CameraRecord) -> list[Track]:
    """Objects that stay where they are, with their sightings."""
    groups: defaultdict[str, list[list[tuple[float, float, float]]]] = defaultdict(list)
    for frame in record.frames:
        for seen in frame:
            if math.isnan(seen.x_m) or math.isnan(seen.y_m):
                continue
            place = (seen.x_m, seen.y_m, seen.yaw_rad)
            near = [
                one for one in groups[seen.name] if math.dist(place[:2], one[0][:2]) < _NEAR_M
            ]
            if near:
                min(near, key=lambda one: math.dist(place[:2], one[0][:2])).append(place)
            else:
                groups[seen.name].append([place])
    return [
        Track(kind, np.array(points)[:, :2], np.array(points)[:, 2])
        for kind, several in groups.items()
        for points in several
        if len(points) >= 3
    ]


def _bias(
    base: str, tracks: Sequence[Track], known: Sequence[KnownObject]
) -> tuple[list[Estimate], Correction | None]:
    names = ("bias_x_m", "bias_y_m", "bias_yaw_rad")
    pairs = pair(tracks, known)
    if len(pairs) < 3:
        why = f"{len(pairs)} objects of the scene are recognised in the lines, at least 3 are needed"
        return [estimates.untold(f"{base}.{one}", "rad" if "yaw" in one else "m", why) for one in names], None
    true = np.array([(one.x_m, one.y_m) for _, one in pairs])
    seen = np.array([track.points_m.mean(axis=0) for track, _ in pairs])
    middle = true.mean(axis=0)

    def residuals(x: Array) -> Array:
        out: Array = (Correction(middle, x[:2], x[2]).reported(true) - seen).ravel()
        return out

    found = estimates.fit(residuals, [0, 0, 0], [-0.2, -0.2, -0.5], [0.2, 0.2, 0.5])
    out = [
        found.estimate(i, f"{base}.{one}", "rad" if "yaw" in one else "m", samples=len(pairs)).judged((-0.2, 0.2))
        for i, one in enumerate(names)
    ]
    return out, Correction(middle, found.values[:2], float(found.values[2]))


def pair(tracks: Sequence[Track], known: Sequence[KnownObject]) -> list[tuple[Track, KnownObject]]:
    """Tracks with their objects: the nearest of the same kind, after the common shift is taken out."""
    shift = np.zeros(2)
    pairs: list[tuple[Track, KnownObject]] = []
    for _ in range(3):
        pairs, taken = [], set()
        for track in tracks:
            place = track.points_m.mean(axis=0) - shift
            near = [
                (math.dist(place, (one.x_m, one.y_m)), i)
                for i, one in enumerate(known)
                if one.kind == track.kind and i not in taken
            ]
            if near and min(near)[0] < _SAME_M:
                taken.add(min(near)[1])
                pairs.append((track, known[min(near)[1]]))
        if not pairs:
            return []
        off = [track.points_m.mean(axis=0) - (one.x_m, one.y_m) for track, one in pairs]
        shift = np.median(off, axis=0)
    return pairs


def _noise(base: str, tracks: Sequence[Track], scene: dict[str, float]) -> list[Estimate]:
    """Standard deviations from differences of sightings in pairs, which a slow drift does not change.
    Larger differences are nudges of the object, or turns by a half."""
    steps = [(track.points_m[1::2] - track.points_m[0::2][: len(track.points_m) // 2]).ravel() for track in tracks]
    turns = [track.yaws_rad[1::2] - track.yaws_rad[0::2][: len(track.yaws_rad) // 2] for track in tracks]
    deviation, freedom = _without_jumps(steps)
    rotation, turned = _without_jumps([np.angle(np.exp(1j * one)) for one in turns])
    key, turn_key = "vision.position_noise_m", "vision.rotation_noise_deg"
    out = [
        estimates.spread(
            deviation, freedom, f"{base}.position_noise_m", "m",
            key=key, scene_value=scene.get("position_noise_m"), samples=freedom,
        )
    ]
    out.append(
        estimates.spread(
            math.degrees(rotation), turned, f"{base}.rotation_noise_deg", "deg",
            key=turn_key, scene_value=scene.get("rotation_noise_deg"), samples=turned,
        )
    )
    return out


def _without_jumps(steps: Sequence[Array]) -> tuple[float, int]:
    """Standard deviation of noise from differences of two values, and their number."""
    all_ = np.concatenate(steps) if steps else np.zeros(0)
    all_ = all_[np.isfinite(all_)]
    if not len(all_):
        return 0.0, 0
    usual = float(np.median(np.abs(all_))) / 0.6745
    kept = all_[np.abs(all_) <= _MOST_USUAL * usual]
    return float(np.sqrt(np.mean(kept**2) / 2)) if len(kept) else 0.0, len(kept)


def _drops(base: str, record: CameraRecord, tracks: Sequence[Track], scene: dict[str, float]) -> Estimate:
    """Share of frames without an object that others show."""
    count = len(record.frames) * len(tracks)
    seen = min(sum(len(track.points_m) for track in tracks), count)
    return estimates.share(
        count - seen, count, f"{base}.drop_rate", key="vision.drop_rate", scene_value=scene.get("drop_rate")
    )


def _rate(base: str, record: CameraRecord, scene: dict[str, float]) -> Estimate:
    name, key = f"{base}.rate_hz", "vision.rate_hz"
    steps = np.diff(np.array(record.times_s))
    steps = steps[np.isfinite(steps) & (steps > 1e-4)]
    if len(steps) < 8:
        return estimates.untold(name, "Hz", "the frames have no times", key, scene.get("rate_hz"))
    period = estimates.mean(steps, name, "Hz")
    return Estimate(
        name, 1 / period.value, 1 / period.high, 1 / max(period.low, 1e-9), "Hz", key, scene.get("rate_hz"), samples=len(steps)
    ).judged((0, 1000))
