"""Real robots, belts and cameras beside the simulated ones: `python3 -m aprsim.real`.

`building` makes devices from `settings`, which are the words of a command or a file. A mirror moves a part of
the cell as the real one moves. A relay stands between controllers and a real device. `base.deviation` tells
when a real and a simulated machine part. Nothing is written to a real device unless that is allowed."""
