"""Reads orders from standard input while the robots work, one JSON object a line. Results are printed in
the same form on standard output."""

from __future__ import annotations

import json
import threading
from typing import TextIO

from cell import Cell, CellError
from orders import Board, read_order
from report import Report


class OrderLines(threading.Thread):
    """Reads until the input ends; then no more orders come.

    {"announce": "first", "tray": "kit_s2l2_vessel", "count": 1, "priority": 0, "slots": {...}}
    {"cancel": "first"}
    {"end": true}              end of this job's orders; another job may follow
    """

    def __init__(self, source: TextIO, cell: Cell, board: Board, report: Report) -> None:
        super().__init__(name="orders", daemon=True)
        self._source, self._cell, self._board, self._report = source, cell, board, report
        self.more = False  # another job may follow on the input

    def run(self) -> None:
        for number, line in enumerate(self._source, 1):
            if not line.strip():
                continue
            try:
                message = json.loads(line)
                if isinstance(message, dict) and message.get("end") is True:
                    self.more = True
                    break
                self._take(message, f"line {number}")
            except CellError as error:
                self._report.log("orders", "order_error", str(error))
            except ValueError as error:
                self._report.log("orders", "order_error", f"line {number}: {error}")
        self._board.taking_orders = False
        self._report.log("orders", "orders_end", "no more orders come")

    def _take(self, message: object, where: str) -> None:
        if isinstance(message, dict) and isinstance(message.get("announce"), str):
            row = dict(message)
            name = row.pop("announce")
            orders = read_order(row, where, self._cell, name)
            self._board.announce(orders)
            # The sender may wait for this line.
            self._report.log("orders", "announced", f"{name} is ordered", order=name)
        elif isinstance(message, dict) and isinstance(message.get("cancel"), str):
            name = message["cancel"]
            left = self._board.cancel(name)
            text = f"{name} is cancelled" if left else f"nothing of {name} is left to be cancelled"
            self._report.log("orders", "cancelled", text, order=name)
        else:
            raise CellError(f"{where}: announce or cancel with the name of an order is expected")
