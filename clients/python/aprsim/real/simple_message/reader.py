"""States of a robot from its Simple Message ports. It sends nothing to the state port, and questions
alone to the gripper's."""

from __future__ import annotations

import struct
import time
from dataclasses import dataclass
from typing import Callable

from ...closing import Closing
from ..base.device_socket import DeviceSocket
from ..base.devices import DeviceLies
from ..robots.robot_source import RobotReader, RobotReading, RobotSource
from .messages import FANUC, HEADER, READ_BIT, READ_BIT_REPLY, Controller, States, joints_of, kind_of, message

Address = tuple[str, int]

_ASK_GRIPPER = 8  # states between two questions
_FANUC_STATE = 3
_OPEN_VALVE = 10010
_FOLLOW = 0.2  # of the difference between expected and seen time of arrival
_LONGEST_GAP_S = 0.5  # after which times begin anew


@dataclass(frozen=True)
class Watch:
    """How a relay takes part in the reading."""

    state: Callable[[bytes], None] = lambda _: None
    """Receives each message of the state port as it came."""
    gripper: Callable[[], float | None] = lambda: None
    """The gripper's latest setting that has passed: 0 closed, 1 open."""


class SendTimes:
    """Estimates when messages of a steady sender were sent, from when they were received: later by a
    delay that varies. Thread: one at a time."""

    def __init__(self, period_s: float) -> None:
        self._period_s = period_s
        self._last_s: float | None = None

    def add(self, received_s: float, count: int = 1) -> float:
        """The time of the latest one of `count` further messages; never after it was received."""
        if self._last_s is None or received_s - self._last_s > count * self._period_s + _LONGEST_GAP_S:
            self._last_s = received_s
            return received_s
        expected_s = self._last_s + count * self._period_s
        estimated_s = min(received_s, expected_s + _FOLLOW * (received_s - expected_s))
        self._last_s = max(estimated_s, self._last_s)
        return self._last_s


class GripperReader(Closing):
    """Asks a gripper's port what was commanded. Thread: one at a time."""

    def __init__(self, address: Address, controller: Controller, patience_s: float) -> None:
        """Raises DeviceLost."""
        self._controller = controller
        self._device = DeviceSocket(*address, patience_s)

    def close(self) -> None:
        """Disconnect."""
        self._device.close()

    def setting(self) -> float:
        """0 closed, 1 open. Raises DeviceLost, DeviceLies."""
        if self._controller is FANUC:
            self._device.ask(struct.pack(">i", _FANUC_STATE))
            (state,) = struct.unpack(">i", self._device.exactly(4))
            if state not in (0, 1):
                raise DeviceLies(f"{self._device.address}: gripper state {state}, where 0 or 1 is expected")
            return 1.0 if state == 0 else 0.0
        self._device.ask(message(READ_BIT, struct.pack(">i", _OPEN_VALVE)))
        answer = self._device.exactly(HEADER.size + 8)
        value, result = struct.unpack_from(">2i", answer, HEADER.size)
        if kind_of(answer) != READ_BIT_REPLY or result != 0 or value not in (0, 1):
            raise DeviceLies(f"{self._device.address}: answers {answer.hex(' ')} to output {_OPEN_VALVE}")
        return float(value)


class SimpleMessageReader(RobotReader):
    """Reads a state port to its latest message."""

    pushes = True

    def __init__(
        self,
        state: Address,
        gripper: Address | None,
        controller: Controller,
        joints: int,
        patience_s: float,
        watch: Watch | None = None,
    ) -> None:
        """`joints` is their number. Raises DeviceLost."""
        self._controller, self._joints, self._watch = controller, joints, watch or Watch()
        self._states, self._times = States(), SendTimes(controller.period_s)
        self._setting: float | None = None
        self._until_asked = 0
        self._gripper: GripperReader | None = None
        self._device = DeviceSocket(*state, patience_s)
        self.address = self._device.address
        try:
            if gripper is not None:
                self._gripper = GripperReader(gripper, controller, patience_s)
        except BaseException:
            self._device.close()
            raise

    def close(self) -> None:
        """Disconnect."""
        self._device.close()
        if self._gripper is not None:
            self._gripper.close()

    def read(self) -> RobotReading:
        """Wait for a state. Raises DeviceLost without one in time, DeviceLies for bytes that are none."""
        self._ask_gripper()
        self._device.ask(b"")  # the wait begins
        while True:
            received_s = time.monotonic()
            messages = self._cut(self._device.receive())
            positions = [joints_of(one, self._controller, self._joints) for one in messages]
            joints = [one for one in positions if one is not None]
            if joints:
                at_s = self._times.add(time.monotonic(), len(joints))
                late_s = max(time.monotonic() - received_s - self._controller.period_s, 0.0)
                return RobotReading(
                    at_s=at_s, uncertain_s=late_s, joints_rad=joints[-1], gripper_setting=self._setting
                )

    def _cut(self, data: bytes) -> list[bytes]:
        try:
            messages = self._states.add(data)
        except DeviceLies as error:
            raise DeviceLies(f"{self.address}: {error}") from None
        for one in messages:
            self._watch.state(one)
        return messages

    def _ask_gripper(self) -> None:
        if self._gripper is None:
            self._setting = self._watch.gripper()
            return
        self._until_asked -= 1
        if self._until_asked < 0:
            self._until_asked = _ASK_GRIPPER - 1
            self._setting = self._gripper.setting()


def simple_message_source(
    state: Address,
    gripper: Address | None,
    controller: Controller,
    joints: int,
    *,
    patience_s: float,
    watch: Watch | None = None,
) -> RobotSource:
    """A robot by Simple Message."""
    return RobotSource(
        lambda: SimpleMessageReader(state, gripper, controller, joints, patience_s, watch), controller.period_s
    )
