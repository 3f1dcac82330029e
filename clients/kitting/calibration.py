"""Correction of camera positions by a table of measured errors, in the laboratory's format: columns
for the reported point and for the offset to add."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from cell import CellError
from geometry import XY, distance

_SEEN = (("X", "Y"), ("Xin", "Yin"), ("Input_X", "Input_Y"))
_OFFSET = ("Offset_X", "Offset_Y")


@dataclass(frozen=True)
class Correction:
    """Offsets at points [mm]. Four points give a bilinear map, as in the laboratory's position maps;
    another number is interpolated by inverse distance."""

    points: tuple[tuple[XY, XY], ...] = ()

    def apply(self, seen: XY) -> XY:
        """The corrected point; exact at the points of the table."""
        plane = _bilinear(self.points)
        if plane is None:
            return self._weighted(seen)
        terms = _terms(seen)
        dx, dy = (sum(a * t for a, t in zip(axis, terms)) for axis in plane)
        return (seen[0] + dx, seen[1] + dy)

    def _weighted(self, seen: XY) -> XY:
        """Shepard's inverse-distance interpolation; never beyond the largest offset."""
        total, dx, dy = 0.0, 0.0, 0.0
        for point, offset in self.points:
            away = distance(point, seen)
            if away < 1e-6:
                return (seen[0] + offset[0], seen[1] + offset[1])
            weight = away**-2
            total, dx, dy = total + weight, dx + weight * offset[0], dy + weight * offset[1]
        return seen if total == 0 else (seen[0] + dx / total, seen[1] + dy / total)


def _terms(point: XY) -> tuple[float, float, float, float]:
    x, y = point[0] / 1000, point[1] / 1000
    return (1.0, x, y, x * y)


@lru_cache(maxsize=None)
def _bilinear(points: tuple[tuple[XY, XY], ...]) -> tuple[list[float], list[float]] | None:
    """Coefficients of both offsets' a + b x + c y + d x y, by Gaussian elimination; None if the
    system is singular."""
    if len(points) != 4:
        return None
    rows = [[*_terms(point), *offset] for point, offset in points]
    for i in range(4):
        pivot = max(range(i, 4), key=lambda r: abs(rows[r][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        if abs(rows[i][i]) < 1e-6:
            return None
        for r in range(4):
            if r != i:
                factor = rows[r][i] / rows[i][i]
                rows[r] = [a - factor * b for a, b in zip(rows[r], rows[i])]
    return ([rows[i][4] / rows[i][i] for i in range(4)], [rows[i][5] / rows[i][i] for i in range(4)])


def read_correction(path: Path) -> Correction:
    try:
        with open(path, encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))
    except OSError as error:
        raise CellError(f"{path}: {error}") from error
    header = [name.strip() for name in rows[0]] if rows else []
    seen = next((pair for pair in _SEEN if set(pair) <= set(header)), None)
    if seen is None or not set(_OFFSET) <= set(header):
        raise CellError(f"{path}: columns such as X, Y, Offset_X, Offset_Y are expected")
    columns = [header.index(name) for name in (*seen, *_OFFSET)]
    points = []
    for line, row in enumerate(rows[1:], 2):
        if not any(cell.strip() for cell in row):
            continue
        try:
            x, y, dx, dy = (float(row[column]) for column in columns)
        except (ValueError, IndexError) as error:
            raise CellError(f"{path}:{line}: four numbers are expected ({error})") from error
        points.append(((x, y), (dx, dy)))
    return Correction(tuple(points))
