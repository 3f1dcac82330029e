"""Episodes of the task `pick` by the package's scripted policy, and all that they send over the wires,
for a program to do the same.

usage: episodes.py PORTS_FILE EPISODES OUTPUT"""

from __future__ import annotations

import base64
import json
import pathlib
import sys
import time
from typing import Any

from aprsim import Cell, Robot
from aprsim.envs import PickEnv
from aprsim.envs.scripted import scripted_action

Sent = list[tuple[str, str]]  # what it is, and its bytes


def watch(sent: Sent) -> None:
    """From now on what cells and robots send stands in `sent`."""
    send, run = Robot._send, Cell._run

    def watched_send(robot: Robot, document: bytes) -> None:
        sent.append(("crcl", document.decode()))
        send(robot, document)

    def watched_run(cell: Cell, call: Any) -> Any:
        request = base64.b64encode(call.request.SerializeToString()).decode()
        sent.append((call.method, request))
        return run(cell, call)

    Robot._send, Cell._run = watched_send, watched_run  # type: ignore[method-assign]


def main(ports_file: str, episodes: int, output: str) -> None:
    sent: Sent = []
    watch(sent)
    cell = Cell.connect(ports_file)
    env = PickEnv(cell)
    opening = [text for kind, text in sent if kind == "crcl" and "Units" in text]
    done = []
    for seed in range(1, episodes + 1):
        observation, _ = env.reset(seed=seed)
        cell.save(f"episode-{seed}")
        first_step = cell.snapshot(["step"]).step
        sent.clear()
        steps, over = 0, False
        began = time.perf_counter()
        while not over:
            observation, _, terminated, truncated, info = env.step(scripted_action(observation))
            over = terminated or truncated
            steps += 1
        taken_s = time.perf_counter() - began
        messages = list(sent)
        end = cell.snapshot(["step", "state_hash"])
        done.append(
            {
                "state": f"episode-{seed}",
                "success": info["is_success"],
                "steps": steps,
                "cell_steps": end.step - first_step,
                "taken_s": taken_s,
                "state_hash": str(end.message.state_hash),
                "sent": messages,
            }
        )
    pathlib.Path(output).write_text(
        json.dumps({"opening": opening, "episodes": done}), encoding="utf-8"
    )


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), sys.argv[3])
