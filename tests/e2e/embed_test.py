# SPDX-License-Identifier: Apache-2.0
"""A host program is built against the installed package alone, runs on a device of its own, and links no GPL code."""

import os
import pathlib
import re
import subprocess
import unittest

from support import BINARY, SOURCES, Case, main

# What the baker brings.
GPL = re.compile(r"CGAL|OpenMesh|mpfr")


def command(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise AssertionError(f"{words}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


class Embed(Case):
    @classmethod
    def prepare(cls):
        build = pathlib.Path(BINARY).parent
        for component in ("streamer", "runtime"):
            command("cmake", "--install", build, "--prefix", cls.folder / "prefix", "--component", component)
        command("cmake", "-G", "Ninja", "-S", SOURCES / "tests/embed", "-B", cls.folder / "build",
                f"-DCMAKE_PREFIX_PATH={cls.folder / 'prefix'}", "-DCMAKE_BUILD_TYPE=Release")
        command("cmake", "--build", cls.folder / "build")
        cls.embed = cls.folder / "build" / "embed"

    def test_the_package_and_what_is_built_on_it_have_no_gpl_code(self):
        self.assertEqual([str(path) for path in (self.folder / "prefix").rglob("*baker*")], [])
        self.assertNotRegex(command("ldd", self.embed), GPL)
        self.assertNotRegex(command("nm", "-C", self.embed), GPL)

    def test_a_floor_mirrors_the_hosts_box_and_the_paged_city_before_the_hosts_sky(self):
        self.zonecast("generate", "--seed", "1", "--size-km", "0.2", "-o", self.folder / "city")
        self.zonecast("bake", self.folder / "city/city.glb", "--no-light", "-o", self.folder / "world")
        x, y, z = (self.folder / "city/drive.csv").read_text().splitlines()[1].split(",")[1:4]
        layers = {**os.environ, "VK_INSTANCE_LAYERS": "VK_LAYER_KHRONOS_validation"}
        for forward in (("1", "0"), ("0", "1")):
            done = subprocess.run([self.embed, self.folder / "world", x, y, str(float(z) + 2), *forward,
                                   self.folder / "picture.ppm"], capture_output=True, text=True, env=layers, check=False)
            said = done.stdout + done.stderr
            self.assertEqual(done.returncode, 0, said)
            self.assertNotIn("VUID", said)

    def test_a_component_that_is_not_there_is_named(self):
        project = self.folder / "wrong"
        project.mkdir()
        (project / "CMakeLists.txt").write_text("cmake_minimum_required(VERSION 3.25)\nproject(wrong CXX)\n"
                                                "find_package(zonecast REQUIRED COMPONENTS baker)\n")
        done = subprocess.run(["cmake", "-G", "Ninja", "-S", project, "-B", project / "build",
                               f"-DCMAKE_PREFIX_PATH={self.folder / 'prefix'}"], capture_output=True, text=True, check=False)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("baker", done.stderr)


if __name__ == "__main__":
    main()
