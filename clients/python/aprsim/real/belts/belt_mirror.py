"""The belt of the cell, as a real PLC has it by Modbus/TCP."""

from __future__ import annotations

import struct
import threading

from ...calibration.modbus_units import COUNT_M, RUN
from ...cell import Cell
from ...closing import Closing
from ...errors import Refused
from ..base.devices import DeviceLies, DeviceLost, Report
from .modbus_wire import READ_HOLDING, Registers

_REGISTERS = 3  # run, direction, speed
_RETRY_S = 1.0


class BeltReader(Closing):
    """Reads the registers that command a belt; writes none. Thread: one at a time."""

    def __init__(self, host: str, port: int, patience_s: float, forward: int = 1, count_m_s: float = COUNT_M) -> None:
        """`forward` is the value of the direction register for a belt that runs forward, `count_m_s` the
        unit of the speed register. Raises DeviceLost."""
        self._forward, self._count_m_s = forward, count_m_s
        self._registers = Registers(host, port, patience_s)
        self.address = self._registers.address

    def close(self) -> None:
        """Disconnect."""
        self._registers.close()

    def read(self) -> tuple[bool, bool, float]:
        """Whether the belt runs, whether forward, and its speed [m/s]. Raises DeviceLost, DeviceLies."""
        run, direction, speed = struct.unpack(">3H", self._registers.read(READ_HOLDING, RUN, _REGISTERS))
        return run != 0, direction == self._forward, speed * self._count_m_s


class BeltMirror:
    """Lets the cell's belt do what the real PLC commands. While the PLC is lost the belt stands."""

    def __init__(
        self,
        cell: Cell,
        host: str,
        port: int,
        *,
        period_s: float,
        patience_s: float,
        report: Report,
        forward: int = 1,
        count_m_s: float = COUNT_M,
    ) -> None:
        """`forward` and `count_m_s` are those of BeltReader."""
        self._cell, self._period_s, self._report = cell, period_s, report
        self._reader = (host, port, patience_s, forward, count_m_s)
        self._told = ""
        self.follows = threading.Event()
        """Set while the belt follows the PLC."""

    def run(self, ended: threading.Event) -> None:
        """Until the event is set."""
        while not ended.is_set():
            try:
                with BeltReader(*self._reader) as reader:
                    self._follow(reader, ended)
            except (DeviceLost, DeviceLies) as error:
                self._tell(f"belt: the real PLC is lost: {error}")
                self._stop()
            except Refused as error:
                self._tell(f"belt: the cell refuses what the PLC has: {error}")
                self._stop()
            finally:
                self.follows.clear()
            ended.wait(_RETRY_S)

    def _tell(self, text: str) -> None:
        if text != self._told:
            self._told = text
            self._report(text)

    def _stop(self) -> None:
        self._cell.set_conveyor(False)

    def _follow(self, reader: BeltReader, ended: threading.Event) -> None:
        set_to: tuple[bool, bool, float] | None = None
        while not ended.is_set():
            now = reader.read()
            if now != set_to:
                run, forward, speed_m_s = now
                self._cell.set_conveyor(run, forward=forward, speed_m_s=speed_m_s)
                set_to = now
                self._tell(f"belt: follows {reader.address}")
                self.follows.set()
            ended.wait(self._period_s)
