"""The JSON schemas of scene, types and scenario files against the readers of these files."""

import copy
import json
import os
import pathlib
import random
import re
import subprocess
import tempfile
import unittest

import jsonschema
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[3]
APRSIM = os.path.join(os.environ["APRSIM_BIN_DIR"], "aprsim")


class Loader(yaml.SafeLoader):
    """Scalars as in YAML 1.2's core schema, as editors have them."""


Loader.yaml_implicit_resolvers = {}
for tag, pattern, first in (
    ("bool", r"true|false", "tf"),
    ("int", r"[-+]?[0-9]+", "-+0123456789"),
    ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", "-+.0123456789"),
    ("null", r"~|null|", ["~", "n", ""]),
):
    Loader.add_implicit_resolver(f"tag:yaml.org,2002:{tag}", re.compile(f"^(?:{pattern})$"), list(first))


def read(path):
    return yaml.load(path.read_text(), Loader)


def schema(*words):
    out = subprocess.run([APRSIM, *words], capture_output=True, text=True, check=True).stdout
    validator = jsonschema.Draft7Validator
    document = json.loads(out)
    validator.check_schema(document)
    return validator(document)


def refused_by_readers(kind, files):
    """The names of the files with errors."""
    done = subprocess.run([APRSIM, kind, "check", "--json", *map(str, files)], capture_output=True, text=True)
    problems = [json.loads(line) for line in done.stdout.splitlines()]
    valid = {line["valid"] if "valid" in line else line["file"] for line in problems if "severity" not in line}
    wrong = {str(file) for file in files} - valid
    if done.returncode != (1 if wrong else 0):
        raise AssertionError(f"exit code {done.returncode}: {done.stderr}")
    return wrong


SHIPPED = {
    "scene": sorted((ROOT / "world/scenes").glob("*.yaml")),
    "types": sorted((ROOT / "world/scenes/types").glob("*.yaml")),
    "scenario": sorted((ROOT / "world/scenarios").glob("*.yaml")),
}


def places(value, path=()):
    """The paths of all values within a value."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, part in inner:
        yield path + (key,)
        yield from places(part, path + (key,))


def around(tree, path):
    for key in path[:-1]:
        tree = tree[key]
    return tree


def mistype(tree, path, chance):
    parent = around(tree, path)
    if not isinstance(parent, dict):
        return
    parent[path[-1] + "x"] = parent.pop(path[-1])


def another_type(tree, path, chance):
    value = around(tree, path)[path[-1]]
    others = [v for v in ("some text", True, 3, [1], {"a": 1}) if not isinstance(v, type(value))]
    around(tree, path)[path[-1]] = chance.choice(others)


def far_off(tree, path, chance):
    if isinstance(around(tree, path)[path[-1]], (int, float)):
        around(tree, path)[path[-1]] = chance.choice([-1e9, -1, 0, 1e9, 0.5])


def leave_out(tree, path, chance):
    parent = around(tree, path)
    del parent[path[-1]]


class SchemaTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.schemas = {"scene": schema("scene", "schema"), "types": schema("scene", "schema", "--types"),
                       "scenario": schema("scenario", "schema")}

    def test_shipped_files_are_valid(self):
        for kind, files in SHIPPED.items():
            self.assertTrue(files)
            for file in files:
                errors = [f"{list(e.absolute_path)}: {e.message}" for e in self.schemas[kind].iter_errors(read(file))]
                self.assertEqual(errors, [], file)

    def mutants(self, kind, change, count, folder):
        """Files with one change each, and whether the schema refuses them."""
        chance = random.Random(f"{kind} {change.__name__}")
        out = {}
        trees = [read(file) for file in SHIPPED[kind]]
        for number in range(count):
            tree = copy.deepcopy(chance.choice(trees))
            change(tree, chance.choice(list(places(tree))), chance)
            if kind == "types" and set(tree) - {"pockets", "gear_types", "part_types", "tray_types", "robot_types"}:
                continue  # is then read as a scene
            file = pathlib.Path(folder) / f"{kind}_{number}.yaml"
            file.write_text(json.dumps(tree))
            out[str(file)] = not self.schemas[kind].is_valid(tree)
        return out

    def test_schemas_refuse_nothing_that_readers_accept(self):
        for kind in SHIPPED:
            for change in (mistype, another_type, far_off, leave_out):
                with tempfile.TemporaryDirectory() as folder, self.subTest(kind=kind, change=change.__name__):
                    mutants = self.mutants(kind, change, 12 if kind == "scenario" else 60, folder)
                    readers = refused_by_readers("scenario" if kind == "scenario" else "scene", list(mutants))
                    by_schema = {file for file, refused in mutants.items() if refused}
                    wrong = [pathlib.Path(file).read_text()[:200] for file in by_schema - readers]
                    self.assertEqual(wrong, [], "refused by the schema alone")

    def test_both_refuse_mistakes(self):
        scene = SHIPPED["scene"][0].parent / "aprs.yaml"
        mistakes = [
            ("scene", scene, "gravity_m_s2: 9.81", "gravty_m_s2: 9.81"),
            ("scene", scene, "gravity_m_s2: 9.81", "gravity_m_s2: much"),
            ("scene", scene, "gravity_m_s2: 9.81", "gravity_m_s2: -1"),
            ("scene", scene, "step_s: 0.001", "step_s: 0.01"),
            ("scene", scene, "simplification: dormant", "simplification: sleepy"),
            ("scene", scene, "floor: true", "floor: 1"),
            ("scene", scene, "  - name: fanuc\n", "  - nme: fanuc\n"),
            ("scene", scene, "xyz_m: [0, 0, 0.91]", "xyz_m: [0, 0]"),
            ("scene", scene, "xyz_m: [0, 0, 0.91]", "xyz_m: [0, 0, 5000]"),
        ]
        scenario = ROOT / "world/scenarios/clean_2017.yaml"
        title = re.search(r"^description: .*$", scenario.read_text(), re.M)[0]
        mistakes += [
            ("scenario", scenario, title, title.replace("description", "descripton")),
            ("scenario", scenario, "time_limit_s: 600", "time_limit_s: 0"),
            ("scenario", scenario, title, title + "\nfaults: [{kind: belt-jam, for_s: soon}]"),
            ("scenario", scenario, title, title + "\nfaults: [{kind: belt-jamm}]"),
        ]
        with tempfile.TemporaryDirectory() as folder:
            for kind, file, before, after in mistakes:
                with self.subTest(after=after):
                    text = file.read_text()
                    self.assertIn(before, text)
                    changed = pathlib.Path(folder) / "changed.yaml"
                    changed.write_text(text.replace(before, after, 1))
                    self.assertFalse(self.schemas[kind].is_valid(read(changed)))
                    self.assertEqual(refused_by_readers(kind, [changed]), {str(changed)})


if __name__ == "__main__":
    unittest.main()
