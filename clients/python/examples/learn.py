"""Learns a task by soft actor-critic (Haarnoja et al. 2018, arXiv:1812.05905). Half of each batch comes from some
episodes of the scripted policy, and the critics have layer norm (Ball et al. 2023, arXiv:2302.02948).

It needs Debian's `python3-torch`; `libopenblas0` makes it several times faster.

usage: learn.py [--task Pick] [--seed 1] [--steps 5000] [--demonstrations 60] [--curve FILE] [--policy FILE]
       learn.py [--task Pick] --play FILE [--episodes 100] [--film FOLDER [--scene FILE] [--camera NAME]]

The first form learns, and writes the curve as CSV and the policy as NPZ. The second one plays a policy; the
film has a picture (PPM) for every 50 ms."""

from __future__ import annotations

import argparse
import copy
import csv
import pathlib
import time
from dataclasses import dataclass
from typing import Any, Callable

import numpy as np
import numpy.typing as npt
import torch
from torch import nn

from aprsim.envs import SyncVectorEnv, make, make_vec

Numbers = npt.NDArray[np.float32]
Episode = dict[str, float]

SCALES = (0.05, 0.005)  # a coarse and a fine scale of the numbers of an observation
LARGEST = 5.0  # number at the coarse scale
LOG_STD = (-5.0, 1.0)
EPISODE_STEPS = 30
REPORTED = 50  # episodes


@dataclass(frozen=True)
class Settings:
    """Settings of the learner."""

    hidden: int = 64
    batch: int = 128
    rate: float = 1e-3
    discount: float = 0.9
    target_rate: float = 0.01
    random_steps: int = 300
    capacity: int = 100_000
    entropy: float = -1.5
    """Target entropy of the policy, for each number of an action."""
    log_alpha: float = -4.0
    """Begin of the entropy's weight."""
    demonstrations: int = 60
    noise: float = 0.2
    """Deviation of the demonstrations' actions in half of their steps."""


# -- networks ---------------------------------------------------------------------------------


def features(observations: npt.ArrayLike) -> Numbers:
    """Each number at two scales: the coarse one tells how far, the fine one how near."""
    values = np.asarray(observations, dtype=np.float32)
    coarse = np.clip(values / SCALES[0], -LARGEST, LARGEST)
    return np.concatenate([coarse, np.tanh(values / SCALES[1])], axis=-1)


def network(inputs: int, outputs: int, hidden: int, normed: bool) -> Any:
    """Two hidden layers."""
    layers: list[Any] = []
    for size in (inputs, hidden):
        layers.append(nn.Linear(size, hidden))
        if normed:
            layers.append(nn.LayerNorm(hidden))
        layers.append(nn.ReLU())
    return nn.Sequential(*layers, nn.Linear(hidden, outputs))


class Agent:
    """The policy, two critics, their slow copies, and the weight of the entropy."""

    def __init__(self, inputs: int, actions: int, settings: Settings) -> None:
        self._settings = settings
        self.actor = network(inputs, 2 * actions, settings.hidden, normed=False)
        self._critics = nn.ModuleList(
            network(inputs + actions, 1, settings.hidden, normed=True) for _ in range(2)
        )
        self._targets = copy.deepcopy(self._critics)
        self._log_alpha = torch.tensor(settings.log_alpha, requires_grad=True)
        self._target_entropy = settings.entropy * actions
        self._actor_steps = torch.optim.Adam(self.actor.parameters(), settings.rate)
        self._critic_steps = torch.optim.Adam(self._critics.parameters(), settings.rate)
        self._alpha_steps = torch.optim.Adam([self._log_alpha], 3 * settings.rate)

    def act(self, observations: npt.ArrayLike, random: bool = True) -> Numbers:
        """Actions for observations; the policy's means unless `random`."""
        with torch.no_grad():
            mean, log_std = self._distribution(torch.from_numpy(features(observations)))
            chosen = mean + log_std.exp() * torch.randn_like(mean) if random else mean
            actions: Numbers = torch.tanh(chosen).numpy()
            return actions

    def update(self, batch: tuple[Any, ...]) -> float:
        """One step of the critics, the policy and the entropy's weight. Returns the critics' loss."""
        seen, actions, rewards, after, ongoing = batch
        alpha = self._log_alpha.exp().detach()
        with torch.no_grad():
            following, log_likely = self._sample(after)
            value = _lesser(self._targets, after, following) - alpha * log_likely
            wanted = rewards + self._settings.discount * ongoing * value
        both = torch.cat([seen, actions], dim=1)
        loss = sum(nn.functional.mse_loss(each(both)[:, 0], wanted) for each in self._critics)
        _descend(self._critic_steps, loss)
        chosen, log_likely = self._sample(seen)
        gain = _lesser(self._critics, seen, chosen) - alpha * log_likely
        _descend(self._actor_steps, -gain.mean())
        excess = (log_likely + self._target_entropy).mean().detach()
        _descend(self._alpha_steps, -self._log_alpha * excess)
        with torch.no_grad():
            for slow, fast in zip(self._targets.parameters(), self._critics.parameters()):
                slow.lerp_(fast, self._settings.target_rate)
        return float(loss)

    def set_rate(self, share: float) -> None:
        """Let policy and critics learn at a share of the settings' rate."""
        for optimizer in (self._actor_steps, self._critic_steps):
            for group in optimizer.param_groups:
                group["lr"] = share * self._settings.rate

    def save(self, path: str) -> None:
        """Write the policy's weights."""
        weights = {name: value.numpy() for name, value in self.actor.state_dict().items()}
        np.savez(path, **weights)

    @classmethod
    def load(cls, path: str) -> Agent:
        """A policy that `save` has written, with new critics."""
        with np.load(path) as file:
            weights = {name: torch.from_numpy(file[name]) for name in file}
        first, *_, last = weights.values()
        agent = cls(weights["0.weight"].shape[1], len(last) // 2, Settings(hidden=len(first)))
        agent.actor.load_state_dict(weights)
        return agent

    def _distribution(self, seen: Any) -> tuple[Any, Any]:
        mean, spread = self.actor(seen).chunk(2, dim=1)
        low, high = LOG_STD
        return mean, low + 0.5 * (high - low) * (1 + torch.tanh(spread))

    def _sample(self, seen: Any) -> tuple[Any, Any]:
        """Actions, and the logarithm of their density after tanh."""
        mean, log_std = self._distribution(seen)
        noise = torch.randn_like(mean)
        raw = mean + log_std.exp() * noise
        density = -0.5 * noise**2 - log_std - 0.9189385
        squashing = 2 * (0.6931472 - raw - nn.functional.softplus(-2 * raw))
        return torch.tanh(raw), (density - squashing).sum(dim=1)


def _lesser(critics: Any, seen: Any, actions: Any) -> Any:
    both = torch.cat([seen, actions], dim=1)
    one, other = (critic(both)[:, 0] for critic in critics)
    return torch.minimum(one, other)


def _descend(optimizer: Any, loss: Any) -> None:
    optimizer.zero_grad()
    loss.backward()
    optimizer.step()


# -- experience -------------------------------------------------------------------------------


class Memory:
    """The latest steps."""

    def __init__(self, inputs: int, actions: int, capacity: int, seed: int) -> None:
        shapes = {"seen": inputs, "action": actions, "reward": 1, "after": inputs, "ongoing": 1}
        self._rows = {name: np.zeros((capacity, n), np.float32) for name, n in shapes.items()}
        self._capacity, self.count = capacity, 0
        self._random = np.random.default_rng(seed)

    def add(self, seen: Numbers, action: Numbers, reward: float, after: Numbers, ended: bool) -> None:
        """Remember a step. `ended` tells that no reward can follow."""
        values = (features(seen), action, reward, features(after), not ended)
        for rows, value in zip(self._rows.values(), values):
            rows[self.count % self._capacity] = value
        self.count += 1

    def batch(self, size: int) -> list[Any]:
        """Random steps; none of an empty memory."""
        chosen = self._random.integers(min(self.count, self._capacity), size=size)
        arrays = [torch.from_numpy(rows[chosen]) for rows in self._rows.values()]
        seen, actions, rewards, after, ongoing = arrays
        return [seen, actions, rewards[:, 0], after, ongoing[:, 0]]


def demonstrate(env: Any, memory: Memory, settings: Settings, seed: int) -> None:
    """Remember episodes by the scripted policy, half of whose actions have some noise."""
    random = np.random.default_rng(seed)
    for episode in range(settings.demonstrations):
        seen, _ = env.reset(seed=1_000_000 * seed + 500_000 + episode)
        over = False
        while not over:
            action = env.scripted_action(seen)
            spread = random.normal(0.0, settings.noise, action.shape) * (random.random() < 0.5)
            action = np.clip(action + spread, -1.0, 1.0).astype(np.float32)
            after, reward, ended, cut, _ = env.step(action)
            memory.add(seen, action, reward, after, ended)
            seen, over = after, ended or cut


# -- learning ---------------------------------------------------------------------------------


def learn(
    envs: SyncVectorEnv,
    steps: int,
    seed: int,
    settings: Settings = Settings(),
    report: Callable[[list[Episode]], None] = lambda curve: None,
) -> tuple[Agent, list[Episode]]:
    """Learn in `steps` steps of all environments together, which reset in the step of an end. Returns the
    agent and the curve: for each episode the steps so far, success, return, length, and the time of
    processors [s]."""
    torch.manual_seed(seed)
    envs.action_space.seed(seed)
    seen, _ = envs.reset(seed=1_000_000 * seed)
    size, inputs = envs.single_action_space.shape[0], features(seen).shape[1]
    agent = Agent(inputs, size, settings)
    memory, shown = (Memory(inputs, size, settings.capacity, seed) for _ in range(2))
    if settings.demonstrations:
        demonstrate(envs.envs[0], shown, settings, seed)
        seen, _ = envs.reset()
    returns, lengths = np.zeros((2, envs.num_envs))
    curve: list[Episode] = []
    for taken in range(0, steps, envs.num_envs):
        explores = taken < settings.random_steps
        actions = envs.action_space.sample() if explores else agent.act(seen)
        after, rewards, ended, cut, infos = envs.step(actions)
        returns += rewards
        lengths += 1
        for i, over in enumerate(ended | cut):
            last = infos["final_obs"][i] if over else after[i]
            memory.add(seen[i], actions[i], rewards[i], last, bool(ended[i]))
            if over:
                success = float(infos["final_info"]["is_success"][i])
                curve.append(_episode(taken + envs.num_envs, success, returns[i], lengths[i]))
                returns[i] = lengths[i] = 0
                report(curve)
        seen = after
        # The second half of the time, more and more slowly.
        agent.set_rate(min(1.0, max(0.1, 2.0 * (1.0 - taken / steps))))
        for _ in range(0 if explores else envs.num_envs):
            agent.update(_batch(memory, shown, settings.batch))
    return agent, curve


def _episode(steps: int, success: float, returned: float, length: float) -> Episode:
    cpu_s = time.process_time()
    values = {"steps": steps, "success": success, "return": returned, "length": length}
    return {**values, "cpu_s": cpu_s}


def _batch(memory: Memory, shown: Memory, size: int) -> tuple[Any, ...]:
    if not shown.count:
        return tuple(memory.batch(size))
    both = zip(memory.batch(size // 2), shown.batch(size // 2))
    return tuple(torch.cat(pair) for pair in both)


def evaluate(agent: Agent, env: Any, episodes: int, seed: int) -> float:
    """Share of episodes in which the policy's means succeed."""
    done = 0
    for episode in range(episodes):
        seen, _ = env.reset(seed=seed + episode)
        over = False
        while not over:
            seen, _, ended, cut, info = env.step(agent.act(seen[None], random=False)[0])
            over = ended or cut
        done += bool(info["is_success"])
    return done / episodes


# -- the program ------------------------------------------------------------------------------


def _report(curve: list[Episode]) -> None:
    if len(curve) % REPORTED:
        return
    last = curve[-REPORTED:]
    mean = {name: float(np.mean([each[name] for each in last])) for name in ("success", "length")}
    success, length = mean["success"], mean["length"]
    now = f"step {last[-1]['steps']:.0f}, {last[-1]['cpu_s']:.0f} s of processors"
    print(f"{now}: success {success:.2f}, {length:.1f} steps an episode", flush=True)


def film(env: Any, folder: str) -> None:
    """From now on write a picture whenever the cell has stepped."""
    step, pictures = env.cell.step, pathlib.Path(folder)
    pictures.mkdir(parents=True, exist_ok=True)

    def step_and_look(*arguments: Any) -> Any:
        snapshot = step(*arguments)
        picture = env.render()
        head = f"P6 {picture.shape[1]} {picture.shape[0]} 255\n".encode()
        number = len(list(pictures.glob("*.ppm")))
        (pictures / f"{number:05}.ppm").write_bytes(head + picture.tobytes())
        return snapshot

    env.cell.step = step_and_look


def play(options: argparse.Namespace) -> None:
    """Play a policy, and print the share of successes."""
    agent = Agent.load(options.play)
    keywords: dict[str, Any] = {"scene": options.scene} if options.scene else {}
    if options.film:
        keywords |= {"render_mode": "rgb_array", "camera": options.camera}
    with make(options.id, max_episode_steps=EPISODE_STEPS, **keywords) as env:
        if options.film:
            film(env, options.film)
        share = evaluate(agent, env, options.episodes, seed=5)
    print(f"{options.task}: {100 * share:.1f} % of {options.episodes} episodes succeed")


def main() -> None:
    """Run the program."""
    parser = argparse.ArgumentParser(description="Learn a task, or play a learned policy.")
    parser.add_argument("--task", default="Pick")
    for name, default in (("seed", 1), ("steps", 5000), ("demonstrations", 60), ("episodes", 100)):
        parser.add_argument(f"--{name}", type=int, default=default)
    for name in ("curve", "policy", "play", "film", "scene", "camera"):
        parser.add_argument(f"--{name}")
    options = parser.parse_args()
    options.id = f"aprsim/{options.task}-v0"
    torch.set_num_threads(1)
    if options.play:
        return play(options)
    settings = Settings(demonstrations=options.demonstrations)
    keywords: dict[str, Any] = {"autoreset_mode": "SameStep", "max_episode_steps": EPISODE_STEPS}
    envs = make_vec(options.id, 2, **keywords)
    agent, curve = learn(envs, options.steps, options.seed, settings, _report)
    envs.close()
    if options.curve:
        with open(options.curve, "w", newline="", encoding="utf-8") as file:
            table = csv.DictWriter(file, curve[0])
            table.writeheader()
            table.writerows(curve)
    if options.policy:
        agent.save(options.policy)


if __name__ == "__main__":
    main()
