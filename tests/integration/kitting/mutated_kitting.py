"""The kitting controller with one fault of its programmer: what it does at one place differs.

usage: mutated_kitting.py SITES MUTATION SEED kitting's arguments...
  SITES     a file: how often each thing is done; written with the mutation `none`, read with others
  MUTATION  a name of MUTATIONS
  SEED      chooses the place, and the robot"""

import json
import pathlib
import random
import runpy
import sys
import threading

CONTROLLER = pathlib.Path(__file__).resolve().parents[3] / "clients" / "kitting"
sys.path.insert(0, str(CONTROLLER))

import conveyor  # noqa: E402
import crcl_robot  # noqa: E402

# Each kind of place, and what may be wrong there: a name, and the kind of command by which it has to
# be found.
MUTATIONS = {
    "x_1_mm": ("move", "MoveTo"),
    "y_1_mm": ("move", "MoveTo"),
    "z_1_mm": ("move", "MoveTo"),
    "yaw_2_deg": ("move", "MoveTo"),
    "curved_for_straight": ("move", "MoveTo"),
    "move_missing": ("move", "MoveTo"),
    "move_twice": ("move", "MoveTo"),
    "stop_after_move": ("move", "StopMotion"),
    "late_before_move": ("move", "MoveTo"),
    "speed_20_percent": ("speed", "SetTransSpeed"),
    "turn_speed_10_percent": ("speed", "SetRotSpeed"),
    "speeds_swapped": ("speed", "Set"),
    "grip_missing": ("gripper", "SetEndEffector"),
    "grip_twice": ("gripper", "SetEndEffector"),
    "grip_not_full": ("gripper", "SetEndEffector"),
    "dwell_before_grip": ("gripper", ""),
    "dwell_shortened": ("dwell", "Dwell"),
    "dwell_missing": ("dwell", "Dwell"),
    "home_joint_1_deg": ("joints", "ActuateJoints"),
    "home_slower": ("joints", "ActuateJoints"),
    "initialised_twice": ("initialise", ""),
    "register_value": ("write", "write"),
    "register_twice": ("write", "write"),
    "register_missing": ("write", "write"),
}


class Places:
    """Counts the places of each kind and robot; one of them is wrong."""

    def __init__(self, sites, mutation, seed):
        self.mutation, self.counts, self.lock = mutation, {}, threading.Lock()
        self.chosen, self.is_done = None, False
        if mutation == "none":
            return
        kind = MUTATIONS[mutation][0]
        possible = [
            (robot, place)
            for robot, counts in sorted(sites.items())
            for place in range(counts.get(kind, 0))
        ]
        self.chosen = (kind, *random.Random(f"{mutation} {seed}").choice(possible))

    def is_wrong(self, kind, robot, mutations):
        """Counts a place; whether it is the one, and wrong in one of these ways."""
        with self.lock:
            counts = self.counts.setdefault(robot, {})
            place = counts.get(kind, 0)
            counts[kind] = place + 1
            wrong = (kind, robot, place) == self.chosen and self.mutation in mutations
            self.is_done = self.is_done or wrong
            return wrong


def mutate(places):
    """Puts the faults into the controller's classes."""
    robot_class = crcl_robot.CrclRobot

    class Mutated(robot_class):
        def wrong(self, kind):
            of_kind = [name for name, (where, _) in MUTATIONS.items() if where == kind]
            return places.mutation if places.is_wrong(kind, self.name, of_kind) else None

        def move(self, xyz_mm, yaw, *, straight):
            wrong = self.wrong("move")
            x, y, z = xyz_mm
            x += wrong == "x_1_mm"
            y += wrong == "y_1_mm"
            z += wrong == "z_1_mm"
            yaw += 0.035 * (wrong == "yaw_2_deg")
            if wrong == "move_missing":
                return
            if wrong == "late_before_move":
                self.wait(1.5)
            straight = straight != (wrong == "curved_for_straight")
            super().move((x, y, z), yaw, straight=straight)
            if wrong == "move_twice":
                super().move((x, y, z), yaw, straight=straight)
            if wrong == "stop_after_move":
                self.stop()
                self.initialise()

        def set_speed(self, mm_s, deg_s):
            wrong = self.wrong("speed")
            mm_s *= 0.8 if wrong == "speed_20_percent" else 1
            deg_s *= 0.9 if wrong == "turn_speed_10_percent" else 1
            if wrong != "speeds_swapped":
                super().set_speed(mm_s, deg_s)
                return
            self.run("SetRotSpeed", crcl_robot._absolute("RotSpeed", deg_s))
            self.run("SetTransSpeed", crcl_robot._absolute("TransSpeed", mm_s))

        def set_gripper(self, opened):
            wrong = self.wrong("gripper")
            if wrong == "grip_missing":
                return
            if wrong == "dwell_before_grip":
                super().dwell(0.05)
            if wrong == "grip_not_full":
                setting = "0.9" if opened else "0.1"
                self.run("SetEndEffector", crcl_robot._tag("Setting", setting), 20)
                return
            super().set_gripper(opened)
            if wrong == "grip_twice":
                super().set_gripper(opened)

        def dwell(self, seconds):
            wrong = self.wrong("dwell")
            if wrong != "dwell_missing":
                super().dwell(seconds / (2 if wrong == "dwell_shortened" else 1))

        def move_joints(self, joints_deg, speed_deg_s):
            wrong = self.wrong("joints")
            joints = list(joints_deg)
            joints[0] += wrong == "home_joint_1_deg"
            super().move_joints(joints, speed_deg_s * (0.8 if wrong == "home_slower" else 1))

        def initialise(self):
            wrong = self.wrong("initialise")
            super().initialise()
            if wrong == "initialised_twice":
                super().initialise()

    class MutatedModbus(conveyor.Modbus):
        def write_register(self, address, value):
            of_kind = [name for name, (where, _) in MUTATIONS.items() if where == "write"]
            wrong = places.mutation if places.is_wrong("write", "belt", of_kind) else None
            if wrong == "register_missing":
                return
            if wrong == "register_value":
                # The belt is not to run where it should not.
                value = value - 500 if value > 1 else 1 - value if address == 0x8001 else value + 7
                address = conveyor.SPEED if address == conveyor.RUN and value > 1 else address
            super().write_register(address, value)
            if wrong == "register_twice":
                super().write_register(address, value)

    crcl_robot.CrclRobot = Mutated
    conveyor.Modbus = MutatedModbus
    conveyor.Conveyor.connect = MutatedModbus


def main():
    sites_file, mutation, seed = pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3]
    sites = {} if mutation == "none" else json.loads(sites_file.read_text(encoding="utf-8"))
    places = Places(sites, mutation, seed)
    mutate(places)
    sys.argv = ["kitting", *sys.argv[4:]]
    try:
        runpy.run_path(str(CONTROLLER / "kitting"), run_name="__main__")
    finally:
        if mutation == "none":
            sites_file.write_text(json.dumps(places.counts), encoding="utf-8")
        elif not places.is_done:
            print(f"the place {places.chosen} was never reached", file=sys.stderr)
            raise SystemExit(70)


if __name__ == "__main__":
    main()
