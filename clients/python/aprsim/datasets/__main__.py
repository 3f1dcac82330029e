"""Records episodes of an environment as an HDF5 file, or replays one and compares each state.

exit codes: 0 done, all states the same; 1 a state differs; 2 a wrong argument or file"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any, Sequence

from ..envs import specs
from ..errors import AprsimError
from .episode import Episode
from .recording import record
from .replaying import replay_all


def main(arguments: Sequence[str] | None = None) -> int:
    """The program. Returns its exit code."""
    options = _command_line().parse_args(arguments)
    try:
        code: int = options.run(options)
        return code
    except AprsimError as error:
        print(f"datasets: {error}", file=sys.stderr)
        return 2


def _command_line() -> argparse.ArgumentParser:
    text, _, details = (__doc__ or "").partition("\n\n")
    parser = argparse.ArgumentParser(
        prog="python3 -m aprsim.datasets",
        description=text,
        epilog=details,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(required=True, metavar="record|replay")
    recorder = commands.add_parser("record", help="record episodes in a new file")
    recorder.set_defaults(run=_record)
    recorder.add_argument("file", type=Path, help="file to write (.hdf5)")
    recorder.add_argument("--env", choices=sorted(specs), default="aprsim/Pick-v0", help="environment (default aprsim/Pick-v0)", metavar="NAME")
    recorder.add_argument("--scene", help="scene of the cell, by name or file")
    recorder.add_argument("--episodes", type=int, default=10, help="number of episodes (default 10)")
    recorder.add_argument("--seed", type=int, default=0, help="seed of the first episode (default 0)")
    recorder.add_argument("--policy", choices=["scripted", "random"], default="scripted", help="source of the actions (default scripted)")
    recorder.add_argument("--images", action="store_true", help="record pictures too")
    recorder.add_argument("--image-scale", type=int, default=4, help="divisor of a picture's sides (default 4)")
    recorder.add_argument("--max-steps", type=int, help="steps after which an episode is truncated")
    replayer = commands.add_parser("replay", help="run episodes again and compare each state")
    replayer.set_defaults(run=_replay)
    replayer.add_argument("file", type=Path, help="data set")
    replayer.add_argument("--episode", type=int, action="append", help="episode, from 0; may be repeated (default all)")
    return parser


def _record(options: argparse.Namespace) -> int:
    keywords: dict[str, Any] = {}
    if options.images:
        keywords = {"observation": "rgb", "image_scale": options.image_scale}
    if options.scene is not None:
        keywords["scene"] = options.scene
    if options.max_steps is not None:
        keywords["max_steps"] = options.max_steps
    successes = record(
        options.file,
        options.env,
        episodes=options.episodes,
        seed=options.seed,
        policy=options.policy,
        on_episode=_show,
        **keywords,
    )
    print(f"{options.file}: {options.episodes} episodes, {successes} with success")
    return 0


def _show(number: int, episode: Episode) -> None:
    end = "success" if episode.is_success else "no success"
    print(f"episode {number}: seed {episode.seed}, {len(episode)} steps, {end}")


def _replay(options: argparse.Namespace) -> int:
    code = 0
    for done in replay_all(options.file, options.episode):
        if done.is_same:
            print(f"episode {done.episode}: {done.steps + 1} states are the same")
        else:
            print(f"episode {done.episode}: the state after step {done.first_difference} differs")
            code = 1
    return code


if __name__ == "__main__":
    sys.exit(main())
