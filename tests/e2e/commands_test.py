# SPDX-License-Identifier: Apache-2.0
"""The two commands of the README in one clone: replay/demo.sh and tests/run.sh, in either order.

The scripts are the real ones and so are CMake's configuration and ctest. What takes an hour is left out: `cmake --build`
builds nothing, and what apt-get would install is written down instead.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

import support

ONE_TEST = "architecture_test"  # which needs nothing built


def write_script(path, *lines):
    path.write_text("\n".join(("#!/bin/sh", *lines)) + "\n")
    path.chmod(0o755)


@unittest.skipUnless(shutil.which("dpkg-query"), "not Debian: no dpkg-query")
class Commands(support.Case):
    def setUp(self):
        self.clone = self.folder / self.id().rsplit(".", 1)[1]
        self.build = self.clone / "build"
        shutil.copytree(support.SOURCES, self.clone, ignore=lambda folder, names: [
            name for name in names if name == "__pycache__" or
            (pathlib.Path(folder) == support.SOURCES and name in ("build", "out", ".git", "shared"))])
        self.first = self.build / "path"  # found before the machine's own programs
        self.first.mkdir(parents=True)
        write_script(self.first / "cmake", '[ "$1" = --build ] && exit 0', f'exec {shutil.which("cmake")} "$@"')

    def run_script(self, *words, **variables):
        environment = {**os.environ, "PATH": f"{self.first}:{os.environ['PATH']}", **variables}
        return subprocess.run([str(word) for word in words], cwd=self.clone, env=environment, capture_output=True,
                              text=True, timeout=240, check=False)

    def demo(self):
        """Up to where it would use what it built."""
        done = self.run_script("replay/demo.sh")
        self.assertIn("build/release/zonecast: No such file", done.stderr, done.stdout)

    def assert_counted(self, done, passed, failed):
        self.assertEqual(done.returncode == 0, passed > 0 and failed == 0, done.stdout + done.stderr)
        self.assertEqual(done.stdout.splitlines()[-1], f"{passed} passed, {failed} failed", done.stdout)

    def run_one_test(self):
        return self.run_script("tests/run.sh", "-R", f"^{ONE_TEST}$")

    def test_tests_run_after_the_demo_and_again(self):
        self.demo()
        done = self.run_script("ctest", "--preset", "release")  # which the demo has asked none of
        self.assertNotEqual(done.returncode, 0, done.stdout + done.stderr)
        for _ in range(2):
            self.assert_counted(self.run_one_test(), 1, 0)
            self.demo()

    def test_the_demo_takes_no_tests_away(self):
        self.assert_counted(self.run_one_test(), 1, 0)
        self.demo()
        done = self.run_script("ninja", "-C", "build/release", "-t", "query", "streamer_test")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)  # it is still among what is built

    def test_a_run_in_which_no_test_passes_fails(self):
        done = self.run_script("tests/run.sh", "-R", "^no_test_has_this_name$")
        self.assertNotEqual(done.returncode, 0, done.stdout + done.stderr)
        shutil.copy(support.BINARY, self.build / "release" / "zonecast")
        done = self.run_script("tests/run.sh", "-R", "^e2e_real_data_test$", ZONECAST_DATA=str(self.folder / "none"))
        self.assert_counted(done, 0, 0)
        self.assertIn("no test ran", done.stderr)
        (self.clone / "replay" / "cli" / "progress.h").write_text("// no licence\n")
        self.assert_counted(self.run_one_test(), 0, 1)

    def test_the_demo_installs_neither_a_browser_nor_what_only_tests_need(self):
        """On a machine that has no package and no npm."""
        system = self.build / "system"
        system.mkdir()
        for name in ("bash", "dirname", "grep", "id"):
            (system / name).symlink_to(shutil.which(name))
        log = self.build / "installed"
        write_script(system / "dpkg-query", "exit 1")
        write_script(system / "apt-get", f'echo "$@" >> {log}', 'case "$*" in *install*) exit 9;; esac')
        write_script(system / "sudo", 'exec "$@"')
        for script in ("replay/demo.sh", "tests/run.sh"):
            self.assertEqual(self.run_script(shutil.which("bash"), script, PATH=str(system)).returncode, 9)
        demo, tests = (set(line.split()) for line in log.read_text().splitlines() if " install " in line)
        self.assertLessEqual({"g++", "cmake", "mesa-vulkan-drivers"}, demo)
        self.assertLess(demo, tests)
        self.assertEqual(tests - demo, {"python3", "libgtest-dev", "chromium", "nodejs", "npm"})

    def test_packages_need_a_purpose(self):
        for words in ((), ("dance",)):
            self.assertEqual(self.run_script("tests/packages.sh", *words).returncode, 2)


class RealCities(unittest.TestCase):
    """Where tests look for them."""

    def test_beside_the_sources_unless_named(self):
        for named, expected in ((None, support.SOURCES.parent / "shared" / "data"),
                                ("", support.SOURCES.parent / "shared" / "data"), ("/elsewhere", "/elsewhere")):
            variables = {name: value for name, value in os.environ.items() if name != "ZONECAST_DATA"}
            if named is not None:
                variables["ZONECAST_DATA"] = named
            found = subprocess.run([sys.executable, "-B", "-c", "import support; print(support.DATA)"], env=variables,
                                   cwd=pathlib.Path(__file__).parent, capture_output=True, text=True, check=True)
            self.assertEqual(found.stdout.strip(), str(expected))


if __name__ == "__main__":
    support.main()
