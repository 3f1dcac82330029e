"""The common part of the tasks: the cell, actions, time limits, pictures, resets."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any, Sequence

import numpy as np
import numpy.typing as npt

from .. import arguments
from ..cameras import Camera
from ..cell import Cell
from ..daemon import Daemon
from ..errors import AprsimError, BadArgument, TimedOut, Unreachable
from ..poses import Array
from ..robot import Robot
from ..world import World
from .actions import FIELDS, actions_named
from .arm import Arm
from .spaces import Box, Env, Image, Vector

if TYPE_CHECKING:
    from ..snapshots import Snapshot

_MAX_KEPT = 32  # saved states of one environment
_MOST_STEPS = 1 << 62


class CellEnv(Env):
    """A task in a paused cell, with Gymnasium's signatures. Subclasses define the begin of an episode
    (`_prepare`), its value (`_potential`), its ends (`_is_done`, `_is_lost`) and its observation
    (`_values`).

    Without a cell the environment has one of its own, which ends with `close` or with this process: in
    this process (`World`), or where pictures are wanted, in a daemon. A cell that is given is paused and belongs to the environment until `close`. Errors are
    those of the cell, and BadArgument. Thread: one at a time."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 10}
    observation_names: tuple[str, ...] = ()
    """Names and units of the numbers of an observation."""
    option_names: tuple[str, ...] = ()
    """The options that `reset` knows."""
    _eye: Camera | None = None  # whose pictures are the observations
    _is_ready = False  # an episode has begun
    _is_closed = False
    _speed_m_s = 0.5

    def __init__(
        self,
        cell: Cell | None = None,
        *,
        robots: Sequence[str] = ("fanuc",),
        scene: str = "aprs",
        max_steps: int | None = 200,
        render_mode: str | None = None,
        camera: str | None = None,
        observation: str = "state",
        image_scale: int = 4,
        action: str = "pose",
        rate_hz: float | None = None,
        in_process: bool | None = None,
    ) -> None:
        """`scene` is for a cell of its own; `in_process` chooses where that is, with the same bits. An episode is truncated after `max_steps`; None = never.
        `render_mode` may be "rgb_array", for pictures by `camera`; by default the one over the robot, else
        the first of the scene. `observation` is "state", the numbers of `observation_names`, or "rgb", a
        picture by `camera` whose sides are divided by `image_scale`; then `info["state"]` has the numbers.
        `action` is "pose" or "joint_velocity" (`aprsim.envs.actions`), the latter at `rate_hz`, 1 to
        250 Hz, by default 20."""
        if max_steps is not None:
            max_steps = arguments.whole("max_steps", max_steps, 1, _MOST_STEPS)
        if render_mode not in (None, "rgb_array"):
            raise arguments.wrong("render_mode", render_mode, 'None or "rgb_array"')
        if observation not in ("state", "rgb"):
            raise arguments.wrong("observation", observation, '"state" or "rgb"')
        self._image_scale = arguments.whole("image_scale", image_scale, 1, 64)
        self.render_mode = render_mode
        self.max_steps = max_steps
        self._kept: list[str] = []
        self._owned = cell is None
        self._daemon: Daemon | None = None
        needs_pictures = render_mode is not None or observation == "rgb"
        in_process = not needs_pictures if in_process is None else in_process
        try:
            self.cell = cell or self._open_cell(scene, arguments.truth("in_process", in_process))
            if not self.cell.paused:
                self.cell.pause()
            self._actions = actions_named(action, self.cell, rate_hz)
            self._arms = [Arm(self.cell.robot(name), self._actions) for name in robots]
            self._define_spaces(observation, camera)
            self._begin()
        except BaseException:
            self.close()
            raise

    def _open_cell(self, scene: str, in_process: bool) -> Cell:
        if in_process:
            return World(scene)
        self._daemon = Daemon(scene=scene, speed="stepped")
        return Cell.connect(self._daemon.ports_file)

    # -- Gymnasium ----------------------------------------------------------------------------

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Vector | Image, dict[str, Any]]:
        """Begin an episode from a saved state and random numbers. The same seed begins the same episode,
        bit for bit; without one the random numbers continue. `options` may have the keys of
        `option_names`."""
        self._check_open("reset")
        self._is_ready = False
        super().reset(seed=None if seed is None else arguments.whole("seed", seed, 0, 1 << 62))
        chosen = options or {}
        unknown = set(chosen) - set(self.option_names)
        if unknown:
            known = " and ".join(self.option_names) or "none"
            raise BadArgument(f"options: {sorted(unknown)}, where {known} are known")
        self._taken_steps = 0
        self._prepare(chosen)
        self._snapshot = self.cell.snapshot(FIELDS)
        self._value = self._potential()
        self._is_ready = True
        return self._observation(), self._info(None)

    def step(
        self, action: npt.ArrayLike
    ) -> tuple[Vector | Image, float, bool, bool, dict[str, Any]]:
        """Perform an action: numbers from -1 to 1. Those of the kind "pose" are the tool's motion along x,
        y, z of the world (1 = 50 mm), its turn (1 = 0.3 rad) and the gripper (above 0 = open); the step
        lasts to the end of the motion, at least 0.1 s of simulated time. Returns observation, reward,
        terminated, truncated, info. AprsimError without an episode: `reset` begins one."""
        self._check_open("step")
        if not self._is_ready:
            raise AprsimError("step: no episode has begun; call reset() first")
        values = arguments.vector("action", action, self._action_size, "-1 to 1")
        refused = self._perform(np.clip(values, -1.0, 1.0))
        self._taken_steps += 1
        stuck = any(arm.stuck for arm in self._arms)
        lost = self._is_lost() or stuck or bool(self._snapshot.world_fault)
        value = self._potential() if not lost else self._value - 1.0
        reward = value - self._value
        done = False
        if not lost and self._is_done():
            reward += 1.0
            done = not self._next_goal()
            value = value if done else self._potential()
        self._value = value
        terminated = lost or done
        truncated = not terminated and self._taken_steps >= (self.max_steps or _MOST_STEPS)
        info = self._info(refused)
        info["is_success"] = done
        return self._observation(), float(reward), terminated, truncated, info

    def render(self) -> npt.NDArray[np.uint8] | None:
        """A picture of the cell, (height, width, 3), with `render_mode="rgb_array"`; else None."""
        self._check_open("render")
        return self._camera.rgb() if self._camera else None

    def close(self) -> None:
        """Delete the saved states; end the daemon if it is the environment's own."""
        self._is_closed = True
        cell = getattr(self, "cell", None)
        if cell is not None and self._owned:
            cell.close()
        elif cell is not None:
            with contextlib.suppress(Unreachable, TimedOut):
                for name in self._kept:
                    cell.delete_state(name)
        self._kept = []
        if self._daemon is not None:
            self._daemon.close()
            self._daemon = None

    @property
    def robot(self) -> Robot:
        """The first robot of the task."""
        return self._arms[0].robot

    def snapshot(self) -> Snapshot:
        """The cell after the last step, with the fields of `actions.FIELDS`."""
        return self._snapshot

    def scripted_action(self, state: npt.ArrayLike) -> Vector:
        """An action that leads to the task's end, from the numbers of `observation_names`."""
        raise AprsimError(f"{type(self).__name__} has no scripted policy")

    # -- tasks --------------------------------------------------------------------------------

    def _bounds(self) -> tuple[Sequence[float], Sequence[float]]:
        """Lowest and highest numbers of an observation."""
        raise NotImplementedError

    def _begin_task(self) -> None:
        """Prepare the cell once, before the state is saved that all episodes begin with."""

    def _prepare(self, options: dict[str, Any]) -> None:
        """Bring the cell to the begin of an episode."""
        raise NotImplementedError

    def _potential(self) -> float:
        """The progress of the task. Its increase is the reward."""
        raise NotImplementedError

    def _is_done(self) -> bool:
        """Whether the present goal is reached."""
        raise NotImplementedError

    def _next_goal(self) -> bool:
        """Go on to the next goal. False when there is none."""
        return False

    def _is_lost(self) -> bool:
        """Whether the task cannot be done any more."""
        raise NotImplementedError

    def _values(self) -> Sequence[float]:
        """The numbers of the observation."""
        raise NotImplementedError

    def _task_info(self) -> dict[str, Any]:
        """The task's part of the info."""
        return {}

    # -- begin of episodes --------------------------------------------------------------------

    def _define_spaces(self, observation: str, camera: str | None) -> None:
        self._action_size = sum(arm.size for arm in self._arms)
        self.action_space = Box(-np.ones(self._action_size), np.ones(self._action_size))
        low, high = self._bounds()
        self._state_space = self.observation_space = Box(low, high)
        self._camera = self._choose_camera(camera) if self.render_mode else None
        if observation == "rgb":
            self._eye = self._camera or self._choose_camera(camera)
            self.observation_space = self._image_space(self._eye)

    def _begin(self) -> None:
        """Make and save the initial state of all episodes: bodies at rest, the gripper open, the tool
        above the work."""
        for arm in self._arms:
            arm.robot.take()
            arm.robot.set_speed(self._speed_m_s)
            arm.robot.open_gripper()
        for _ in range(80):
            state = self.cell.step(100, ["bodies"])
            if all(body.resting or body.lost for body in state.bodies.values()):
                break
        self._begin_task()
        self._keep("work")

    def _choose_camera(self, name: str | None) -> Camera:
        if name is not None:
            return self.cell.camera(name)
        cameras = self.cell.cameras()
        if not cameras:
            raise AprsimError(f"the scene '{self.cell.description.scene}' has no camera")
        over = [camera for camera in cameras if camera.description.robot == self.robot.name]
        return (over or cameras)[0]

    def _check_open(self, method: str) -> None:
        if self._is_closed:
            raise AprsimError(f"{method}: the environment is closed")

    def _keep(self, name: str) -> None:
        full = f"{type(self).__name__}-{id(self):x}-{name}"
        self.cell.save(full)
        self._kept.append(full)
        if len(self._kept) > _MAX_KEPT:
            self.cell.delete_state(self._kept.pop(1))

    def _load(self, name: str) -> bool:
        """Load a saved state. False when there is none."""
        full = f"{type(self).__name__}-{id(self):x}-{name}"
        if full not in self._kept:
            return False
        for arm in self._arms:
            arm.stop()
        self.cell.load(full)
        return True

    def _move_near(
        self, robot: Robot, point: Array, yaw: float, spread_m: float, spread_rad: float, above_m: float
    ) -> None:
        """Move the tool to a random place at least `above_m` above a point."""
        offset = self.np_random.uniform(-spread_m, spread_m, 3) + [0, 0, above_m + spread_m]
        turn = float(self.np_random.uniform(-spread_rad, spread_rad))
        robot.move_to(point + offset, yaw + turn)

    # -- one step -----------------------------------------------------------------------------

    def _perform(self, values: Array) -> str | None:
        """Perform an action. Returns the robots' texts for commands that have failed."""
        begin = 0
        for arm in self._arms:
            arm.command(values[begin : begin + arm.size], self._snapshot)
            begin += arm.size
        robots = [arm.robot for arm in self._arms]
        self._snapshot = self._actions.advance(self.cell, robots)
        texts = [text for arm in self._arms if (text := arm.recover()) is not None]
        if not texts:
            return None
        self._snapshot = self.cell.snapshot(FIELDS)
        return "; ".join(texts)

    # -- observations -------------------------------------------------------------------------

    def _image_space(self, camera: Camera) -> Box:
        width, height = (side // self._image_scale for side in camera.size)
        if not width or not height:
            raise arguments.wrong("image_scale", self._image_scale, f"at most {min(camera.size)}")
        shape = (height, width, 3)
        return Box(np.zeros(shape), np.full(shape, 255), dtype=np.uint8)

    def _observation(self) -> Vector | Image:
        return self._state() if self._eye is None else self._image(self._eye)

    def _image(self, camera: Camera) -> Image:
        """A picture in which each pixel is the mean of a square of the camera's."""
        height, width, _ = self.observation_space.shape
        n = self._image_scale
        pixels = camera.rgb()[: n * height, : n * width]
        mean: Image = pixels.reshape(height, n, width, n, 3).mean(axis=(1, 3)).round().astype(np.uint8)
        return mean

    def _state(self) -> Vector:
        out = np.array(self._values(), dtype=np.float32)
        return np.clip(out, self._state_space.low, self._state_space.high)

    def _info(self, refused: str | None) -> dict[str, Any]:
        info = self._task_info()
        info["sim_time_s"] = self._snapshot.sim_time_s
        # An unsigned number: the hash has 64 bits, and arrays of hashes keep them all.
        info["state_hash"] = np.uint64(self._snapshot.state_hash)
        if self._eye is not None:
            info["state"] = self._state()
        if refused is not None:
            info["refused"] = refused
        return info
