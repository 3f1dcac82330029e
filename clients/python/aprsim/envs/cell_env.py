"""The common part of the tasks: the cell, the robot's actions, observations, resets."""

from __future__ import annotations

import contextlib
import math
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import arguments, crcl
from ..cameras import Camera
from ..cell import Cell
from ..daemon import Daemon
from ..errors import AprsimError, BadArgument, Refused, RobotError, TimedOut, Unreachable
from ..poses import Array, matrix, tool_down, wrapped, yaw_of
from ..snapshots import Snapshot
from .layout import Layout, Transfer
from .spaces import Box, Env, Image, Vector

MOVE_M, TURN_RAD = 0.05, 0.3  # motion of the tool in a step for an action of 1
_POLL_S, _LEAST_POLLS, _MOST_POLLS = 0.05, 2, 40  # simulated time between polls of a motion
APPROACH_M = 0.06  # height above the place where a gear is grasped or released
_SPEED_M_S = 0.5
_STILL_M, _STILL_RAD = 1e-6, 1e-6  # a smaller action is no motion
_WORKING = 2  # ActionState
_FIELDS = ("step", "epoch", "sim_time", "robots", "bodies", "world_fault", "state_hash")
_SEATED_M = 0.001
_MAX_KEPT = 32  # saved states of one environment

OBSERVATION_NAMES = (
    "gear_from_tool_x_m",
    "gear_from_tool_y_m",
    "gear_from_tool_z_m",
    "slot_from_gear_x_m",
    "slot_from_gear_y_m",
    "slot_from_gear_z_m",
    "turn_to_clear_rad",
    "opening_m",
    "held",
    "filled",
)


class CellEnv(Env):
    """A task of one robot in a paused cell, with Gymnasium's signatures. Subclasses define the begin of
    an episode (`_prepare`), its value (`_potential`) and its end (`_is_done`).

    Without a cell the environment starts a daemon of its own, which ends with `close` or with this
    process. A cell that is given is paused and belongs to the environment until `close`. Errors are
    those of the cell, and BadArgument. Thread: one."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 10}
    observation_names = OBSERVATION_NAMES
    _eye: Camera | None = None  # whose pictures are the observations
    _opened = True  # the last command to the gripper
    _is_ready = False  # an episode has begun
    _is_closed = False
    _plan: list[Transfer] = []

    def __init__(
        self,
        cell: Cell | None = None,
        *,
        robot: str = "fanuc",
        scene: str = "aprs",
        reach_m: float = 0.62,
        max_steps: int = 200,
        render_mode: str | None = None,
        camera: str | None = None,
        observation: str = "state",
        image_scale: int = 4,
    ) -> None:
        """`scene` is for a daemon of its own. The task uses gears and slots within `reach_m` of the
        robot's base. An episode is truncated after `max_steps`. `render_mode` may be "rgb_array", for
        pictures by `camera`; by default the one over the robot, else the first of the scene.
        `observation` is "state", the numbers of `observation_names`, or "rgb", a picture by `camera`
        whose sides are divided by `image_scale`; then `info["state"]` has the numbers."""
        reach_m = arguments.number("reach_m", reach_m, "m", above=0)
        max_steps = arguments.whole("max_steps", max_steps, 1, 1 << 62)
        if render_mode not in (None, "rgb_array"):
            raise arguments.wrong("render_mode", render_mode, 'None or "rgb_array"')
        if observation not in ("state", "rgb"):
            raise arguments.wrong("observation", observation, '"state" or "rgb"')
        self._image_scale = arguments.whole("image_scale", image_scale, 1, 64)
        self.render_mode = render_mode
        self._kept: list[str] = []
        self._owned = cell is None
        self._daemon = None if cell is not None else Daemon(scene=scene, speed="stepped")
        try:
            self.cell = cell or Cell.connect(self._daemon.ports_file if self._daemon else None)
            if not self.cell.paused:
                self.cell.pause()
            self.robot = self.cell.robot(robot)
            self.max_steps = max_steps
            self._reach_m = reach_m
            self._poll_steps = round(_POLL_S / self.cell.step_s)
            self.action_space = Box(-np.ones(5), np.ones(5))
            low = np.array([-2.0] * 6 + [-math.pi, 0.0, 0.0, 0.0])
            high = np.array([2.0] * 6 + [math.pi, 0.2, 1.0, 1.0])
            self._state_space = self.observation_space = Box(low, high)
            self._camera = self._choose_camera(camera) if render_mode else None
            if observation == "rgb":
                self._eye = self._camera or self._choose_camera(camera)
                self.observation_space = self._image_space(self._eye)
            self._begin()
        except BaseException:
            self.close()
            raise

    # -- Gymnasium ----------------------------------------------------------------------------

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Vector | Image, dict[str, Any]]:
        """Begin an episode from a saved state and random numbers. The same seed begins the same episode,
        bit for bit; without one the random numbers continue. `options` may have "tray", the kit tray of
        the task, and "slot"."""
        self._check_open("reset")
        self._is_ready = False
        super().reset(seed=None if seed is None else arguments.whole("seed", seed, 0, 1 << 62))
        chosen = options or {}
        unknown = set(chosen) - {"tray", "slot"}
        if unknown:
            raise BadArgument(f"options: {sorted(unknown)}, where tray and slot are known")
        self._taken_steps = 0
        self._filled = 0
        self._plan = self._prepare(chosen)
        self._count = len(self._plan)
        self._last = self._plan[-1]
        self._snapshot = self.cell.snapshot(_FIELDS)
        self._value = self._potential()
        self._is_ready = True
        return self._observation(), self._info(None)

    def step(
        self, action: npt.ArrayLike
    ) -> tuple[Vector | Image, float, bool, bool, dict[str, Any]]:
        """Perform an action: five numbers from -1 to 1 for the tool's motion along x, y, z of the world
        (1 = 50 mm), its turn (1 = 0.3 rad) and the gripper (above 0 = open). The step lasts to the end
        of the motion, at least 0.1 s of simulated time. Returns observation, reward, terminated,
        truncated, info. AprsimError without an episode: `reset` begins one."""
        self._check_open("step")
        if not self._is_ready:
            raise AprsimError("step: no episode has begun; call reset() first")
        values = np.clip(arguments.vector("action", action, 5, "-1 to 1"), -1.0, 1.0)
        self._command(values)
        refused = self._await_end()
        self._taken_steps += 1
        lost = self._gear_is_lost() or bool(self._snapshot.world_fault)
        value = self._potential() if not lost else self._value - 1.0
        reward = value - self._value
        done = False
        if not lost and self._is_done():
            reward += 1.0
            self._filled += 1
            self._plan = self._plan[1:]
            done = not self._plan
            value = value if done else self._potential()
        self._value = value
        terminated = lost or done
        truncated = not terminated and self._taken_steps >= self.max_steps
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

    # -- tasks --------------------------------------------------------------------------------

    def _prepare(self, options: dict[str, Any]) -> list[Transfer]:
        """Bring the cell to the begin of an episode. Returns its transfers."""
        raise NotImplementedError

    def _potential(self) -> float:
        """The progress of the transfer. Its increase is the reward."""
        raise NotImplementedError

    def _is_done(self) -> bool:
        """Whether the transfer is done."""
        raise NotImplementedError

    # -- begin of episodes --------------------------------------------------------------------

    def _begin(self) -> None:
        """Make and save the initial state of all episodes: bodies at rest, the gripper open, the tool
        above the work."""
        self.robot.take()
        self.robot.set_speed(_SPEED_M_S)
        self.robot.open_gripper()
        for _ in range(80):
            state = self.cell.step(100, ["bodies"])
            if all(body.resting or body.lost for body in state.bodies.values()):
                break
        self._neutral_yaw = yaw_of(self.robot.tool())
        layout = self._layout()
        self._slots = {
            (body.name, slot.name): matrix(slot.slot_in_tray)
            for body in self.cell.description.bodies
            for slot in body.tray.slots
        }
        self._trays = [tray for tray in layout.kit_trays() if self._transfers(layout, tray)]
        if not self._trays:
            raise AprsimError(
                f"the scene has no kit tray with a free slot and a gear for it within "
                f"{self._reach_m:g} m of {self.robot.name}"
            )
        self._keep("work")

    def _layout(self) -> Layout:
        return Layout(self.cell.description, self.cell.snapshot(["bodies"]))

    def _transfers(self, layout: Layout, tray: str) -> list[Transfer]:
        return layout.transfers(
            self.robot.description, tray, reach_m=self._reach_m, neutral_yaw=self._neutral_yaw
        )

    def _keep(self, name: str) -> None:
        full = f"{type(self).__name__}-{id(self):x}-{name}"
        self.cell.save(full)
        self._kept.append(full)
        if len(self._kept) > _MAX_KEPT:
            self.cell.delete_state(self._kept.pop(1))

    def _load(self, name: str) -> bool:
        """Load a saved state. False when there is none. The robot's last command ends before: after a
        return to a state before it, the robot would report an error."""
        full = f"{type(self).__name__}-{id(self):x}-{name}"
        if full not in self._kept:
            return False
        try:
            self.robot.run(crcl.stop())
        except RobotError:
            self.robot.run(crcl.initialise(), 35)
        except Refused:
            pass  # the simulation has stopped on a fault; loading clears it
        self.cell.load(full)
        return True

    def _choose(self, options: dict[str, Any]) -> str:
        tray = options.get("tray")
        if tray is None:
            return str(self.np_random.choice(self._trays))
        if tray not in self._trays:
            raise BadArgument(f"options: tray '{tray}', where {', '.join(self._trays)} are known")
        return str(tray)

    def _choose_transfer(self, options: dict[str, Any]) -> Transfer:
        """A transfer of the loaded state: the one in `options`, or a random one."""
        transfers = self._transfers(self._layout(), self._choose(options))
        slot = options.get("slot")
        if slot is None:
            return transfers[int(self.np_random.integers(len(transfers)))]
        named = {transfer.slot: transfer for transfer in transfers}
        if slot not in named:
            raise BadArgument(f"options: slot '{slot}', where {', '.join(named)} are known")
        return named[str(slot)]

    def _go_near(self, point: Array, yaw: float, spread_m: float, spread_rad: float) -> None:
        """Move the tool to a random place above a point."""
        offset = self.np_random.uniform(-spread_m, spread_m, 3) + [0, 0, APPROACH_M + spread_m]
        turn = float(self.np_random.uniform(-spread_rad, spread_rad))
        self.robot.move_to(point + offset, yaw + turn)

    # -- one step -----------------------------------------------------------------------------

    def _command(self, action: Array) -> None:
        opened = bool(action[4] > 0)
        if opened != self._opened:
            self.robot.start(crcl.set_gripper(1.0 if opened else 0.0))
            self._opened = opened
        way, turn = MOVE_M * action[:3], TURN_RAD * float(action[3])
        if np.linalg.norm(way) < _STILL_M and abs(turn) < _STILL_RAD:
            return
        tool = self._tool()
        target = tool_down(tool[:3, 3] + way, yaw_of(tool) + turn)
        self.robot.start(self.robot.move_command(target, straight=True))

    def _await_end(self) -> str | None:
        """Step the cell until the robot's command ends. Returns the robot's text for a command that has
        failed, after initialising it again."""
        for polls in range(1, _MOST_POLLS + 1):
            self._snapshot = self.cell.step(self._poll_steps, _FIELDS)
            state = self._snapshot.robot(self.robot.name).message.action.state
            if polls >= _LEAST_POLLS and state != _WORKING:
                break
        status = self.robot.status()
        if not status.failed:
            return None
        self.robot.run(crcl.initialise(), 35)
        self._snapshot = self.cell.snapshot(_FIELDS)
        return status.description

    # -- observations -------------------------------------------------------------------------

    @property
    def transfer(self) -> Transfer | None:
        """The present transfer; None when all are done, and before `reset`."""
        return self._plan[0] if self._plan else None

    def _current(self) -> Transfer:
        return self._plan[0] if self._plan else self._last

    def _tool(self) -> Array:
        return self._snapshot.robot(self.robot.name).tool_in_world

    def _gear(self) -> Array:
        return self._snapshot.body(self._current().gear).position_m

    def _slot(self) -> Array:
        transfer = self._current()
        tray = self._snapshot.body(transfer.tray).pose
        position: Array = (tray @ self._slots[transfer.tray, transfer.slot])[:3, 3]
        return position

    def _gear_from_tool(self) -> Array:
        grasp = np.array([0.0, 0.0, self._current().grasp_height_m])
        out: Array = self._gear() + grasp - self._tool()[:3, 3]
        return out

    def _slot_from_gear(self) -> Array:
        return self._slot() - self._gear()

    def _held(self) -> bool:
        return self._snapshot.robot(self.robot.name).held_body == self._current().gear

    def _gear_is_lost(self) -> bool:
        return self._snapshot.body(self._current().gear).lost

    def _is_seated(self) -> bool:
        """Whether the gear rests in its slot and no gripper holds it."""
        near = float(np.linalg.norm(self._slot_from_gear())) < _SEATED_M
        return near and not self._held() and self._snapshot.body(self._current().gear).resting

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
        turn = wrapped(self._current().yaw - yaw_of(self._tool()))
        # Half a turn exchanges the fingers, which are the same.
        turn = (turn + math.pi / 2) % math.pi - math.pi / 2
        robot = self._snapshot.robot(self.robot.name)
        values = [*self._gear_from_tool(), *self._slot_from_gear(), turn, robot.separation_m]
        values += [float(self._held()), self._filled / max(1, self._count)]
        out = np.array(values, dtype=np.float32)
        return np.clip(out, self._state_space.low, self._state_space.high)

    def _info(self, refused: str | None) -> dict[str, Any]:
        transfer = self._current()
        info: dict[str, Any] = {
            "gear": transfer.gear,
            "slot": f"{transfer.tray}/{transfer.slot}",
            "sim_time_s": self._snapshot.sim_time_s,
            "state_hash": self._snapshot.state_hash,
        }
        if self._eye is not None:
            info["state"] = self._state()
        if refused is not None:
            info["refused"] = refused
        return info
