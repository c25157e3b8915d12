#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""clang-tidy on what changed since a commit, what is not committed included. Usage: tests/tidy.py [BASE]

Without BASE: since this branch left origin/main; on origin/main, and where there is none, since the commit before.
A header is checked through the source of its name, or through one that includes it. Sources are read as build/release
has built them. After ZONECAST_TIDY_MINUTES (8) no further source is begun, and those that are left are named.
"""
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import time

SOURCES = pathlib.Path(__file__).resolve().parents[1]
BUILD = SOURCES / "build" / "release"
MINUTES = float(os.environ.get("ZONECAST_TIDY_MINUTES") or 8)
EMPTY_TREE = "4b825dc642cb6eb9a060e54bf8d69288fbee4904"


def git(*words):
    """What git says, or nothing where it fails."""
    done = subprocess.run(["git", *words], cwd=SOURCES, capture_output=True, text=True, check=False)
    return done.stdout.strip() if done.returncode == 0 else ""


def default_base():
    head = git("rev-parse", "HEAD")
    fork = git("merge-base", "HEAD", "origin/main")
    return fork if fork not in ("", head) else git("rev-parse", "--verify", "HEAD~1") or EMPTY_TREE


def units_of(changed, built):
    """The sources among `built` by which each changed file is compiled."""
    texts = {name: (SOURCES / name).read_text(encoding="utf-8") for name in built}
    for name in changed:
        unit = re.sub(r"\.h$", ".cpp", name)
        if unit in built:
            yield unit
        elif name.endswith(".h"):
            yield from [unit for unit, text in texts.items() if f'#include "{name}"' in text][:1]


def check(unit, ends):
    """Whether clang-tidy was run at all, and what it found."""
    if time.monotonic() > ends:
        return unit, False, ""
    done = subprocess.run(["clang-tidy-14", "-p", BUILD, "--quiet", unit], cwd=SOURCES, capture_output=True, text=True,
                          check=False)
    return unit, True, "" if done.returncode == 0 else done.stdout + done.stderr


def main():
    subprocess.run([SOURCES / "tests" / "packages.sh", "checks"], check=True)
    base = sys.argv[1] if len(sys.argv) > 1 else default_base()
    database = json.loads((BUILD / "compile_commands.json").read_text(encoding="utf-8"))
    built = sorted(os.path.relpath(entry["file"], SOURCES) for entry in database
                   if pathlib.Path(entry["file"]).is_relative_to(SOURCES) and not
                   pathlib.Path(entry["file"]).is_relative_to(BUILD))
    changed = git("diff", "--name-only", "--diff-filter=d", base, "--", "*.cpp", "*.h").split()
    changed += git("ls-files", "--others", "--exclude-standard", "--", "*.cpp", "*.h").split()
    units = sorted(set(units_of(changed, built)))
    print(f"clang-tidy: {len(units)} sources for {len(changed)} files that changed since {base[:12]}", flush=True)
    ends = time.monotonic() + 60 * MINUTES
    left, faults = [], 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for unit, ran, found in pool.map(lambda unit: check(unit, ends), units):
            if not ran:
                left.append(unit)
            if found:
                faults += 1
                print(f"{unit}:\n{found}", flush=True)
    if left:
        print(f"clang-tidy: {len(left)} sources not checked within {MINUTES:g} minutes: {' '.join(left)}")
    print(f"clang-tidy: {faults} of {len(units) - len(left)} sources have faults")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
