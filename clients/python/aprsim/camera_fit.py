"""Fits a camera to a map from points of a table to pixels, by least squares, and prints it as an entry of a
scene's `cameras`.

    python3 -m aprsim.camera_fit MAP.npz --size 1920 1080 --origin-m 1.0414 0.381 0.839 --columns=-x --rows=+y

MAP.npz has float arrays `map_x` and `map_y` (rows, columns): the pixel that shows each point of a grid on
the table, as cv2.remap reads them. It may have `crop_start` (x, y), which is added to each pixel, and
`angle` [degrees], by which the frame was rotated about its middle before. The first pixel's middle is (0, 0).
A table's picture tells focal length and height apart by perspective and distortion alone: give
`--focal-px` where it is known.
"""

from __future__ import annotations

import argparse
import sys
import zipfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Sequence

import numpy as np

from .errors import AprsimError, BadArgument
from .poses import Array

_AXES = {"+x": (1.0, 0.0), "-x": (-1.0, 0.0), "+y": (0.0, 1.0), "-y": (0.0, -1.0)}
_MOST_TERMS = 5
_STEPS = 200  # of the fit
_CONVERGED = 1e-12  # relative decrease of the squared error in a step
_FOCAL_GUESSES = (0.6, 1.0, 1.5, 2.5)  # of the picture's width


@dataclass(frozen=True)
class FittedCamera:
    """A pinhole with Brown's distortion and its pose. The camera frame C has x to the right of the picture,
    y down, z along the view."""

    size_px: tuple[int, int]
    focal_px: float
    centre_px: tuple[float, float]
    distortion: tuple[float, ...]
    """k1, k2, p1, p2, k3, as far as they were fitted."""
    X_WC: Array
    rms_px: float = 0.0
    """Root mean square of the distances between the map's pixels and the camera's."""
    max_px: float = 0.0

    def pixels(self, points_m: Array) -> Array:
        """Pixels (n, 2) of points of the world (n, 3)."""
        in_camera = (points_m - self.X_WC[:3, 3]) @ self.X_WC[:3, :3]
        x, y = (in_camera[:, :2] / in_camera[:, 2:]).T
        k1, k2, p1, p2, k3 = (*self.distortion, *([0.0] * (_MOST_TERMS - len(self.distortion))))
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        return self.focal_px * np.column_stack([u, v]) + self.centre_px

    def scene_entry(self, name: str) -> str:
        """The camera as an entry of a scene's `cameras`."""
        R = self.X_WC[:3, :3]
        rpy = np.degrees(
            [np.arctan2(R[2, 1], R[2, 2]), -np.arcsin(R[2, 0]), np.arctan2(R[1, 0], R[0, 0])]
        )
        lines = [
            f"  - name: {name}",
            f"    xyz_m: {_numbers(self.X_WC[:3, 3], 5)}",
            f"    rpy_deg: {_numbers(rpy, 4)}",
            f"    resolution_px: [{self.size_px[0]}, {self.size_px[1]}]",
            f"    focal_px: {self.focal_px:.2f}",
            f"    centre_px: {_numbers(self.centre_px, 2)}",
        ]
        if self.distortion:
            lines.append(f"    distortion: {_numbers(self.distortion, 5)}")
        return "\n".join(lines) + "\n"


def fit_camera(
    points_m: Array,
    pixels: Array,
    size_px: tuple[int, int],
    *,
    terms: int = 1,
    focal_px: float | None = None,
    fit_centre: bool = False,
) -> FittedCamera:
    """The camera that shows points (n, 3) of a horizontal plane at pixels (n, 2): the least squares of
    distances in pixels, by Levenberg and Marquardt's method (Marquardt 1963). `terms`: number of terms of
    distortion. `focal_px` is kept where it is given. Raises BadArgument when there are too few points or
    none of the fits converges."""
    if not 0 <= terms <= _MOST_TERMS:
        raise BadArgument(f"terms: {terms}, where 0 to {_MOST_TERMS} are possible")
    if len(points_m) < 12 or points_m.shape[1:] != (3,) or pixels.shape != (len(points_m), 2):
        raise BadArgument("points: at least 12 of three coordinates with a pixel each are expected")
    if np.ptp(points_m[:, 2]) > 1e-9:
        raise BadArgument("points: all at the same height are expected")
    if np.linalg.matrix_rank(points_m[:, :2] - points_m[:, :2].mean(axis=0), tol=1e-6) < 2:
        raise BadArgument("points: some that are not in line are expected")
    H = _homography(points_m[:, :2], pixels)
    guesses = [focal_px] if focal_px else [share * size_px[0] for share in _FOCAL_GUESSES]
    fits = [
        _refine(_first_guess(H, points_m, size_px, guess), points_m, pixels, terms, focal_px is None, fit_centre)
        for guess in guesses
    ]
    best = min(fits, key=lambda camera: camera.rms_px)
    if not np.isfinite(best.rms_px):
        raise BadArgument("points: no camera shows them so")
    return best


def read_map(
    path: str | Path,
    *,
    size_px: tuple[int, int],
    origin_m: Sequence[float],
    columns: str = "+x",
    rows: str = "+y",
    pitch_m: float = 0.0254 / 30,
    every: int = 30,
) -> tuple[Array, Array]:
    """Points (n, 3) of the world and their pixels (n, 2) from a map, each `every` element along both axes.
    `origin_m`: the point of the first element; `columns` and `rows`: axes of the world (+x, -x, +y, -y) along
    which they run; `pitch_m`: distance of neighbours. Raises BadArgument."""
    if columns not in _AXES or rows not in _AXES or columns[1] == rows[1]:
        raise BadArgument(f"columns, rows: '{columns}', '{rows}', where +x, -x, +y, -y along two axes are expected")
    if every < 1 or not pitch_m > 0:
        raise BadArgument("every, pitch_m: numbers above 0 are expected")
    try:
        with np.load(path, allow_pickle=False) as file:
            found = {name: np.asarray(file[name], dtype=float) for name in file.files}
    except (OSError, ValueError, zipfile.BadZipFile, EOFError) as error:
        raise BadArgument(f"{path}: {error}") from error
    missing = [name for name in ("map_x", "map_y") if name not in found]
    if missing:
        raise BadArgument(f"{path}: no array {', '.join(missing)}")
    u, v = found["map_x"], found["map_y"]
    if u.ndim != 2 or u.shape != v.shape:
        raise BadArgument(f"{path}: map_x {u.shape} and map_y {v.shape}, where two tables of a size are expected")
    crop = found.get("crop_start", np.zeros(2)).reshape(-1)
    angle = found.get("angle", np.zeros(1)).reshape(-1)
    if len(crop) != 2 or len(angle) != 1:
        raise BadArgument(f"{path}: crop_start of two numbers and angle of one are expected")
    row, column = np.mgrid[0 : u.shape[0] : every, 0 : u.shape[1] : every]
    pixels = np.column_stack([u[row, column].ravel(), v[row, column].ravel()]) + crop
    pixels = _rotated_back(pixels, float(angle[0]), size_px)
    if not np.isfinite(pixels).all():
        raise BadArgument(f"{path}: numbers are expected in map_x and map_y")
    along, down = np.array(_AXES[columns]), np.array(_AXES[rows])
    points = np.empty((row.size, 3))
    points[:] = origin_m
    points[:, :2] += pitch_m * (np.outer(column.ravel(), along) + np.outer(row.ravel(), down))
    return points, pixels


def _rotated_back(pixels: Array, angle_deg: float, size_px: tuple[int, int]) -> Array:
    """Pixels of the frame before OpenCV has rotated it about its middle, counter-clockwise in the picture."""
    a = np.radians(angle_deg)
    R = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])  # of the rotated picture in the other
    middle = np.array(size_px) / 2
    out: Array = (pixels - middle) @ R + middle
    return out


def _homography(points: Array, pixels: Array) -> Array:
    """The map of a plane to the picture without distortion: direct linear transform of normalised points
    (Hartley 1997)."""
    to_points, to_pixels = _normaliser(points), _normaliser(pixels)
    x, y = (np.column_stack([points, np.ones(len(points))]) @ to_points.T)[:, :2].T
    u, v = (np.column_stack([pixels, np.ones(len(pixels))]) @ to_pixels.T)[:, :2].T
    one, zero = np.ones(len(x)), np.zeros(len(x))
    rows = [
        np.column_stack([x, y, one, zero, zero, zero, -u * x, -u * y, -u]),
        np.column_stack([zero, zero, zero, x, y, one, -v * x, -v * y, -v]),
    ]
    H = np.linalg.svd(np.vstack(rows))[2][-1].reshape(3, 3)
    out: Array = np.linalg.inv(to_pixels) @ H @ to_points
    return out


def _normaliser(points: Array) -> Array:
    middle = points.mean(axis=0)
    scale = 1 / max(float(np.abs(points - middle).mean()), 1e-12)
    return np.array([[scale, 0, -scale * middle[0]], [0, scale, -scale * middle[1]], [0, 0, 1.0]])


def _first_guess(H: Array, points: Array, size_px: tuple[int, int], focal_px: float) -> FittedCamera:
    """The pose from a homography for this focal length (Zhang 2000)."""
    centre = ((size_px[0] - 1) / 2, (size_px[1] - 1) / 2)
    K = np.array([[focal_px, 0, centre[0]], [0, focal_px, centre[1]], [0, 0, 1.0]])
    B = np.linalg.solve(K, H)
    B *= 2 / (np.linalg.norm(B[:, 0]) + np.linalg.norm(B[:, 1]))
    middle = points.mean(axis=0)
    if (B @ [middle[0], middle[1], 1.0])[2] < 0:
        B = -B  # the points lie before the camera
    rough = np.column_stack([B[:, 0], B[:, 1], np.cross(B[:, 0], B[:, 1])])
    left, _, right = np.linalg.svd(rough)
    R_CW = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    X_WC = np.eye(4)
    X_WC[:3, :3] = R_CW.T
    X_WC[:3, 3] = -R_CW.T @ B[:, 2] + [0, 0, points[0, 2]]
    return FittedCamera(size_px, focal_px, centre, (), X_WC)


def _moved(camera: FittedCamera, step: Array, terms: int, fit_focal: bool, fit_centre: bool) -> FittedCamera:
    """The camera after a step of its parameters: turn and shift of its frame, terms, focal length, centre."""
    X_WC = camera.X_WC.copy()
    X_WC[:3, :3] = X_WC[:3, :3] @ _rotation(step[:3])
    X_WC[:3, 3] += step[3:6]
    rest = iter(step[6:].tolist())
    distortion = (*camera.distortion, *([0.0] * (terms - len(camera.distortion))))
    return replace(
        camera,
        X_WC=X_WC,
        distortion=tuple(value + next(rest) for value in distortion),
        focal_px=camera.focal_px * (1 + next(rest)) if fit_focal else camera.focal_px,
        centre_px=(camera.centre_px[0] + next(rest), camera.centre_px[1] + next(rest))
        if fit_centre
        else camera.centre_px,
    )


def _refine(
    camera: FittedCamera, points: Array, pixels: Array, terms: int, fit_focal: bool, fit_centre: bool
) -> FittedCamera:
    count = 6 + terms + fit_focal + 2 * fit_centre
    sizes = np.array([1e-6] * 6 + [1e-6] * terms + [1e-6] * fit_focal + [1e-3] * 2 * fit_centre)

    def moved(step: Array) -> FittedCamera:
        return _moved(camera, step, terms, fit_focal, fit_centre)

    def errors(of: FittedCamera) -> Array:
        with np.errstate(all="ignore"):
            out: Array = np.nan_to_num((of.pixels(points) - pixels).ravel(), nan=1e9, posinf=1e9, neginf=-1e9)
        return np.clip(out, -1e9, 1e9)

    damping, error = 1e-3, errors(camera)
    for _ in range(_STEPS):
        J = np.column_stack(
            [(errors(moved(d)) - errors(moved(-d))) / (2 * d.max()) for d in np.diag(sizes)]
        )
        square, slope = J.T @ J, J.T @ error
        before = float(error @ error)
        for _ in range(30):
            scaled = square + damping * np.diag(np.diag(square) + 1e-12)
            candidate = moved(np.linalg.lstsq(scaled, -slope, rcond=None)[0][:count])
            after_error = errors(candidate)
            if after_error @ after_error < before:
                break
            damping *= 4
        else:
            break
        camera, error, damping = candidate, after_error, max(damping / 8, 1e-15)
        if before - float(error @ error) <= _CONVERGED * before:
            break
    distances = np.hypot(*error.reshape(-1, 2).T)
    return replace(
        camera, rms_px=float(np.sqrt((distances**2).mean())), max_px=float(distances.max())
    )


def _rotation(vector: Array) -> Array:
    """Rodrigues' rotation by a vector."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-15:
        return np.eye(3)
    x, y, z = vector / angle
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    out: Array = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    return out


def _numbers(values: Sequence[float] | Array, digits: int) -> str:
    return "[" + ", ".join(f"{value + 0.0:.{digits}f}" for value in values) + "]"


def _command_line() -> argparse.ArgumentParser:
    text, _, details = (__doc__ or "").partition("\n\n")
    parser = argparse.ArgumentParser(
        prog="aprsim camera fit",
        description=text,
        epilog=details,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("map", type=Path, help="map from points to pixels (.npz)")
    parser.add_argument("--size", type=int, nargs=2, required=True, metavar=("WIDTH", "HEIGHT"), help="of the frame [px]")
    parser.add_argument(
        "--origin-m", type=float, nargs=3, required=True, metavar=("X", "Y", "Z"),
        help="point of the map's first element in the world",
    )  # fmt: skip
    parser.add_argument("--columns", choices=list(_AXES), default="+x", help="axis along which columns run (default +x)")
    parser.add_argument("--rows", choices=list(_AXES), default="+y", help="axis along which rows run (default +y)")
    parser.add_argument("--pitch-mm", type=float, default=25.4 / 30, help="distance of neighbours (default 25.4 / 30)")
    parser.add_argument("--every", type=int, default=30, help="take each N-th element of rows and columns (default 30)")
    parser.add_argument("--terms", type=int, choices=range(_MOST_TERMS + 1), default=1, help="terms of distortion (default 1)")
    parser.add_argument("--focal-px", type=float, help="known focal length, which is kept")
    parser.add_argument("--centre", action="store_true", help="fit the principal point, too; else the frame's middle")
    parser.add_argument("--name", default="camera", help="name of the camera in the scene")
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """The program. Returns its exit code: 0 done, 2 a wrong argument or file."""
    options = _command_line().parse_args(arguments)
    size = (options.size[0], options.size[1])
    try:
        if min(size) < 1:
            raise BadArgument(f"--size: {size[0]} {size[1]}, where numbers above 0 are expected")
        if options.focal_px is not None and not options.focal_px > 0:
            raise BadArgument(f"--focal-px: {options.focal_px:g}, where a number above 0 is expected")
        points, pixels = read_map(
            options.map,
            size_px=size,
            origin_m=options.origin_m,
            columns=options.columns,
            rows=options.rows,
            pitch_m=options.pitch_mm / 1e3,
            every=options.every,
        )
        camera = fit_camera(
            points, pixels, size, terms=options.terms, focal_px=options.focal_px, fit_centre=options.centre
        )
    except AprsimError as error:
        print(f"camera_fit: {error}", file=sys.stderr)
        return 2
    print(f"  # {len(points)} points, {camera.rms_px:.2f} px rms, at most {camera.max_px:.2f} px")
    print(camera.scene_entry(options.name), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
