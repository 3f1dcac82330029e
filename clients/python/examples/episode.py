"""An episode of a task, in a daemon of its own: by the scripted policy, then the same one again."""

from aprsim.envs import PickEnv, scripted_action

env = PickEnv()
for _ in range(2):
    observation, info = env.reset(seed=7)
    total, over = 0.0, False
    while not over:
        observation, reward, terminated, truncated, info = env.step(scripted_action(observation))
        total, over = total + reward, terminated or truncated
    print(f"{info['gear']}: {info['is_success']}, {total:.3f}, state {info['state_hash']:016x}")
env.close()
