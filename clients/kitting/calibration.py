"""Correction of what a camera says by a table of points at which its error is known, as the
laboratory records them: columns for the point as seen and for the offset to add."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

from cell import CellError
from geometry import XY, distance

_SEEN = (("X", "Y"), ("Xin", "Yin"), ("Input_X", "Input_Y"))
_OFFSET = ("Offset_X", "Offset_Y")


@dataclass(frozen=True)
class Correction:
    """Offsets at points, millimetres, between which the nearer points weigh more."""

    points: tuple[tuple[XY, XY], ...] = ()

    def apply(self, seen: XY) -> XY:
        """Shepard's interpolation: exact at the points, nowhere beyond the largest offset."""
        total, dx, dy = 0.0, 0.0, 0.0
        for point, offset in self.points:
            away = distance(point, seen)
            if away < 1e-6:
                return (seen[0] + offset[0], seen[1] + offset[1])
            weight = away**-2
            total, dx, dy = total + weight, dx + weight * offset[0], dy + weight * offset[1]
        return seen if total == 0 else (seen[0] + dx / total, seen[1] + dy / total)


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
