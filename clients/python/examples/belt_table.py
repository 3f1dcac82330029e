"""Runs the belt for a second of simulated time and shows how far its trays went, as a pandas table."""

from aprsim import Cell, bodies_table

with Cell.connect() as cell:
    was_running = not cell.paused
    cell.pause()
    cell.set_conveyor(True, forward=True, speed_m_s=0.1)
    table = bodies_table(cell.step(100, ["bodies", "sim_time", "step"]) for _ in range(10))
    cell.set_conveyor(False)
    travel = table.groupby("body")["x"].agg(lambda x: x.iloc[-1] - x.iloc[0])
    print(travel[travel > 0.001].round(3).to_string())
    if was_running:
        cell.resume()
