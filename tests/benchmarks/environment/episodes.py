"""Episodes of the task `pick` by the package's scripted policy: in a daemon, with all that they send over
the wires, for a program to do the same; in cells of this process; and steps of a cell at rest there.

usage: episodes.py PORTS_FILE EPISODES OUTPUT"""

from __future__ import annotations

import base64
import json
import pathlib
import sys
import threading
import time
from typing import Any

from aprsim import Cell, World
from aprsim.envs import PickEnv
from aprsim.envs.scripted import scripted_action
from aprsim.robot_wires import RobotSocket

Sent = list[tuple[str, str]]  # what it is, and its bytes
THREADS = 2
REST_STEPS = 100_000


def watch(sent: Sent) -> None:
    """From now on what cells and robots send stands in `sent`."""
    send, run = RobotSocket.send, Cell._run

    def watched_send(wire: RobotSocket, document: bytes) -> None:
        sent.append(("crcl", document.decode()))
        send(wire, document)

    def watched_run(cell: Cell, call: Any) -> Any:
        request = base64.b64encode(call.request.SerializeToString()).decode()
        sent.append((call.method, request))
        return run(cell, call)

    RobotSocket.send, Cell._run = watched_send, watched_run  # type: ignore[method-assign]


def play(env: PickEnv, seed: int) -> dict[str, Any]:
    """An episode: its steps, their time and the state at its end."""
    observation, _ = env.reset(seed=seed)
    env.cell.save(f"episode-{seed}")
    first_step = env.cell.snapshot(["step"]).step
    sent.clear()
    steps, over = 0, False
    began = time.perf_counter()
    while not over:
        observation, _, terminated, truncated, info = env.step(scripted_action(observation))
        over = terminated or truncated
        steps += 1
    taken_s = time.perf_counter() - began
    messages = list(sent)
    end = env.cell.snapshot(["step", "state_hash"])
    return {
        "state": f"episode-{seed}",
        "success": info["is_success"],
        "steps": steps,
        "cell_steps": end.step - first_step,
        "taken_s": taken_s,
        "state_hash": str(end.message.state_hash),
        "sent": messages,
    }


def play_in_threads(episodes: int) -> float:
    """Wall time of the episodes in each of some cells, each in a thread of its own [s]."""
    envs = [PickEnv(World("aprs")) for _ in range(THREADS)]

    def run(env: PickEnv) -> None:
        for seed in range(1, episodes + 1):
            play(env, seed)

    threads = [threading.Thread(target=run, args=(env,)) for env in envs]
    began = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return time.perf_counter() - began


def main(ports_file: str, episodes: int, output: str) -> None:
    watch(sent)
    env = PickEnv(Cell.connect(ports_file))
    opening = [text for kind, text in sent if kind == "crcl" and "Units" in text]
    seeds = range(1, episodes + 1)
    done = [play(env, seed) for seed in seeds]
    world = PickEnv(World("aprs"))
    began = time.perf_counter()
    here = [play(world, seed) for seed in seeds]
    here_s = time.perf_counter() - began
    resting = World("aprs")
    resting.step_without_snapshot(REST_STEPS // 10)
    began = time.perf_counter()
    resting.step_without_snapshot(REST_STEPS)
    rest_s = time.perf_counter() - began
    result = {
        "opening": opening,
        "episodes": done,
        "here": here,
        "here_s": here_s,
        "threads": THREADS,
        "threads_s": play_in_threads(episodes),
        "rest_over_wall": REST_STEPS * resting.step_s / rest_s,
    }
    pathlib.Path(output).write_text(json.dumps(result), encoding="utf-8")


sent: Sent = []

if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), sys.argv[3])
