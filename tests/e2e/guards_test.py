# SPDX-License-Identifier: Apache-2.0
"""What a job relies on: nothing is lost silently, nothing of the user's is replaced, and a world says where it is from."""
import json
import os
import shutil
import subprocess
import time

import support

FAILURE, ARGUMENTS = 1, 2


class Strict(support.Case):
    @classmethod
    def prepare(cls):
        cls.city = cls.folder / "city.json"
        whole = support.write_small_city(cls.city, blocks=2)
        whole["CityObjects"]["lamp"] = {"type": "CityFurniture", "geometry": [
            {"type": "MultiPoint", "lod": "1", "boundaries": [0, 1]}]}
        cls.lossy = cls.folder / "lossy.json"
        cls.lossy.write_text(json.dumps(whole))
        cls.world = cls.folder / "world"

    def test_a_loss_ends_the_bake_and_leaves_no_world(self):
        kind = "geometries of points or lines, left out: 1"
        self.assert_refused(["bake", self.lossy, "-o", self.folder / "none", "--strict"], FAILURE, self.lossy, kind,
                            "--strict")
        self.assertIn(kind, self.run_zonecast("bake", self.lossy, "-o", self.world).stderr)
        self.assert_refused(["bake", self.lossy, "-o", self.world, "--strict"], FAILURE, kind)

    def test_missing_images_are_a_loss(self):
        city = json.loads(self.city.read_text())
        city["appearance"] = {"textures": [{"type": "PNG", "image": "none.png"}], "vertices-texture": [[0, 0], [1, 0], [1, 1]]}
        house = city["CityObjects"]["house_0_0"]["geometry"][0]
        house["texture"] = {"day": {"values": [[[[0, 0, 1, 2, 0][: 1 + len(face[0])]] for face in house["boundaries"][0]]]}}
        path = self.folder / "textured.json"
        path.write_text(json.dumps(city))
        self.assert_refused(["bake", path, "-o", self.folder / "none", "--strict"], FAILURE, "texture")

    def test_what_takes_nothing_from_the_city_is_no_loss(self):
        city = json.loads(self.city.read_text())
        city["metadata"]["referenceSystem"] = "EPSG of our town"
        path = self.folder / "noted.json"
        path.write_text(json.dumps(city))
        done = self.run_zonecast("bake", path, "-o", self.folder / "noted", "--strict")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("reference systems without an EPSG code", done.stderr)

    def test_a_whole_city_is_baked_as_without_the_option(self):
        worlds = [self.folder / name for name in ("plain", "strict")]
        self.zonecast("bake", self.city, "-o", worlds[0])
        self.zonecast("bake", self.city, "-o", worlds[1], "--strict")
        plain, strict = map(support.snapshot, worlds)
        self.assertNotEqual(plain.pop("bake.json"), strict.pop("bake.json"))
        self.assertEqual(plain, strict)


class Origin(support.Case):
    @classmethod
    def prepare(cls):
        cls.city = cls.folder / "city.json"
        support.write_small_city(cls.city, blocks=2)

    def bake(self, *words):
        world = self.folder / "world"
        shutil.rmtree(world, ignore_errors=True)
        self.zonecast("bake", *words, "-o", world)
        return json.loads((world / "bake.json").read_text())

    def test_a_bake_keeps_its_inputs_options_and_versions(self):
        rules = self.folder / "rules.json"
        rules.write_text('{"materials": []}')
        report = self.bake(self.city, "--error", "0.2", "--bvh", "sbvh", "--sun", "145,38", "--wet", "--materials", rules,
                           "--ground-plane", "lowest", "--threads", "2")
        self.assertEqual(next(iter(report)), "bake_s")
        self.assertEqual("zonecast " + report["version"], self.zonecast("--version").strip())
        self.assertEqual(report["format"], 5)
        (given,) = report["inputs"]
        self.assertEqual((given["path"], given["bytes"]), (str(self.city), self.city.stat().st_size))
        self.assertRegex(given["xxh3"], r"^[0-9a-f]{16}$")
        options = report["options"]
        self.assertEqual(options.pop("materials")["path"], str(rules))
        self.assertEqual(options, {
            "error_m": 0.2, "leaf_triangles": 4000, "bvh": "sbvh", "atlas": 512, "light": True, "sun": [145.0, 38.0],
            "exterior": False, "step_log2": -8, "reuse": True, "threads": 2, "skip_missing": False, "strict": False,
            "wet": True, "ground_plane": "lowest", "scale": [], "up": [], "offset": [], "crs": []})

    def test_the_same_bake_says_the_same(self):
        first, second = (self.bake(self.city, "--from-scratch") for _ in range(2))
        for report in (first, second):
            for key in ("bake_s", "peak_rss_bytes"):  # of the clock and the machine
                report.pop(key)
        self.assertEqual(first, second)

    def test_another_content_has_another_hash(self):
        folder = self.folder / "models"
        folder.mkdir()
        (folder / "a.json").write_text(self.city.read_text())
        (folder / "b.json").write_text(self.city.read_text())
        hashes = {self.bake(self.city)["inputs"][0]["xxh3"], self.bake(folder)["inputs"][0]["xxh3"]}
        self.assertEqual(self.bake(folder)["inputs"][0]["bytes"], 2 * self.city.stat().st_size)
        (folder / "b.json").write_text(self.city.read_text() + "\n")
        hashes.add(self.bake(folder)["inputs"][0]["xxh3"])
        (folder / "b.json").rename(folder / "c.json")
        hashes.add(self.bake(folder)["inputs"][0]["xxh3"])
        self.assertEqual(len(hashes), 4)

    def test_a_stream_has_neither_size_nor_hash(self):
        sequence = self.folder / "seq.jsonl"
        city = json.loads(self.city.read_text())
        head = {**city, "CityObjects": {}, "vertices": []}
        feature = {"type": "CityJSONFeature", "id": "house_0_0", "vertices": city["vertices"],
                   "CityObjects": {"house_0_0": city["CityObjects"]["house_0_0"]}}
        sequence.write_text(json.dumps(head) + "\n" + json.dumps(feature) + "\n")
        with sequence.open() as stream:
            subprocess.run([support.BINARY, "bake", "-", "-o", str(self.folder / "piped")], stdin=stream, check=True,
                           capture_output=True)
        report = json.loads((self.folder / "piped" / "bake.json").read_text())
        self.assertEqual(report["inputs"], [{"path": "-", "bytes": None, "xxh3": None}])


class Apart(support.Case):
    @classmethod
    def prepare(cls):
        cls.world = cls.folder / "world"
        cls.bake_small_city(cls.world)
        cls.city = cls.folder / "city.json"

    def test_a_bake_replaces_no_input(self):
        (self.folder / "link").symlink_to(self.world)
        leaf = next((self.world / "zones" / "1").glob("*.glb"))
        left = self.folder / ".next.baking"
        left.mkdir()
        shutil.copy(self.city, left / "city.json")
        for words in (
            [self.world, "-o", self.world], [self.world / "tileset.json", "-o", self.world], [leaf, "-o", self.world],
            [self.city, self.world / "tileset.json", "-o", f"{self.world}/"],
            [self.world / "tileset.json", "-o", self.folder / "zones" / ".." / "world"],
            [self.folder / "link" / "tileset.json", "-o", self.world],
            [left / "city.json", "-o", self.folder / "next"],
        ):
            with self.subTest(words=words):
                self.assert_refused(["bake", *words], ARGUMENTS, "which this bake replaces")
        self.assert_refused(["bake", self.city, "--materials", self.world / "tileset.json", "-o", self.world], ARGUMENTS,
                            "which this bake replaces")
        self.zonecast("bake", self.world / "tileset.json", "-o", self.folder / "other")

    def test_two_replays_into_one_folder(self):
        path, out = self.folder / "long.csv", self.folder / "out"
        support.small_drive(path, samples=100)
        words = ["replay", self.world, "--path", path, "--cap", "8MiB", "--no-render", "-o", out]
        first = subprocess.Popen([support.BINARY, *map(str, words), "--clock", "wall"], stdout=subprocess.DEVNULL)
        try:
            lock = out / ".zonecast.lock"
            for _ in range(500):
                if lock.exists():
                    break
                time.sleep(0.01)
            done = self.run_zonecast(*words)
            self.assertIsNone(first.poll(), "the first one must still run")
            self.assertEqual(done.returncode, FAILURE, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1)
            self.assertIn(f"{out}: another replay is writing into this folder", done.stderr)
        finally:
            code = first.wait(timeout=60)
        self.assertEqual(code, 0)
        self.assertEqual(sorted(os.listdir(out)), ["frames.csv", "stats.json"])
        self.zonecast(*words)
        self.assertEqual(sorted(os.listdir(out)), ["frames.csv", "stats.json"])


if __name__ == "__main__":
    support.main()
