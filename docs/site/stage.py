#!/usr/bin/python3
"""Copies the documents of the tree into one folder, as mkdocs wants them, and finishes its site.

usage: docs/site/stage.py collect STAGE      copies documents and pictures, and adapts their links
       docs/site/stage.py finish SITE        moves inline scripts into files, removes what no page needs

Pages of docs/ are at the root of the site, README.md is its index, other documents keep their path.
A link to a file that is no document becomes its text and its path in the tree. The daemon's content
security policy allows no inline script, so each becomes a file.
"""
from __future__ import annotations

import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys

import diagrams

ROOT = pathlib.Path(__file__).resolve().parents[2]
PICTURES = {".png", ".webp", ".gif", ".svg"}
# Results are figures of one machine, pages of thousands of lines.
LEFT_OUT = ("tests/", "modbus/REGISTERS.md", "world/api/faults/FAULTS.md")
# Documents whose content is a generated page of the site.
GENERATED = {"modbus/REGISTERS.md": "reference/registers.md",
             "world/api/faults/FAULTS.md": "reference/faults.md"}


def place(name: str) -> str | None:
    """The path of a document or picture in the site, by its path in the tree; None = not there."""
    if name in GENERATED:
        return GENERATED[name]
    if name.startswith(LEFT_OUT) or pathlib.PurePath(name).suffix not in {".md", *PICTURES}:
        return None
    return "index.md" if name == "README.md" else name.removeprefix("docs/")


def adapt_links(text: str, name: str, tracked: set[str]) -> str:
    here = place(name)

    def link(match: re.Match[str]) -> str:
        mark, label, target, fragment = match.group(1, 2, 3, 4)
        if re.match(r"\w+:", target) or not target:
            return match[0]
        path = os.path.normpath(os.path.join(os.path.dirname(name), target))
        there = place(path) if path in tracked or path in GENERATED else None
        if there is None:
            plain = label.strip("`")
            return f"`{path}`" if path.endswith(plain.rstrip("/")) else f"{label} (`{path}`)"
        return f"{mark}[{label}]({os.path.relpath(there, os.path.dirname(here) or '.')}{fragment or ''})"

    parts = re.split(r"(^```.*?^```|^    .*?$)", text, flags=re.S | re.M)
    for index in range(0, len(parts), 2):
        parts[index] = re.sub(r"(!?)\[([^\]]*)\]\(([^)#\s]*)(#[^)]*)?\)", link, parts[index])
    return "".join(parts)


def draw_charts(text: str, page: pathlib.Path) -> str:
    """With pictures in place of Mermaid's charts."""
    def draw(match: re.Match[str]) -> str:
        name = "chart_" + hashlib.sha256(match[1].encode()).hexdigest()[:8] + ".svg"
        (page.parent / name).write_text(diagrams.svg(match[1]))
        return f"![Chart]({name})"

    return re.sub(r"^```mermaid\n(.*?)^```", draw, text, flags=re.S | re.M)


def collect(stage: pathlib.Path) -> None:
    command = ["git", "-C", str(ROOT), "ls-files", "--cached", "--others", "--exclude-standard"]
    names = subprocess.check_output(command, text=True).splitlines()
    tracked = {name for name in names if (ROOT / name).is_file()}
    for name in sorted(tracked):
        there = place(name)
        if there is None or name in GENERATED:
            continue
        path = stage / there
        path.parent.mkdir(parents=True, exist_ok=True)
        if name.endswith(".md"):
            path.write_text(draw_charts(adapt_links((ROOT / name).read_text(), name, tracked), path))
        elif name.startswith("docs/"):
            shutil.copyfile(ROOT / name, path)


def finish(site: pathlib.Path) -> None:
    scripts = site / "assets/scripts"
    scripts.mkdir(exist_ok=True)
    for page in site.rglob("*.html"):
        text = page.read_text()

        def move(match: re.Match[str]) -> str:
            body = match[1]
            name = hashlib.sha256(body.encode()).hexdigest()[:12] + ".js"
            (scripts / name).write_text(body)
            return f'<script src="{os.path.relpath(scripts / name, page.parent)}"></script>'

        page.write_text(re.sub(r"<script>(.*?)</script>", move, text, flags=re.S))
    for unneeded in ("assets/javascripts/lunr", "sitemap.xml", "sitemap.xml.gz"):
        path = site / unneeded
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    for path in site.rglob("*.map"):
        path.unlink()


if __name__ == "__main__":
    if len(sys.argv) != 3 or sys.argv[1] not in ("collect", "finish"):
        print(__doc__, file=sys.stderr)
        sys.exit(2)
    {"collect": collect, "finish": finish}[sys.argv[1]](pathlib.Path(sys.argv[2]).resolve())
