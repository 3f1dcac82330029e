"""A file that says what stands beside the cell: `python3 -m aprsim.real run FILE.yaml`. Errors name file, line,
key and value, and the nearest key."""

from __future__ import annotations

import dataclasses
import difflib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator, Mapping

import yaml

from ..errors import BadArgument
from .base.devices import address
from .settings import (
    ADDRESSES,
    LIMITS,
    LISTENS,
    SIMPLE_MESSAGE_ONLY,
    BeltSettings,
    CameraSettings,
    Common,
    RobotSettings,
    is_number,
)
from .simple_message.messages import CONTROLLERS

_SOURCES = ("mirror", "proxy", "shadow")
_CAMERA_SOURCES = ("mirror", "proxy")
_TOP = ("allow_commands", "patience_s", "robots", "conveyor", "cameras")


def read_file(path: str) -> list[Common]:
    """The devices of a file. Raises BadArgument."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise BadArgument(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from error
    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise BadArgument(f"{path}:{line}: {error.problem}") from error
    if root is None:
        raise BadArgument(f"{path}: it is empty, where robots, conveyor or cameras are expected")
    return list(_devices(_Map.of(path, "", root, _TOP)))


def _devices(top: _Map) -> Iterator[Common]:
    common: dict[str, Any] = {key: top.value(key) for key in ("allow_commands", "patience_s") if key in top.nodes}
    count = 0
    for group, kind in (("robots", RobotSettings), ("cameras", CameraSettings)):
        for name, entry in top.children(group, _keys(kind)):
            count += 1
            yield kind(**{**common, **entry.values(), "name": name})
    if "conveyor" in top.nodes:
        count += 1
        entry = _Map.of(top.path, "conveyor", top.nodes["conveyor"], _keys(BeltSettings))
        yield BeltSettings(**{**common, **entry.values()})
    if count == 0:
        raise BadArgument(f"{top.path}: no device, where robots, conveyor or cameras are expected")


def _keys(kind: type[Common]) -> tuple[str, ...]:
    return tuple(field.name for field in dataclasses.fields(kind) if field.name not in ("name", "allow_commands"))


@dataclass(frozen=True)
class _Map:
    """A mapping of the file."""

    path: str
    place: str
    """Its key, as `robots.fanuc`."""
    nodes: Mapping[str, yaml.Node]
    line: int

    @staticmethod
    def of(path: str, place: str, node: yaml.Node, keys: tuple[str, ...] | None) -> _Map:
        line = node.start_mark.line + 1
        if not isinstance(node, yaml.MappingNode):
            raise BadArgument(f"{path}:{line}: {place or 'the file'}: keys and values are expected")
        nodes: dict[str, yaml.Node] = {}
        for key_node, value in node.value:
            key, at = str(key_node.value), key_node.start_mark.line + 1
            name = f"{place}.{key}".lstrip(".")
            if keys is not None and key not in keys:
                near = difflib.get_close_matches(key, keys, 1, 0.5)
                hint = f"did you mean '{near[0]}'?" if near else f"there is {', '.join(keys)}"
                raise BadArgument(f"{path}:{at}: {name}: no such key; {hint}")
            if key in nodes:
                raise BadArgument(f"{path}:{at}: {name}: it is there twice")
            nodes[key] = value
        return _Map(path, place, nodes, line)

    def children(self, key: str, keys: tuple[str, ...]) -> Iterator[tuple[str, _Map]]:
        if key not in self.nodes:
            return
        for name, node in _Map.of(self.path, key, self.nodes[key], None).nodes.items():
            yield name, _Map.of(self.path, f"{key}.{name}", node, keys)

    def values(self) -> dict[str, Any]:
        for key in ("source", "address"):
            if key not in self.nodes:
                raise BadArgument(f"{self.path}:{self.line}: {self.place}: it has no '{key}'")
        out = {key: self.value(key) for key in self.nodes}
        if out.get("wire", "crcl") == "crcl":
            for key in SIMPLE_MESSAGE_ONLY:
                if key in out:
                    self._fail(key, f"it is for Simple Message ({', '.join(CONTROLLERS)})")
        return out

    def value(self, key: str) -> Any:
        """The checked value of a key."""
        node = self.nodes[key]
        value = yaml.SafeLoader("").construct_object(node, deep=True) if isinstance(node, yaml.ScalarNode) else None
        if key in LISTENS or key in ADDRESSES:
            try:
                return address(str(value), free=key in LISTENS)
            except BadArgument:
                self._fail(key, "HOST:PORT is expected", value)
        if key in LIMITS:
            low, high, unit = LIMITS[key]
            if not is_number(value) or not low <= float(value) <= high:
                self._fail(key, f"a number from {low:g} to {high:g} in {unit} is expected", value)
            return float(value)
        choices = self._choices(key)
        if value not in choices or isinstance(value, bool) != isinstance(choices[0], bool):
            self._fail(key, f"one of {', '.join(str(one).lower() for one in choices)} is expected", value)
        return value

    def _choices(self, key: str) -> tuple[Any, ...]:
        if key == "source":
            return _CAMERA_SOURCES if self.place.startswith("cameras") else _SOURCES
        return {"wire": ("crcl", *CONTROLLERS), "allow_commands": (True, False), "forward": (0, 1)}[key]

    def _fail(self, key: str, expected: str, value: Any = None) -> None:
        node = self.nodes[key]
        name = f"{self.place}.{key}".lstrip(".")
        shown = "" if value is None else f"'{value}', where "
        raise BadArgument(f"{self.path}:{node.start_mark.line + 1}: {name}: {shown}{expected}")
