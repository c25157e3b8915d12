# SPDX-License-Identifier: Apache-2.0
"""Bad input: one clear line, the right exit code, no crash, nothing half-written."""

import copy
import gzip
import json
import os
import re
import re
import shutil
import subprocess
import zipfile

import support

ARGUMENTS = 2
FAILURE = 1


class PipedModels(support.Case):
    @classmethod
    def prepare(cls):
        city = support.write_small_city(cls.folder / "city.json", blocks=2)
        header = {**city, "CityObjects": {}, "vertices": []}
        lines = [header] + [{"type": "CityJSONFeature", "id": key, "CityObjects": {key: value},
                             "vertices": city["vertices"]} for key, value in city["CityObjects"].items()]
        cls.lines = "".join(json.dumps(line) + "\n" for line in lines)
        (cls.folder / "city.jsonl").write_text(cls.lines)
        cls.zonecast("bake", "--no-light", cls.folder / "city.jsonl", "-o", cls.folder / "from_file")

    def pipe(self, text, *words):
        """A bake of what comes through standard input."""
        return subprocess.run([support.BINARY, "bake", "--no-light", *map(str, words)], input=text, check=False,
                              capture_output=True, timeout=240)

    def test_a_sequence_from_a_pipe_is_the_same_world(self):
        world = self.folder / "from_file"
        for name in ("-", "/dev/stdin"):
            with self.subTest(name=name):
                done = self.pipe(self.lines.encode(), name, "-o", self.folder / "piped")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual((self.folder / "piped" / "world.zcw").read_bytes(), (world / "world.zcw").read_bytes())
        fifo = self.folder / "fifo"
        os.mkfifo(fifo)
        with subprocess.Popen([support.BINARY, "bake", "--no-light", str(fifo), "-o", str(self.folder / "piped")],
                              stdout=subprocess.DEVNULL) as bake:
            fifo.write_text(self.lines)
            self.assertEqual(bake.wait(timeout=240), 0)
        self.assertEqual((self.folder / "piped" / "world.zcw").read_bytes(), (world / "world.zcw").read_bytes())

    def test_packed_models_and_a_folder_of_them_are_the_same_world(self):
        packed, folder, archive = self.folder / "city.jsonl.gz", self.folder / "cities", self.folder / "city.zip"
        packed.write_bytes(gzip.compress(self.lines.encode()))
        folder.mkdir()
        (folder / "city.jsonl").write_text(self.lines)
        (folder / "notes.json").write_text("{}")
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
            file.writestr("inner/city.jsonl", self.lines)
        for name in (packed, folder, archive):
            with self.subTest(name=name.name):
                self.zonecast("bake", "--no-light", name, "-o", self.folder / "unpacked")
                self.assertEqual((self.folder / "unpacked" / "world.zcw").read_bytes(),
                                 (self.folder / "from_file" / "world.zcw").read_bytes())

    def test_other_formats_from_a_pipe_are_one_line(self):
        indented = json.dumps(json.loads((self.folder / "city.json").read_text()), indent=1)
        for text in (b"", b"glTF\2\0\0\0", b"<CityModel/>", indented.encode(), self.lines.encode()[:-20]):
            with self.subTest(text=text[:10]):
                done = self.pipe(text, "-", "-o", self.folder / "none")
                self.assertEqual(done.returncode, FAILURE)
                self.assertRegex(done.stderr.decode(), r"^zonecast: standard input: [^\n]*\n$")
                self.assertFalse((self.folder / "none").exists())


class BadModels(support.Case):
    @classmethod
    def prepare(cls):
        cls.zonecast("generate", "--size-km", "0.1", "-o", cls.folder / "city")
        cls.glb = (cls.folder / "city" / "city.glb").read_bytes()
        cls.city = support.write_small_city(cls.folder / "city.json", blocks=2)
        cls.old = cls.folder / "old"
        cls.zonecast("bake", cls.folder / "city.json", "-o", cls.old)

    def refuse(self, name, content, *parts, code=FAILURE):
        """Neither a new world appears nor an old one changes."""
        path = self.folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        self.assert_refused(["bake", path, "-o", self.folder / "new"], code, path, *parts)
        self.assert_refused(["bake", path, "-o", self.old], code, path, *parts)

    def test_missing_file(self):
        self.assert_refused(["bake", self.folder / "none.glb", "-o", self.folder / "new"], FAILURE, "none.glb")

    def test_folder_without_models(self):
        (self.folder / "none").mkdir()
        self.assert_refused(["bake", self.folder / "none", "-o", self.folder / "new"], FAILURE, self.folder / "none",
                            "without city models")

    def test_empty_file_and_other_formats(self):
        self.refuse("empty.glb", b"")
        self.refuse("noise.bin", bytes(range(256)) * 8)
        self.refuse("text.json", "hello")

    def test_other_formats_are_named_with_the_next_step(self):
        step = b"ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('%s'));\nENDSEC;\n"
        database = b"SQLite format 3\0".ljust(68, b"\0")
        model, plan, city = "export it as glTF, OBJ or PLY", "make a 3D model of it first", "CityGML, CityJSON or glTF"
        for name, content, what, then in (
                ("a.ifc", step % b"IFC4", "is an IFC model", city),
                ("a.stp", step % b"AUTOMOTIVE_DESIGN", "is a STEP file", "export its surfaces"),
                ("a.fbx", b"Kaydara FBX Binary  \0\x1a\0", "is an FBX model", model),
                ("a.dae", b'<?xml version="1.0"?>\n<COLLADA version="1.4.1"/>', "is a COLLADA model", model),
                ("a.3ds", b"MM\x10\0\0\0\x02\0\x0a\0\0\0\x03\0\0\0", "is a 3DS model", model),
                ("a.stl", b"solid house\nfacet normal 0 0 1\n", "is an STL model", model),
                ("b.stl", bytes(80) + b"\x01\0\0\0" + bytes(50), "is an STL model", model),
                ("a.usdc", b"PXR-USDC" + bytes(80), "is a USD model", model),
                ("a.skp", "\ufeff\u0effSketchUp Model".encode("utf-16-le"), "is a SketchUp model", model),
                ("a.dxf", b"  0\r\nSECTION\r\n  2\r\nHEADER\r\n", "is a DXF drawing", "export its surfaces"),
                ("a.dwg", b"AC1027" + bytes(80), "is a DWG drawing", "export its surfaces"),
                ("a.las", b"LASF" + bytes(300), "is a point cloud (LAS or LAZ)", "make a mesh of its points"),
                ("a.shp", b"\0\0\x27\x0a" + bytes(96), "is a shapefile", plan),
                ("a.gpkg", database + b"GPKG", "is a GeoPackage", plan),
                ("a.sqlite", database, "is an SQLite database", "export the city in it"),
                ("a.kml", b'<kml xmlns="http://www.opengis.net/kml/2.2"/>', "is a KML document", plan),
                ("a.osm", b'<osm version="0.6"/>', "is OpenStreetMap data", plan),
                ("a.json", b'{"type": "FeatureCollection", "features": []}', "is GeoJSON", plan),
                ("a.html", b"<!DOCTYPE html>\n<html></html>", "is a web page", "get the model again"),
                ("a.pdf", b"%PDF-1.7\n", "is a PDF document", "name the file of the model"),
                ("a.jpg", b"\xff\xd8\xff\xe0" + bytes(80), "is a JPEG picture", "name the model"),
                ("a.mtl", b"newmtl wall\nKd 1 0 0\n", "is a material library (MTL)", "name the OBJ file"),
                ("a.7z", b"7z\xbc\xaf\x27\x1c", "is a 7z archive", "unpack it"),
                ("a.tar.gz", gzip.compress(bytes(257) + b"ustar"), "is a tar archive", "unpack it"),
                ("old.gltf", b'{"asset": {"version": "1.0"}}', "glTF version 1.0", "convert it"),
                ("cut.glb", self.glb[:100], "file ends early", "get it again"),
                ("empty.obj", b"", "is empty", "get it again")):
            with self.subTest(name=name):
                self.refuse(name, content, what, then)
        for inner, what in (("model.usdc", "is a USDZ model"), ("doc.kml", "is a KMZ document"),
                            ("readme.txt", "is an archive without city models")):
            with self.subTest(inner=inner):
                with zipfile.ZipFile(self.folder / "other.zip", "w") as file:
                    file.writestr(inner, "hello")
                self.refuse("other.zip", (self.folder / "other.zip").read_bytes(), what, "expected")
        (self.folder / "link.glb").symlink_to("nowhere")
        self.assert_refused(["bake", self.folder / "link.glb", "-o", self.folder / "new"], FAILURE, "link.glb",
                            "is a link to 'nowhere', which is not there")

    def test_truncated_glb(self):
        size = len(self.glb)
        json_bytes = int.from_bytes(self.glb[12:16], "little")
        lengths = {4, 11, 12, 13, 19, 20, 21, 20 + json_bytes // 2, 20 + json_bytes, 27 + json_bytes, 28 + json_bytes}
        lengths |= {size * i // 10 for i in range(1, 10)} | {size - 1}
        self.assertGreaterEqual(len(lengths), 20)
        for length in sorted(lengths):
            with self.subTest(length=length):
                self.refuse("cut.glb", self.glb[:length])

    def test_glb_with_damaged_lengths(self):
        for at in (8, 12):  # the file's length, the first chunk's
            for value in (0, 1, 0x7FFFFFFF, 0xFFFFFFFF):
                with self.subTest(at=at, value=value):
                    self.refuse("length.glb", self.glb[:at] + value.to_bytes(4, "little") + self.glb[at + 4 :])

    def test_cityjson_index_out_of_range(self):
        for index in (len(self.city["vertices"]), 2**31, 2**63, -1):
            with self.subTest(index=index):
                city = copy.deepcopy(self.city)
                city["CityObjects"]["house_1_0"]["geometry"][0]["boundaries"][0][0][0][1] = index
                self.refuse("index.json", json.dumps(city), "house_1_0")

    def test_cityjson_of_wrong_shape(self):
        for key, value in (("vertices", 7), ("vertices", [[1, 2]]), ("CityObjects", []), ("transform", {"scale": 1}),
                           ("version", "0.9")):
            with self.subTest(key=key, value=value):
                self.refuse("shape.json", json.dumps({**self.city, key: value}))

    def test_malformed_json(self):
        text = json.dumps(self.city)
        for cause, content in (("cut", text[: len(text) // 2]), ("comma", text.replace(",", ",,", 1)),
                               ("brackets", "{" + "[" * 100_000), ("bytes", b'{"type": "CityJSON\xff\xfe')):
            with self.subTest(cause=cause):
                self.refuse("malformed.json", content)

    def test_names_in_files_do_not_reach_the_terminal(self):
        city = copy.deepcopy(self.city)
        name = "a\nb\x1b[31m" + "x" * 5000
        city["CityObjects"][name] = city["CityObjects"].pop("house_1_0")
        city["CityObjects"][name]["geometry"][0]["boundaries"][0][0][0][1] = 2**31
        self.refuse("names.json", json.dumps(city), "xxx")
        city = copy.deepcopy(self.city)
        house = city["CityObjects"]["house_1_0"]["geometry"][0]
        house["texture"] = {"t": {"values": [[[[0, 0, 0, 0, 0, 0]]] * len(house["boundaries"][0])]}}
        city["appearance"] = {"textures": [{"image": name}], "vertices-texture": [[0, 0]]}
        (self.folder / "names.json").write_text(json.dumps(city))
        done = self.run_zonecast("bake", "--no-light", self.folder / "names.json", "-o", self.folder / "named")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(all(line.startswith("zonecast: info: ") for line in done.stderr.splitlines()), done.stderr)
        self.assertIn("a\\nb\\x1b[31mxxx", done.stderr)
        self.assertNotIn("\x1b", done.stderr)
        self.assertLess(max(map(len, done.stderr.splitlines())), 700)
        notes = json.loads((self.folder / "named" / "bake.json").read_text())["notes"]
        self.assertIn([name], [note.get("names") for note in notes])

    def test_nothing_to_bake(self):
        self.refuse("nothing.json", json.dumps({**self.city, "CityObjects": {}}))

    def test_one_bad_input_of_two(self):
        (self.folder / "bad.json").write_text("{")
        self.assert_refused(["bake", self.folder / "city.json", self.folder / "bad.json", "-o", self.old], FAILURE,
                            "bad.json")

    def test_output_that_is_no_world_is_not_replaced(self):
        photos = self.folder / "photos"
        photos.mkdir()
        (photos / "holiday.jpg").write_bytes(b"precious")
        self.assert_refused(["bake", self.folder / "city.json", "-o", photos], ARGUMENTS, photos)
        self.assert_refused(["bake", self.folder / "city.json", "-o", photos / "holiday.jpg"], ARGUMENTS, "holiday.jpg")

    def test_arguments_that_mean_nothing(self):
        bake = ["bake", self.folder / "city.json", "-o", self.folder / "new"]
        self.assert_refused([*bake, "--bvh", "foo"], ARGUMENTS, "'foo' is none of auto|")
        self.assert_refused([*bake, "--error", "nan"], ARGUMENTS, "at most 100 m")
        self.assert_refused([*bake, "--sun", ""], ARGUMENTS, "'' is not a sun direction")
        self.assert_refused(["bake", "", "-o", self.folder / "new"], ARGUMENTS, "empty name")
        self.assert_refused(["bake", self.folder / "city.json", "-o", ""], ARGUMENTS, "empty name")

    def test_only_a_bake_over_an_old_world_tells_what_it_kept(self):
        words = ["bake", "--no-light", self.folder / "city.json", "-o", self.folder / "twice"]
        self.assertNotIn("as before", self.zonecast(*words))
        self.assertIn("proxies as before", self.zonecast(*words))

    def test_output_that_cannot_be_created(self):
        blocked = self.folder / "city.json" / "world"  # below a file
        self.assert_refused(["bake", self.folder / "city.json", "-o", blocked], FAILURE, "city.json")
        self.assert_refused(["generate", "--size-km", "0.1", "-o", blocked], FAILURE, "city.json")


class BadWorlds(support.Case):
    @classmethod
    def prepare(cls):
        support.write_small_city(cls.folder / "city.json")
        support.small_drive(cls.folder / "drive.csv")
        cls.world = cls.folder / "world"
        cls.zonecast("bake", cls.folder / "city.json", "--leaf-triangles", "64", "-o", cls.world)
        cls.report = json.loads(cls.zonecast("inspect", cls.world, "--json"))

    def damaged(self, name, change):
        """A copy of the world with one file changed."""
        world = self.folder / "damaged"
        shutil.rmtree(world, ignore_errors=True)
        shutil.copytree(self.world, world)
        (world / name).write_bytes(change((world / name).read_bytes()))
        return world

    def replay(self, world, *more, path=None):
        return ["replay", world, "--path", path or self.folder / "drive.csv", "--cap", "16MiB", *more]

    @staticmethod
    def flip(data, at=None):
        at = len(data) // 2 if at is None else at
        return data[:at] + bytes([data[at] ^ 0x40]) + data[at + 1 :]

    def pages(self, depth):
        names = sorted(p.relative_to(self.world).as_posix() for p in (self.world / "zones" / str(depth)).iterdir())
        return [name for name in names if ".detail." not in name]

    def test_flipped_byte_in_a_page_is_found_by_verify(self):
        for name in (self.pages(1)[0], self.pages(1)[1], self.pages(0)[0]):
            world = self.damaged(name, self.flip)
            done = self.run_zonecast("inspect", world, "--verify")
            self.assertEqual(done.returncode, FAILURE)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assertTrue(done.stderr.startswith("zonecast: "))
            self.assertIn(name, done.stderr)
            self.assertIn("1 failures", done.stdout)

    def test_every_damaged_page_has_a_line(self):
        names = [name for name in self.pages(1) if name.endswith(".zbvh")][:2]
        world = self.damaged(names[0], self.flip)
        (world / names[1]).write_bytes(self.flip((world / names[1]).read_bytes()))
        done = self.run_zonecast("inspect", world, "--verify")
        self.assertEqual(done.returncode, FAILURE)
        self.assertEqual(len(done.stderr.splitlines()), 2, done.stderr)
        for name in names:
            self.assertIn(name, done.stderr)

    def test_missing_and_shortened_pages_are_found_by_verify(self):
        name = self.pages(1)[0]
        world = self.damaged(name, lambda data: data[:-1])
        self.assertIn(name, self.run_zonecast("inspect", world, "--verify").stderr)
        (world / name).unlink()
        done = self.run_zonecast("inspect", world, "--verify")
        self.assertEqual(done.returncode, FAILURE)
        self.assertIn(name, done.stderr)

    def test_replay_goes_on_past_a_damaged_page(self):
        deepest = self.pages(max(level["depth"] for level in self.report["levels"] if not level["detail"]))
        for name in (*self.pages(1)[:2], *deepest[:2]):
            world = self.damaged(name, self.flip)
            for more in ((), ("--source-latency", "50ms"), ("--clock", "wall", "--frames", "0:10")):
                with self.subTest(name=name, more=more):
                    stats = self.replay_past(name, world, "--no-render", *more)
                    self.assertEqual(stats["frames"], 10 if "wall" in more else 40)
                    if name in deepest:  # nothing finer can stand in
                        self.assertEqual(stats["wanted_level_fraction"], 0)
                        self.assertEqual(stats["failing_nodes"], 1)

    def test_an_ancestor_reflects_instead_of_a_damaged_page(self):
        more = ("--frames", "0:40:10", "--size", "160x90", "--reflections", "proxy")
        self.zonecast(*self.replay(self.world, *more, "-o", self.folder / "sound"))
        sound = support.read_stats(self.folder / "sound")["rays"]
        deepest = self.pages(max(level["depth"] for level in self.report["levels"] if not level["detail"]))
        world = self.damaged(deepest[0], self.flip)
        for name in deepest[1:]:
            (world / name).write_bytes(self.flip((world / name).read_bytes()))
        stats = self.replay_past("zones/", world, *more)
        self.assertEqual(stats["frames"], 4)
        self.assertEqual(sound["proxy_coarse"], 0)
        self.assertGreater(stats["rays"]["proxy_coarse"], 0)

    def replay_past(self, name, world, *more):
        """The statistics of a replay that warns of pages called `name`, keeps every promise, and ends with exit code 1
        where such a page is wanted to the end."""
        out = self.folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        done = self.run_zonecast(*self.replay(world, *more, "-o", out))
        stats = support.read_stats(out)
        failing = stats["failing_nodes"] + stats["host_failing_nodes"] > 0
        self.assertEqual(done.returncode, FAILURE if failing else 0, done.stderr)
        warnings = done.stderr.splitlines()
        if failing:
            self.assertRegex(warnings.pop(), rf"zonecast: {re.escape(str(world))}: \d+ .*{name}.*--allow-failures")
            self.zonecast(*self.replay(world, *more, "--allow-failures", "-o", out))
        self.assertGreater(len(warnings), 0)
        for line in warnings:
            self.assertTrue(line.startswith("zonecast: warning: "), line)
            self.assertIn(name, line)
        self.assertGreater(stats["requests"]["failed"], 0)
        self.assertGreater(stats["requests"]["retried"], 0)
        self.assertEqual(stats["rays"]["lost"], 0)
        return stats

    def test_damaged_root_page_ends_the_replay(self):
        name = self.pages(0)[0]
        world = self.damaged(name, self.flip)
        self.assert_refused(self.replay(world, "--no-render", "-o", self.folder / "none"), FAILURE, name)
        self.assert_refused(self.replay(world, "-o", self.folder / "none"), FAILURE, name)

    def test_flipped_byte_in_the_index(self):
        size = (self.world / "world.zcw").stat().st_size
        for at in (0, 9, 12, 40, 90, 96, 200, size // 2, size - 1):
            with self.subTest(at=at):
                world = self.damaged("world.zcw", lambda data, at=at: self.flip(data, at))
                for command in (["inspect", world], self.replay(world, "--no-render"), self.replay(world)):
                    self.assert_refused(command, FAILURE, "world.zcw")

    def test_truncated_index(self):
        size = (self.world / "world.zcw").stat().st_size
        for length in (0, 1, 95, 96, 97, size // 2, size - 1):
            with self.subTest(length=length):
                world = self.damaged("world.zcw", lambda data, length=length: data[:length])
                for command in (["inspect", world, "--verify"], self.replay(world, "--no-render")):
                    self.assert_refused(command, FAILURE, "world.zcw")

    def test_world_that_is_none(self):
        for world in (self.folder / "none", self.folder / "drive.csv", self.folder):
            for command in (["inspect", world], self.replay(world, "--no-render"), self.replay(world)):
                self.assert_refused(command, FAILURE, world.name)

    def test_path_that_cannot_be_driven(self):
        good = (self.folder / "drive.csv").read_text().splitlines()
        fields = good[4].split(",")
        # what the line must say, content
        cases = {
            "nan": (["5: "], [*good[:4], ",".join(["0.3", "nan", *fields[2:]]), *good[5:]]),
            "infinite": (["5: "], [*good[:4], ",".join([*fields[:7], "inf"]), *good[5:]]),
            "text": (["line 5", "value 2"], [*good[:4], ",".join(["0.3", "x", *fields[2:]]), *good[5:]]),
            "few": (["line 5"], [*good[:4], ",".join(fields[:7]), *good[5:]]),
            "many": (["line 5"], [*good[:4], good[4] + ",1", *good[5:]]),
            "backwards": (["line 6"], [*good[:4], good[5], good[4]]),
            "looks at itself": (["line 5"], [*good[:4], ",".join([*fields[:4], *fields[1:4], "60"])]),
            "field of view": (["line 5"], [*good[:4], ",".join([*fields[:7], "180"])]),
            "header": (["line 1", "header"], ["t,x,y,z", *good[1:]]),
            "no header": (["line 1", "header"], good[1:]),
            "no cameras": (["no camera"], good[:1]),
            "empty": (["no camera"], []),
            "shots": (["shots"], ['{"shots": [{"name": 7}]}']),
            "shot count": (["no camera"], ['{"shots": []}']),
        }
        path = self.folder / "bad.csv"
        for cause, (parts, lines) in cases.items():
            with self.subTest(cause=cause):
                path.write_text("".join(line + "\n" for line in lines))
                self.assert_refused(self.replay(self.world, "--no-render", "-o", self.folder / "none", path=path),
                                    FAILURE, path, *parts)
        self.assert_refused(self.replay(self.world, path=self.folder / "none.csv"), FAILURE, "none.csv")

    def test_path_of_another_place(self):
        path = self.folder / "elsewhere.csv"
        support.write_path(path, [(0, (0, 0, 2), (1, 0, 2)), (1, (1e8, 0, 2), (1e8, 1, 2))])
        self.assert_refused(self.replay(self.world, "--size", "64x64", "-o", self.folder / "none", path=path), FAILURE,
                            "CRS")

    def test_cap_below_the_pinned_set_names_the_cap_that_works(self):
        for more in (("--no-render",), ("--size", "64x64", "--frames", "0:2")):
            command = ["replay", self.world, "--path", self.folder / "drive.csv", *more]
            smallest = self.report["smallest_cap_bytes"]
            if more[0] != "--no-render":  # what drawing takes comes on top, and is the device's
                line = self.assert_refused([*command, "--cap", smallest, "-o", self.folder / "none"], FAILURE)
                smallest = int(re.search(r"works is (\d+) bytes", line)[1])
            for cap in (0, 1000, smallest - 1):
                self.assert_refused([*command, "--cap", cap, "-o", self.folder / "none"], FAILURE, smallest)
            out = self.folder / "tight"
            self.zonecast(*command, "--cap", smallest, "-o", out)
            stats = support.read_stats(out)
            if "--no-render" in more:
                self.assert_memory_within_cap(stats)
            self.assertEqual(stats["rays"]["lost"], 0)
            shutil.rmtree(out)

    def test_output_folder_that_cannot_be_created(self):
        for more in ((), ("--no-render",)):
            self.assert_refused(self.replay(self.world, *more, "-o", self.folder / "drive.csv" / "out"), FAILURE,
                                "drive.csv")

    def test_unknown_device(self):
        self.assert_refused(self.replay(self.world, "--device", "no such device", "-o", self.folder / "none"), FAILURE,
                            "no such device")

    def test_bad_arguments(self):
        replay = self.replay(self.world, "-o", self.folder / "none")
        without_cap = replay[: replay.index("--cap")]
        for arguments in (
            [], ["dance"], ["bake"], ["bake", self.folder / "city.json"], ["inspect"],
            ["inspect", self.world, "--colour"], ["generate"],
            ["generate", "--size-km", "0", "-o", self.folder / "none"],
            ["generate", "--seed", "x", "-o", self.folder / "none"],
            ["bake", self.folder / "city.json", "-o", self.folder / "none", "--error", "-1"],
            ["bake", self.folder / "city.json", "-o", self.folder / "none", "--leaf-triangles", "1"],
            ["bake", self.folder / "city.json", "-o", self.folder / "none", "--atlas", "100"],
            ["bake", self.folder / "city.json", "-o", self.folder / "none", "--sun", "145,-3"],
            ["bake", self.folder / "city.json", "-o", self.folder / "none", "--sun", "145,38", "--no-light"],
            without_cap, [*without_cap, "--cap", "nonsense"], [*without_cap, "--cap", "-1"],
            [*without_cap, "--cap", "1 parsec"], [*without_cap, "--cap", ""], [*replay, "--cap", "1MiB"],
            [*replay, "--frames", "5:2"], [*replay, "--frames", "1"], [*replay, "--frames", "0:4:0"],
            [*replay, "--frames", "a:b"], [*replay, "--frames", "1000:2000"],
            [*replay, "--frames", "1000:2000", "--no-render"],
            [*replay, "--size", "0x0"], [*replay, "--size", "100000x100"], [*replay, "--size", "640"],
            [*replay, "--sun", "x"], [*replay, "--sun", "1,2,3"], [*replay, "--sun", "0,91"],
            [*replay, "--sun", "0,nan"],
            [*replay, "--reflections", "magic"], [*replay, "--debug-views", "xray"], [*replay, "--clock", "sundial"],
            [*replay, "--threads", "-1"], [*replay, "--threads", "9999"], [*replay, "--tolerance", "0"],
            [*replay, "--source-latency", "50"], [*replay, "--source-latency", "-5ms"],
            [*replay, "--source-bandwidth", "20MB"], [*replay, "--clock", "wall", "--source-latency", "50ms"],
            [*replay, "--no-such-option"], [*replay, "one", "too", "many"],
        ):
            with self.subTest(arguments=" ".join(map(str, arguments))):
                self.assert_refused(arguments, ARGUMENTS)

    def test_an_error_quotes_line_breaks_on_one_line(self):
        self.assert_refused(["inspect", "no\nsuch\nworld"], FAILURE)
        self.assert_refused(["dan\nce"], ARGUMENTS)


if __name__ == "__main__":
    support.main()
