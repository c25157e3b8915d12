# SPDX-License-Identifier: Apache-2.0
"""Scripts of tests/validate, run by Node.js with the packages of its package-lock.json. Without npm, tests fail."""
import fcntl
import shutil
import subprocess

import support

SCRIPTS = support.SOURCES / "tests" / "validate"
# Beside the build, so that a fresh clone stays as it is and a second run downloads nothing.
MODULES = support.SOURCES / "build" / "validate"
PACKAGES = MODULES / "node_modules"
LIMIT_S = 500


def install():
    """What the lock file names, once; tests that start at the same time wait for each other."""
    MODULES.mkdir(parents=True, exist_ok=True)
    wanted = (SCRIPTS / "package-lock.json").read_bytes()
    mark = MODULES / "installed"
    with (MODULES / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if mark.exists() and mark.read_bytes() == wanted:
            return
        for name in ("package.json", "package-lock.json"):
            shutil.copy(SCRIPTS / name, MODULES)
        # No script of a package runs: what we use of them needs none.
        done = run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"])
        if done.returncode != 0:
            raise AssertionError(f"npm ci: {done.stderr}")
        mark.write_bytes(wanted)


def run(words, **more):
    return subprocess.run(list(map(str, words)), capture_output=True, text=True, errors="replace", timeout=LIMIT_S,
                          check=False, cwd=MODULES, **more)


def script(name, *arguments):
    return run(["node", SCRIPTS / name, MODULES, *arguments])
