# SPDX-License-Identifier: Apache-2.0
"""Worlds as others see them: the Khronos glTF validator, another Draco decoder, the 3D Tiles tools. Needs npm."""
import json
import os
import pathlib
import shutil
import subprocess

import support

HERE = pathlib.Path(__file__).resolve().parent.parent / "validate"
# Beside the build, so that a fresh clone stays as it is and a second run downloads nothing.
MODULES = HERE.parent.parent / "build" / "validate"


def install():
    wanted = (HERE / "package.json").read_bytes()
    mark = MODULES / "installed.json"
    if mark.exists() and mark.read_bytes() == wanted:
        return
    MODULES.mkdir(parents=True, exist_ok=True)
    shutil.copy(HERE / "package.json", MODULES)
    # No script of a package runs; what the tools need comes built.
    subprocess.run(["npm", "install", "--ignore-scripts", "--no-audit", "--no-fund", "--no-package-lock"], cwd=MODULES,
                   check=True, stdout=subprocess.DEVNULL, timeout=500)
    mark.write_bytes(wanted)


class Validators(support.Case):
    @classmethod
    def prepare(cls):
        install()
        cls.zonecast("generate", "--size-km", "0.3", "-o", cls.folder / "city")
        cls.zonecast("bake", cls.folder / "city" / "city.glb", "-o", cls.folder / "generated")

    def validate(self, world):
        done = subprocess.run(["node", HERE / "validate.mjs", MODULES, world], capture_output=True, text=True, timeout=500)
        self.assertEqual(done.returncode, 0, done.stderr[-2000:])
        totals = json.loads(done.stdout)
        self.assertEqual((totals["errors"], totals["warnings"]), (0, 0))
        index = json.loads(self.zonecast("inspect", world, "--json"))
        self.assertEqual(totals["glbs"], index["nodes"])
        self.assertEqual(totals["tiles"], index["nodes"])
        self.assertGreaterEqual(totals["triangles"], index["source_triangles"] // 2)
        print(world.name, totals)

    def test_a_generated_city_has_no_fault(self):
        self.validate(self.folder / "generated")

    def test_a_real_city_has_no_fault(self):
        data = os.environ.get("ZONECAST_DATA")
        if not data:
            self.skipTest("no real cities; set ZONECAST_DATA")
        world = self.folder / "ingolstadt"
        self.zonecast("bake", pathlib.Path(data) / "ingolstadt" / "ingolstadt.city.json", "-o", world, "--no-light",
                      "--atlas", "0")
        self.validate(world)

    def test_a_fault_is_found(self):
        broken = self.folder / "broken"
        shutil.copytree(self.folder / "generated", broken)
        tileset = json.loads((broken / "tileset.json").read_text())
        tileset["root"]["boundingVolume"]["box"][3] /= 2
        (broken / "tileset.json").write_text(json.dumps(tileset))
        done = subprocess.run(["node", HERE / "validate.mjs", MODULES, broken], capture_output=True, text=True, timeout=500)
        self.assertEqual(done.returncode, 1)
        self.assertIn("leaves", done.stderr)

    def test_the_3d_tiles_tools_read_a_world_whole(self):
        tools = MODULES / "node_modules" / ".bin" / "3d-tiles-tools"
        packed = self.folder / "packed.3tz"
        subprocess.run([tools, "convert", "-i", self.folder / "generated" / "tileset.json", "-o", packed], check=True,
                       capture_output=True, timeout=500)
        unpacked = self.folder / "unpacked"
        subprocess.run([tools, "convert", "-i", packed, "-o", unpacked], check=True, capture_output=True, timeout=500)
        for file in sorted((self.folder / "generated" / "zones").rglob("*.glb")):
            name = file.relative_to(self.folder / "generated")
            self.assertEqual((unpacked / name).read_bytes(), file.read_bytes(), name)


if __name__ == "__main__":
    support.main()
