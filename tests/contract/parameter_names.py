#!/usr/bin/env python3
"""Checks that every parameter of a parameterized test prints as a name or number, never as bytes.

usage: parameter_names.py TEST_PROGRAM..."""

import pathlib
import re
import subprocess
import sys


def unnamed(program):
    """Lines of the program's list of tests that show a parameter as bytes."""
    text = subprocess.run([program, "--gtest_list_tests"], check=True, capture_output=True, text=True).stdout
    return [line.strip() for line in text.splitlines() if re.search(r"-byte object <", line)]


def main():
    programs = [program for program in sys.argv[1:] if pathlib.Path(program).exists()]
    if not programs:
        raise SystemExit(__doc__)
    found = {program: lines for program in programs if (lines := unnamed(program))}
    for program, lines in found.items():
        print(f"{pathlib.Path(program).name}: {len(lines)} tests, among them {lines[0]}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
