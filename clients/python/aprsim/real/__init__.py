"""Real robots and belts beside the simulated ones: `python3 -m aprsim.real`.

`robot_mirror` and `belt_mirror` move a robot or the belt of the cell as a real one moves. `relay` stands
between controllers and a real robot. `deviation` tells when a real and a simulated robot part. Nothing is
written to a real device unless that is allowed."""
