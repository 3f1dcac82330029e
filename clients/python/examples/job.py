"""Runs a scenario, by name or file, in virtual time and tells what came of it.
usage: job.py [NAME]"""

import sys

from aprsim import run_scenario

report = run_scenario(sys.argv[1] if len(sys.argv) > 1 else "clean_2017", seed=1)
print(f"{report.scenario}: {report.end_reason}; {'as' if report.as_expected else 'not as'} expected")
for verdict in report.verdicts:
    print(f"  {verdict.measure}: {verdict.value} {'kept' if verdict.kept else 'NOT KEPT'}")
