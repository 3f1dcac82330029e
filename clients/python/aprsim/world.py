"""A cell in this process."""

from __future__ import annotations

import ctypes
import functools
import os
import weakref
from pathlib import Path
from typing import Any, Iterable, Iterator

import grpc
import numpy as np
import numpy.typing as npt

from . import arguments
from .binaries import find_library
from .cell import Cell
from .channel import Channel
from .endpoints import Endpoints
from .errors import AprsimError, Refused, TimedOut, Unreachable
from .robot_wires import RobotWire

Numbers = npt.NDArray[np.float64]

_ARRAYS = {
    "body_poses": 7,
    "body_velocities": 6,
    "joints": 3,
    "tool_poses": 7,
    "tool_loads": 6,
    "grippers": 5,
}
"""Names of the arrays in the library's order, with their numbers a row."""
_CHANGES_BODIES = {"Reset", "LoadState", "SpawnBody", "MoveBody", "RemoveBody", "SetSceneValue"}
_CODES = {code.value[0]: code.name for code in grpc.StatusCode}
_MOST = (1 << 64) - 1


@functools.cache
def _library() -> Any:
    """Raises AprsimError where the library is not there or does not fit."""
    path = find_library("libaprsim_cell.so")
    try:
        library = ctypes.CDLL(path)
        _declare(library)
    except (OSError, AttributeError) as error:
        raise AprsimError(f"{path} cannot be used: {error}") from error
    return library


def _declare(library: Any) -> None:
    cell, size, bytes_out = ctypes.c_void_p, ctypes.c_size_t, ctypes.POINTER(ctypes.c_void_p)
    size_out = ctypes.POINTER(ctypes.c_size_t)
    functions = {
        "aprsim_cell_add_extensions": (None, [ctypes.c_char_p]),
        "aprsim_cell_open": (cell, [ctypes.c_char_p, ctypes.POINTER(ctypes.c_uint64)]),
        "aprsim_cell_close": (None, [cell]),
        "aprsim_error": (ctypes.c_char_p, []),
        "aprsim_cell_call": (
            ctypes.c_int,
            [cell, ctypes.c_char_p, ctypes.c_char_p, size, bytes_out, size_out],
        ),
        "aprsim_robot_send": (
            ctypes.c_int,
            [cell, size, ctypes.c_char_p, size, bytes_out, size_out],
        ),
        "aprsim_robot_connect": (ctypes.c_int, [cell, size]),
        "aprsim_cell_step": (ctypes.c_int, [cell, ctypes.c_uint64]),
        "aprsim_cell_keep": (ctypes.c_int, [cell]),
        "aprsim_cell_return": (ctypes.c_int, [cell]),
        "aprsim_cell_array": (ctypes.POINTER(ctypes.c_double), [cell, ctypes.c_int, size_out]),
        "aprsim_cell_observe": (None, [cell]),
        "aprsim_cell_step_count": (ctypes.c_uint64, [cell]),
        "aprsim_cell_state_hash": (ctypes.c_uint64, [cell]),
    }
    for name, (result, parameters) in functions.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, parameters


class World(Cell):
    """A cell in this process, without daemon, sockets, clock and threads, for many episodes: it is
    always paused and advances by `step`, `run_until` and `advance`. It is a `Cell` and gives the bits
    that a daemon gives for the same commands, but has no streams, cameras, history and trajectories.

        with World("aprs", seed=1) as world:
            world.robot("fanuc").move_by([0, 0, -0.05])
            world.advance(100)
            print(world.tool_poses)

    `advance` and the arrays avoid messages. An array is a view of the library's memory: `observe`
    writes the present values into it. Thread: one at a time for each world; the interpreter's lock is
    free while a world steps, so worlds of several threads use several processors."""

    body_poses: Numbers
    """(bodies, 7): position and quaternion (w, x, y, z) in the world."""
    body_velocities: Numbers
    """(bodies, 6): linear velocity of the frame's origin, and angular velocity, in the world."""
    joints: Numbers
    """(joints of all robots, 3): position, velocity, torque."""
    tool_poses: Numbers
    """(robots, 7): tool frame in the world."""
    tool_loads: Numbers
    """(robots, 6): force and torque in the robot's reference frame."""
    grippers: Numbers
    """(robots, 5): opening, force of both pads, 1 while it holds, index of the held body or -1."""

    def __init__(
        self,
        scene: str = "aprs",
        seed: int | None = None,
        extensions: Iterable[str | Path] = (),
    ) -> None:
        """`scene` is the name of a shipped scene or the path of a file; `seed` is by default the
        scene's. `extensions` are directories with the libraries of the scene's devices; this process
        keeps them. Raises AprsimError with the cause when the scene cannot be used."""
        self._native: _Native | None = None
        self._library = _library()
        name = arguments.text("scene", scene).encode()
        number = None if seed is None else ctypes.c_uint64(arguments.whole("seed", seed, 0, _MOST))
        for directory in extensions:
            path = arguments.text("extensions", str(directory))
            self._library.aprsim_cell_add_extensions(os.path.abspath(path).encode())
        native = self._library.aprsim_cell_open(name, number)
        if not native:
            raise AprsimError(self._message())
        self._native = _Native(self._library, native)
        Channel.__init__(self, Endpoints(), _Calls(self), "this process")
        self._begin()
        self._kept = self.description
        self._view_arrays()

    def close(self) -> None:
        """End the cell. Arrays that are kept elsewhere keep their values, and the cell's memory."""
        self._closed = True
        for robot in self._robots.values():
            robot.close()
        self._robots.clear()
        self._native = None
        for name, columns in _ARRAYS.items():
            setattr(self, name, np.empty((0, columns)))

    # -- without messages ---------------------------------------------------------------------

    @property
    def step_count(self) -> int:
        """Steps since the last reset."""
        return int(self._library.aprsim_cell_step_count(self._handle()))

    @property
    def state_hash(self) -> int:
        """The hash of the physical state, as in snapshots."""
        return int(self._library.aprsim_cell_state_hash(self._handle()))

    def advance(self, steps: int = 1) -> None:
        """Step without a snapshot, and `observe`."""
        count = arguments.whole("steps", steps, 1, _MOST)
        self._check(self._library.aprsim_cell_step(self._handle(), count))
        self._library.aprsim_cell_observe(self._handle())

    def observe(self) -> None:
        """Write the present values into the arrays."""
        self._library.aprsim_cell_observe(self._handle())

    def keep(self) -> None:
        """Keep the present state for `go_back`, in place of the one of before."""
        self._check(self._library.aprsim_cell_keep(self._handle()))
        self._kept = self.description

    def go_back(self) -> None:
        """Continue from the kept state, bit for bit, and `observe`."""
        self._check(self._library.aprsim_cell_return(self._handle()))
        if self._kept is not self.description:
            # A reset since may have brought other robots.
            self._follow_robots()
            self._kept = self.description
            self._view_arrays()
        self._library.aprsim_cell_observe(self._handle())

    # -- Cell ---------------------------------------------------------------------------------

    def step_without_snapshot(self, steps: int) -> None:
        """Step `steps` times without a snapshot."""
        self._check(self._library.aprsim_cell_step(self._handle(), steps))

    def _connect_robot(self, name: str) -> RobotWire:
        names = [robot.name for robot in self.description.robots]
        return _RobotCalls(self, name, names.index(name))

    # -- the library --------------------------------------------------------------------------

    def exchange(self, function: str, *arguments_of_call: Any) -> bytes:
        """The bytes that a function of the library answers. Raises Refused with the library's text."""
        data, size = ctypes.c_void_p(), ctypes.c_size_t()
        call = getattr(self._library, function)
        self._check(
            call(self._handle(), *arguments_of_call, ctypes.byref(data), ctypes.byref(size))
        )
        return ctypes.string_at(data, size.value) if size.value else b""

    def connect_robot(self, robot: int) -> None:
        """Begin a new CRCL connection to the robot with this index."""
        self._check(self._library.aprsim_robot_connect(self._handle(), robot))

    def _handle(self) -> int:
        if not self._native:
            raise self._closed_error()
        return self._native.handle

    def _check(self, code: int) -> None:
        if code:
            raise Refused(_CODES.get(code, "UNKNOWN"), self._message())

    def _message(self) -> str:
        return bytes(self._library.aprsim_error()).decode("utf-8", errors="replace")

    def _view_arrays(self) -> None:
        """Let the arrays be those of the library, which moves them when the cell's bodies change."""
        self._library.aprsim_cell_observe(self._handle())
        for number, (name, columns) in enumerate(_ARRAYS.items()):
            size = ctypes.c_size_t()
            data = self._library.aprsim_cell_array(self._handle(), number, ctypes.byref(size))
            view: Numbers = np.empty(0)
            if size.value:
                address = ctypes.addressof(data.contents)
                memory: Any = (ctypes.c_double * size.value).from_address(address)
                memory.native = self._native  # which lives as long as a view of it
                view = np.frombuffer(memory)
            setattr(self, name, view.reshape(-1, columns))


class _Native:
    """The library's cell, for as long as somebody refers to it."""

    def __init__(self, library: Any, handle: int) -> None:
        self._library, self.handle = library, handle

    def __del__(self) -> None:
        self._library.aprsim_cell_close(self.handle)


class _Failed(grpc.RpcError):  # type: ignore[misc]
    """A status of a call that is not OK."""

    def __init__(self, error: Refused) -> None:
        super().__init__(str(error))
        self._error = error

    def code(self) -> grpc.StatusCode:
        return grpc.StatusCode[self._error.code]

    def details(self) -> str:
        return str(self._error)


class _Done:
    """A call that has ended, as its future."""

    def __init__(self, answer: Any, error: _Failed | None) -> None:
        self._answer, self._error = answer, error

    def result(self) -> Any:
        if self._error is not None:
            raise self._error
        return self._answer

    def cancel(self) -> bool:
        return False

    def __iter__(self) -> Iterator[Any]:
        self.result()
        return iter(())


class _Call:
    """One call of a service."""

    def __init__(self, world: World, method: str, serialize: Any, deserialize: Any) -> None:
        service, _, name = method.rpartition("/")
        self._method = f"{service.rpartition('.')[2].removesuffix('Service')}/{name}".encode()
        self._world, self._serialize, self._deserialize = world, serialize, deserialize
        self._changes_bodies = name in _CHANGES_BODIES

    def __call__(self, request: Any, **_: Any) -> Any:
        data = self._serialize(request)
        try:
            answer = self._world.exchange("aprsim_cell_call", self._method, data, len(data))
        except Refused as error:
            raise _Failed(error) from error
        finally:
            if self._changes_bodies:
                self._world._view_arrays()
        return self._deserialize(answer)

    def future(self, request: Any, **_: Any) -> _Done:
        try:
            return _Done(self(request), None)
        except _Failed as error:
            return _Done(None, error)


class _Stream:
    """A call with a stream, which no cell in this process has."""

    def __init__(self, method: str) -> None:
        self._method = method

    def __call__(self, *_: Any, **__: Any) -> _Done:
        text = f"{self._method}: a cell in this process has no streams; a daemon has"
        return _Done(None, _Failed(Refused("UNIMPLEMENTED", text)))


class _Calls:
    """The calls of the services as those of a channel."""

    def __init__(self, world: World) -> None:
        self._world = weakref.proxy(world)

    def unary_unary(self, method: str, request_serializer: Any, response_deserializer: Any) -> _Call:
        return _Call(self._world, method, request_serializer, response_deserializer)

    def unary_stream(self, method: str, **_: Any) -> _Stream:
        return _Stream(method)

    stream_unary = stream_stream = unary_stream


class _RobotCalls:
    """A robot's CRCL port."""

    def __init__(self, world: World, robot: str, index: int) -> None:
        self._world, self._robot, self._index = weakref.proxy(world), robot, index
        self._statuses = b""
        self._closed = False
        world.connect_robot(index)

    def send(self, document: bytes) -> None:
        if self._closed:
            raise Unreachable(f"{self._robot}: this connection is closed")
        try:
            self._statuses += self._world.exchange(
                "aprsim_robot_send", self._index, document, len(document)
            )
        except Refused as error:
            raise Unreachable(str(error)) from error

    def receive(self) -> bytes:
        if not self._statuses:
            self.send(b"")
        if not self._statuses:
            raise TimedOut(f"{self._robot}: no status")
        data, self._statuses = self._statuses, b""
        return data

    def close(self) -> None:
        self._closed = True
