"""The programs of the tree: the daemon and its command line; and the cell as a library."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from .errors import AprsimError

FOLDER_VARIABLE = "APRSIM_BIN_DIR"


def find_binary(name: str, folder: str | Path | None = None) -> str:
    """The path of a program: in `folder`, else in APRSIM_BIN_DIR, else on PATH, else in the tree's build of
    the preset `release`. Raises AprsimError with the places that were searched."""
    chosen = folder or os.environ.get(FOLDER_VARIABLE)
    if chosen:
        places = [Path(chosen) / name]
    else:
        tree = Path(__file__).resolve().parents[3] / "build" / "release" / "bin"
        on_path = shutil.which(name)
        places = ([Path(on_path)] if on_path else []) + [tree / name]
    for place in places:
        if os.access(place, os.X_OK) and place.is_file():
            return str(place)
    raise AprsimError(f"no program {name}: not on PATH, nor {', '.join(map(str, places))}")


def find_library(name: str) -> str:
    """The path of a shared library of the tree: beside the folder in APRSIM_BIN_DIR, else beside the
    programs on PATH, else in the tree's build of the preset `release`. Raises AprsimError with the
    places that were searched."""
    program = shutil.which("aprsimd")
    tree = Path(__file__).resolve().parents[3] / "build" / "release" / "bin"
    chosen = os.environ.get(FOLDER_VARIABLE)
    folders = [Path(chosen)] if chosen else [*([Path(program).parent] if program else []), tree]
    places = [folder.parent / lib / name for folder in folders for lib in ("lib", "lib/aprsim")]
    for place in places:
        if place.is_file():
            return str(place)
    raise AprsimError(f"no library {name}: not at {', '.join(map(str, places))}")
