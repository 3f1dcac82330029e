"""Draws the flowcharts of documents, which GitHub draws by Mermaid, with Graphviz as SVG.

It knows the part of Mermaid's notation that the documents use: nodes with labels, arrows with labels, chains
and groups. Anything else is an error.
"""
from __future__ import annotations

import re
import subprocess
import textwrap

_SHAPES = ((r"\(\[(.*?)\]\)", "box", "rounded"), (r"\[\((.*?)\)\]", "cylinder", ""), (r"\{(.*?)\}", "diamond", ""),
           (r"\[(.*?)\]", "box", ""))
_ARROW = re.compile(r"\s+(?:(-->|-\.->)|--\s+(.+?)\s+-->)\s+")


def _quoted(text: str, width: int) -> str:
    lines = textwrap.wrap(text, width) or [""]
    return '"' + "\\n".join(lines).replace('"', '\\"') + '"'


class _Chart:
    def __init__(self) -> None:
        self.nodes: dict[str, str] = {}
        self.groups: dict[str, str] = {}  # by name: a node in it
        self.lines: list[str] = []
        self.edges: dict[tuple[str, str], list[str]] = {}  # by begin and end: labels, both ways

    def node(self, text: str) -> str:
        """The name of a node, which it declares where the text has a label."""
        found = re.match(r"(\w+)(.*)$", text.strip())
        if not found:
            raise ValueError(f"no node: {text}")
        name, form = found[1], found[2].strip()
        for pattern, shape, style in _SHAPES:
            label = re.fullmatch(pattern, form)
            if label:
                margin = ' margin="0.05,0.02"' if shape == "diamond" else ""
                self.nodes[name] = (f'"{name}" [label={_quoted(label[1], 26)} shape={shape} '
                                    f'style="{style},filled" fillcolor="#eceff1"{margin}]')
                self.lines.append(self.nodes[name])
                return name
        if form:
            raise ValueError(f"no node: {text}")
        if name not in self.nodes and name not in self.groups:
            self.nodes[name] = f'"{name}" [label="{name}" shape=box style=filled fillcolor="#eceff1"]'
            self.lines.append(self.nodes[name])
        return name

    def edge(self, begin: str, end: str, arrow: str | None, label: str | None) -> None:
        if (end, begin) in self.edges:
            # One line with two heads, since labels of two lines would cover each other.
            self.edges[end, begin].append(label or "")
            return
        self.edges[begin, end] = [label or "", arrow or "-->"]

    def edge_lines(self) -> list[str]:
        out = []
        for (begin, end), (label, arrow, *back) in self.edges.items():
            text = "\\n".join([label and _quoted(label, 24)[1:-1]] + [_quoted("back: " + b, 24)[1:-1] for b in back])
            options = [f'label="{text}"'] if text else []
            options += ["dir=both"] if back else []
            options += ["style=dashed"] if arrow == "-.->" else []
            for name, key in ((begin, "ltail"), (end, "lhead")):
                if name in self.groups:
                    options.append(f'{key}="cluster_{name}"')
            first, last = self.groups.get(begin, begin), self.groups.get(end, end)
            out.append(f'"{first}" -> "{last}" [{" ".join(options)}]')
        return out


def _to_dot(source: str) -> str:
    lines = source.strip().splitlines()
    head = re.fullmatch(r"flowchart (LR|TD|TB)", lines[0].strip())
    if not head:
        raise ValueError(f"no flowchart: {lines[0]}")
    chart = _Chart()
    group: str | None = None
    for line in lines[1:]:
        opened = re.fullmatch(r"\s*subgraph (\w+) \[(.*)\]", line)
        if opened:
            group = opened[1]
            chart.lines.append(f'subgraph "cluster_{group}" {{ label={_quoted(opened[2], 60)} style=rounded color="#90a4ae"')
            continue
        if line.strip() == "end":
            chart.lines.append("}")
            group = None
            continue
        parts = _ARROW.split(" " + line.strip() + " ")
        names = [chart.node(text) for text in parts[::3]]
        if group:
            chart.groups.setdefault(group, names[0])
        for begin, end, arrow, label in zip(names, names[1:], parts[1::3], parts[2::3]):
            chart.edge(begin, end, arrow, label)
    # Downwards whatever the source says: a page is narrow.
    return ("digraph chart { rankdir=TB compound=true bgcolor=white pad=0.2 nodesep=0.3 ranksep=0.4\n"
            'node [fontname="sans-serif" fontsize=11]\nedge [fontname="sans-serif" fontsize=10 color="#455a64"]\n'
            'graph [fontname="sans-serif" fontsize=11]\n' + "\n".join(chart.lines + chart.edge_lines()) + "\n}\n")


def svg(source: str) -> str:
    """The chart as SVG. Errors: ValueError with the line that it does not know."""
    done = subprocess.run(["dot", "-Tsvg"], input=_to_dot(source), capture_output=True, text=True, check=True)
    return done.stdout
