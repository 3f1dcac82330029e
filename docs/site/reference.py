#!/usr/bin/python3
"""Writes the reference pages of the site from the programs' output and the sources.

usage: docs/site/reference.py BIN_DIRECTORY OUT_DIRECTORY

Every page comes from where the program itself gets it: configuration keys from `aprsimd --list-keys`,
commands from `--help`, registers and faults from `aprsim`, metrics from a running daemon, gRPC from the
comments of the .proto files, the C++ client and the Python package from their docstrings. Keys of scenes
and scenarios come from tables beside this file, which are compared with the keys that the readers accept.
"""
from __future__ import annotations

import ast
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = pathlib.Path(__file__).resolve().parent


def output(*command: str) -> str:
    environment = dict(os.environ, NO_COLOR="1", TERM="dumb", COLUMNS="100")
    return subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stdout


def cell(text: str) -> str:
    """Text inside a table."""
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;") or " "


def table(head: list[str], rows: list[list[str]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def code(text: str) -> str:
    return f"`{text}`" if text else ""


# Configuration

def configuration(bin_dir: pathlib.Path) -> str:
    lines = output(str(bin_dir / "aprsimd"), "--list-keys").splitlines()
    sections: dict[str, list[list[str]]] = {}
    for key_line, text in zip(lines[::2], lines[1::2]):
        key, _, value = key_line.partition("=")
        if not text.startswith("    "):
            raise SystemExit(f"reference: unexpected line of --list-keys: {text}")
        meaning, _, accepted = text.strip().rpartition(": ")
        section = key.split(".")[0] if "." in key else "General"
        sections.setdefault(section, []).append([code(key), code(value), cell(meaning), cell(accepted)])
    out = ["# Configuration keys", "",
           "The daemon reads these keys from `--config FILE` (YAML) and from `--set KEY=VALUE`. "
           "`aprsimd --list-keys` prints this list, `aprsimd --print-config` the effective values.", ""]
    for section, rows in sections.items():
        out += [f"## {section}", "", table(["key", "default", "meaning", "accepts"], rows)]
    return "\n".join(out)


# Command line

def commands_of(help_text: str) -> list[str]:
    _, _, listed = help_text.partition("\nSubcommands:\n")
    block = listed.split("\n\n")[0]
    return re.findall(r"^  (\S+)", block, re.M)


def help_pages(program: pathlib.Path, words: list[str]) -> list[str]:
    text = output(str(program), *words, "--help")
    name = " ".join([program.name, *words])
    out = [f"{'#' * min(2 + len(words), 4)} {name}", "", "```text", text.strip(), "```", ""]
    for word in commands_of(text):
        out += help_pages(program, [*words, word])
    return out


def command_line(bin_dir: pathlib.Path) -> str:
    out = ["# Commands", "", "The output of `--help` of each command.", ""]
    out += help_pages(bin_dir / "aprsim", [])
    out += help_pages(bin_dir / "aprsimd", [])
    out += help_pages(bin_dir / "aprsimd", ["token"])
    return "\n".join(out)


# Registers, faults, measures

def registers(bin_dir: pathlib.Path) -> str:
    return ("# Modbus registers\n\nThe output of `aprsim conveyor map`. The page [Modbus](../modbus.md) "
            "shows how to use them.\n\n```text\n" + output(str(bin_dir / "aprsim"), "conveyor", "map") + "```\n")


def faults(bin_dir: pathlib.Path) -> str:
    text = output(str(bin_dir / "aprsim"), "fault", "kinds", "--markdown")
    return "# Kinds of faults\n" + text.partition("\n")[2].replace("<", "&lt;")


def measures() -> str:
    source = (ROOT / "world/scenario/measure_kinds.cpp").read_text()
    rows = []
    for body in re.findall(r"MeasureKind\{(.*?)\}", source, re.S):
        texts = re.findall(r'"([^"]*)"', body)
        better = re.search(r",\s*(-?1)\s*$", body.strip())
        rows.append([code(texts[0]), texts[1], cell("".join(texts[2:])),
                     {"1": "greater", "-1": "smaller"}.get(better[1] if better else "", "")])
    return ("# Measures of a run\n\nScenarios and batches report these measures; `expect` of a scenario bounds "
            "them.\n\n" + table(["measure", "unit", "meaning", "better"], rows))


# Metrics

def metrics(bin_dir: pathlib.Path) -> str:
    with tempfile.TemporaryDirectory() as folder:
        ports_file = pathlib.Path(folder) / "ports.json"
        daemon = subprocess.Popen([str(bin_dir / "aprsimd"), "--any-port", "--ports-file", str(ports_file)],
                                  stderr=subprocess.DEVNULL)
        try:
            deadline = time.monotonic() + 60
            while not ports_file.exists():
                if daemon.poll() is not None or time.monotonic() > deadline:
                    raise SystemExit("reference: the daemon did not start")
                time.sleep(0.05)
            port = re.search(r'"web"\s*:\s*(\d+)', ports_file.read_text())[1]
            opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
            text = opener.open(f"http://127.0.0.1:{port}/metrics").read().decode()
        finally:
            daemon.send_signal(signal.SIGTERM)
            daemon.wait()
    kinds = dict(re.findall(r"^# TYPE (\S+) (\S+)", text, re.M))
    rows = []
    for name, meaning in re.findall(r"^# HELP (\S+) (.*)", text, re.M):
        labels = sorted(set(re.findall(r'(\w+)="', " ".join(
            re.findall(rf"^{name}(?:_bucket|_sum|_count)?(\{{.*\}})", text, re.M)))) - {"le"})
        rows.append([code(name), kinds.get(name, ""), ", ".join(map(code, labels)), cell(meaning)])
    if not rows:
        raise SystemExit("reference: the daemon reports no metrics")
    return ("# Metrics\n\nThe web port serves these at `/metrics` in Prometheus' format.\n\n"
            + table(["metric", "type", "labels", "meaning"], rows))


# gRPC

def uncomment(block: list[str]) -> str:
    return " ".join(line.strip().lstrip("/").strip() for line in block)


def proto_file(path: pathlib.Path) -> list[str]:
    """Services, messages and enums of one file with their comments."""
    out: list[str] = []
    pending: list[str] = []
    stack: list[str] = []
    rows: list[list[str]] = []

    def flush(head: list[str]) -> None:
        if rows:
            out.extend([table(head, rows)])
            rows.clear()

    heads = {"service": ["call", "request", "answer", "meaning"], "message": ["field", "type", "meaning"],
             "enum": ["value", "number", "meaning"]}
    kinds: list[str] = []
    text = path.read_text()
    # A statement on one line each.
    text = re.sub(r"([^;{}/])\n\s{4,}(?=[^/\s}])", r"\1 ", text)
    for raw in text.splitlines():
        line = raw.strip()
        if line.startswith("//"):
            pending.append(line)
            continue
        statement, _, trailing = line.partition("//")
        statement = statement.strip()
        meaning = cell(uncomment(pending + ([trailing] if trailing else [])))
        opened = re.match(r"(service|message|enum|oneof) (\w+) \{", statement)
        if opened:
            if kinds and kinds[-1] != "oneof":
                flush(heads[kinds[-1]])
            kinds.append(opened[1])
            if opened[1] != "oneof":
                stack.append(opened[2])
                out += [f"### {'.'.join(stack)}", "", meaning, ""]
            pending = []
            if statement.endswith("}"):
                kinds.pop()
                stack.pop()
            continue
        if statement.startswith("}") and kinds:
            kind = kinds.pop()
            if kind != "oneof":
                flush(heads[kind])
                stack.pop()
        elif kinds:
            call = re.match(r"rpc (\w+)\((?:stream )?([\w.]+)\) returns \((stream )?([\w.]+)\)", statement)
            field = re.match(r"((?:repeated |optional )?(?:map<[^>]*>|[\w.]+)) (\w+) = (\d+)", statement)
            value = re.match(r"(\w+) = (-?\d+)", statement)
            if call:
                rows.append([code(call[1]), code(call[2]), ("stream of " if call[3] else "") + code(call[4]), meaning])
            elif kinds[-1] == "enum" and value:
                rows.append([code(value[1]), value[2], meaning])
            elif field:
                rows.append([code(field[2]), code(field[1]), meaning])
        if statement:
            pending = []
    return out


def grpc_pages() -> dict[str, str]:
    out = {}
    for package, folder in (("aprsim.v1", "proto/aprsim/v1"), ("aprsim.crcl.v1", "proto/aprsim/crcl/v1")):
        files = sorted((ROOT / folder).glob("*.proto"),
                       key=lambda path: ("service" not in path.name, path.name))
        text = [f"# gRPC: {package}", "", f"Made of the comments in `{folder}`.", ""]
        for path in files:
            text += [f"## {path.name}", "", *proto_file(path)]
        out[f"grpc_{package.replace('.', '_')}.md"] = "\n".join(text)
    return out


def events() -> str:
    source = (ROOT / "proto/aprsim/v1/events.proto").read_text()
    body = re.search(r"enum (?:Cell)?EventKind \{(.*?)\n\}", source, re.S)
    if not body:
        raise SystemExit("reference: events.proto has no enum of events")
    rows, pending = [], []
    for line in body[1].splitlines():
        line = line.strip()
        if line.startswith("//"):
            pending.append(line)
            continue
        found = re.match(r"\w*EVENT_KIND_(\w+) = \d+", line)
        if found and found[1] != "UNSPECIFIED":
            rows.append([code(found[1].lower().replace("_", "-")), cell(uncomment(pending))])
        pending = []
    return ("# Events\n\n`aprsim events`, `StreamEvents` and the journal report these kinds of events.\n\n"
            + table(["event", "meaning"], rows))


# Scene and scenario files

def accepted_keys(paths: list[pathlib.Path]) -> set[str]:
    """The key words that readers accept: lists of `map({...})`, and constants of keys."""
    words: set[str] = set()
    for path in paths:
        source = path.read_text()
        for body in re.findall(r"\.map\(\s*\{(.*?)\}\)", source, re.S):
            words |= set(re.findall(r'"(\w+)"', body))
        for body in re.findall(r"k\w*Keys\s*=\s*\{(.*?)\}", source, re.S):
            words |= set(re.findall(r'"(\w+)"', body))
    return words


def keys_page(name: str, title: str, opening: str, readers: list[pathlib.Path], common: set[str]) -> str:
    out = [f"# {title}", "", opening, ""]
    rows: list[list[str]] = []
    known: set[str] = set(common)
    head = ["key", "value", "default", "meaning"]
    for line in (HERE / name).read_text().splitlines():
        if line.startswith("## "):
            if rows:
                out += [table(head, rows)]
            rows = []
            out += [line, ""]
        elif line and not line.startswith("#"):
            key, value, default, meaning = (part.strip() for part in line.split(" | "))
            known |= {word for word in re.split(r"[.\[\]]+", key) if word and not word.isupper()}
            rows.append([code(key), cell(value), cell(default), cell(meaning)])
    out += [table(head, rows)]
    accepted = accepted_keys(readers)
    for difference, what in ((accepted - known, "has no line for"), (known - accepted - common, "has an unknown key")):
        if difference:
            raise SystemExit(f"reference: docs/site/{name} {what}: {', '.join(sorted(difference))}")
    return "\n".join(out)


def scene_keys() -> str:
    readers = [*(ROOT / "world/scene/readers").glob("*.?pp"), ROOT / "world/scene/scene_loader.cpp"]
    return keys_page("scene_keys.txt", "Scene files",
                     "A scene is a YAML file with these keys. Lengths are metres and angles degrees unless the key "
                     "says otherwise. A pose is `xyz_m` and `rpy_deg` (roll, pitch, yaw about fixed axes). The page "
                     "[Scenes](../scenes.md) lists the shipped ones; the [tutorial](../tutorial.md) makes one.",
                     readers, {"gripper", "xyz_m", "rpy_deg"})


def scenario_keys() -> str:
    return keys_page("scenario_keys.txt", "Scenario files",
                     "A scenario is a YAML file with these keys. The page [Scenarios](../scenarios.md) shows how to run "
                     "one; [Measures](measures.md) lists what `expect` may bound.",
                     [ROOT / "world/scenario/scenario_reader.cpp"], set())


# C++ client

def cpp_client() -> str:
    out = ["# C++ client", "",
           "The library `aprsim::client_wires` (`find_package(aprsim-client)`). Example programs: "
           "`clients/examples`. Made of the comments in `clients/wires`.", ""]
    for path in sorted((ROOT / "clients/wires").glob("*.hpp")):
        out += [f"## {path.name}", ""]
        pending: list[str] = []
        declaration = ""
        depth = 0
        private = False
        for raw in path.read_text().splitlines():
            line = raw.strip()
            if line.startswith("///") and not declaration:
                pending.append(line)
                continue
            if re.match(r"(private|protected):", line):
                private = True
            if re.match(r"(public:|(class|struct) \w+)", line):
                private = False
            named = re.match(r"(class|struct|enum class) (\w+)[^;]*\{", line)
            if named and not private:
                out += [f"### {named[2]}", "", uncomment(pending).replace("<", "&lt;"), ""]
                pending = []
                continue
            if private or not line or line.startswith(("#", "namespace", "}")):
                pending = [] if not line else pending
                if not declaration:
                    continue
            declaration = f"{declaration} {line}".strip()
            if declaration.endswith((";", "}")) or "///<" in declaration:
                if pending or "///<" in declaration:
                    statement, _, trailing = declaration.partition("///<")
                    out += ["```cpp", statement.strip().removeprefix("[[nodiscard]] "), "```", "",
                            uncomment(pending + [trailing]).replace("<", "&lt;"), ""]
                pending, declaration = [], ""
    return "\n".join(out)


# Python package

def signature(node: ast.FunctionDef | ast.AsyncFunctionDef) -> str:
    arguments = ast.unparse(node.args)
    arguments = re.sub(r"^(self|cls)(, )?", "", arguments)
    returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    return f"{node.name}({arguments}){returns}"


def python_class(node: ast.ClassDef) -> list[str]:
    out = [f"### {node.name}", "", ast.get_docstring(node) or "", ""]
    for index, item in enumerate(node.body):
        if isinstance(item, (ast.FunctionDef, ast.AsyncFunctionDef)) and not item.name.startswith("_"):
            out += ["```python", signature(item), "```", "", ast.get_docstring(item) or "", ""]
        elif isinstance(item, ast.AnnAssign) and not ast.unparse(item.target).startswith("_"):
            following = node.body[index + 1] if index + 1 < len(node.body) else None
            text = (following.value.value if isinstance(following, ast.Expr)
                    and isinstance(following.value, ast.Constant) else "")
            out += ["```python", ast.unparse(item), "```", "", str(text), ""]
    return out


def python_package() -> str:
    package = ROOT / "clients/python/aprsim"
    out = ["# Python package", "", "Made of the docstrings in `clients/python`. The page [Python](../python.md) is the "
           "guide.", "", ast.get_docstring(ast.parse((package / "__init__.py").read_text())) or "", ""]
    modules = [path for path in sorted(package.rglob("*.py"))
               if "v1" not in path.parts and path.name not in ("__init__.py", "calls.py", "binaries.py", "channel.py")]
    for path in modules:
        tree = ast.parse(path.read_text())
        name = ".".join(path.relative_to(package.parent).with_suffix("").parts)
        out += [f"## {name}", "", ast.get_docstring(tree) or "", ""]
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                out += python_class(node)
            elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and not node.name.startswith("_"):
                out += ["```python", signature(node), "```", "", ast.get_docstring(node) or "", ""]
    return "\n".join(out)


def main() -> int:
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    bin_dir, out_dir = (pathlib.Path(argument).resolve() for argument in sys.argv[1:])
    pages = {"configuration.md": configuration(bin_dir), "commands.md": command_line(bin_dir),
             "registers.md": registers(bin_dir), "faults.md": faults(bin_dir), "measures.md": measures(),
             "metrics.md": metrics(bin_dir), "events.md": events(), "scene_files.md": scene_keys(),
             "scenario_files.md": scenario_keys(), "cpp_client.md": cpp_client(),
             "python_package.md": python_package(), **grpc_pages()}
    out_dir.mkdir(parents=True, exist_ok=True)
    for name, text in pages.items():
        (out_dir / name).write_text(text)
        print(f"{name}: {len(text.splitlines())} lines")
    return 0


if __name__ == "__main__":
    sys.exit(main())
