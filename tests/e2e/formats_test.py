# SPDX-License-Identifier: Apache-2.0
"""OBJ and PLY become worlds: their triangles, colours and textures, from files, packed files and folders."""

import gzip
import json
import struct
import zipfile

import support

# Two houses at coordinates of a projected system; the second one is textured.
ORIGIN = (412345.5, 5712345.25, 60.0)
SIDE = 12


def box(x):
    """Eight corners and six quads that face outwards, of a house at x."""
    corners = [(ORIGIN[0] + x + SIDE * (i & 1), ORIGIN[1] + SIDE * (i >> 1 & 1), ORIGIN[2] + SIDE * (i >> 2))
               for i in range(8)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (3, 2, 6, 7), (1, 3, 7, 5), (2, 0, 4, 6)]
    return corners, quads


def obj():
    lines = ["# two houses", "mtllib city.mtl", "vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    for number, material in enumerate(("red", "brick")):
        corners, quads = box(40 * number)
        lines += [f"o house_{number}"] + ["v %.3f %.3f %.3f" % corner for corner in corners] + [f"usemtl {material}"]
        lines += ["f " + " ".join(f"{8 * number + corner + 1}/{k + 1}" for k, corner in enumerate(quad))
                  for quad in quads]
    return "\n".join(lines) + "\n"


LIBRARY = "newmtl red\nKd 1 0 0\nPr 0.1\n\nnewmtl brick\nmap_Kd images/brick.png\n"


def ply(form):
    corners, quads = box(0)
    text = (f"ply\nformat {form} 1.0\nelement vertex 8\nproperty double x\nproperty double y\nproperty double z\n"
            "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 6\n"
            "property list uchar int vertex_indices\nend_header\n")
    if form == "ascii":
        text += "".join("%.3f %.3f %.3f 0 255 0\n" % corner for corner in corners)
        return (text + "".join("4 %d %d %d %d\n" % quad for quad in quads)).encode()
    order = "<" if form == "binary_little_endian" else ">"
    return (text.encode() + b"".join(struct.pack(order + "3d3B", *corner, 0, 255, 0) for corner in corners) +
            b"".join(struct.pack(order + "B4i", 4, *quad) for quad in quads))


class Formats(support.Case):
    @classmethod
    def prepare(cls):
        cls.city = cls.folder / "city"
        (cls.city / "images").mkdir(parents=True)
        (cls.city / "city.obj").write_text(obj())
        (cls.city / "city.mtl").write_text(LIBRARY)
        support.write_png(cls.city / "images" / "brick.png", 64, 64, bytes((0, 0, 255)) * 32 * 64 + bytes(3) * 32 * 64)

    def bake(self, *inputs):
        world = self.folder / "world"
        self.zonecast("bake", "--no-light", "--from-scratch", *inputs, "-o", world)
        return world

    def strongest_color(self, world):
        """Linear, of the one node at full detail: its vertices' colours are shares of it."""
        data = (world / "zones" / "0" / "0_0.detail.glb").read_bytes()
        document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
        return document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][:3]

    def inspect(self, world):
        return json.loads(self.zonecast("inspect", world, "--json", "--verify"))

    def test_obj_has_its_triangles_colours_and_texture(self):
        world = self.bake(self.city / "city.obj")
        found = self.inspect(world)
        self.assertEqual(found["source_triangles"], 24)
        self.assertGreater(sum(level["bytes"]["texture"] for level in found["levels"]), 0)
        for value, expected in zip(self.strongest_color(world), (1, 0, 0.5)):  # half of the image is blue, half black
            self.assertAlmostEqual(value, expected, delta=0.01)
        report = json.loads((world / "bake.json").read_text())
        self.assertAlmostEqual(report["reflecting"]["share_of_surface"], 0.5, delta=0.01)  # the red house is smooth
        self.assertEqual(report["notes"], [])

    def test_packed_obj_and_its_folder_are_the_same_world(self):
        world = self.bake(self.city / "city.obj")
        files = support.snapshot(world)
        packed = self.city / "packed.obj.gz"
        packed.write_bytes(gzip.compress(obj().encode()))
        archive = self.folder / "city.zip"
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
            for name in ("city.obj", "city.mtl", "images/brick.png"):
                file.write(self.city / name, "inner/" + name)
        for name in (packed, archive):
            with self.subTest(name=name.name):
                again = support.snapshot(self.bake(name))
                for part in ("world.zcw", "zones/0/0_0.detail.glb", "zones/0/0_0.detail.zbvh"):
                    self.assertEqual(again[part], files[part], part)
        packed.unlink()
        again = support.snapshot(self.bake(self.city))
        self.assertEqual(again["world.zcw"], files["world.zcw"])

    def test_every_form_of_ply_is_the_same_world(self):
        worlds = []
        for form in ("ascii", "binary_little_endian", "binary_big_endian"):
            (self.folder / "house.ply").write_bytes(ply(form))
            world = self.bake(self.folder / "house.ply")
            self.assertEqual(self.inspect(world)["source_triangles"], 12)
            for value, expected in zip(self.strongest_color(world), (0, 1, 0)):
                self.assertAlmostEqual(value, expected, delta=0.01)
            worlds.append(support.snapshot(world)["world.zcw"])
        self.assertEqual(worlds[0], worlds[1])
        self.assertEqual(worlds[0], worlds[2])

    def test_refusals_are_one_line_with_the_place(self):
        bad = self.folder / "bad.obj"
        bad.write_text(obj().replace("412345.500", "412345,500", 1))
        self.assert_refused(["bake", bad, "-o", self.folder / "none"], 1, bad, "byte ", "'412345,500' is no number")
        bad = self.folder / "bad.ply"
        bad.write_bytes(ply("binary_little_endian").replace(b"element vertex 8", b"element vertex 4000000000"))
        self.assert_refused(["bake", bad, "-o", self.folder / "none"], 1, bad, "declares 4000000000")


if __name__ == "__main__":
    support.main()
