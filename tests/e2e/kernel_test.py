# SPDX-License-Identifier: Apache-2.0
"""`replay --kernel`: measured once a device, remembered, fixed by name; the pictures are the same by every kernel."""
import json

import support

ARGUMENTS = 2
NAMES = ("packets64+texels", "packets32+storage+shared+w32", "single+texels", "single+storage+shared+w128")


class Kernel(support.Case):
    @classmethod
    def prepare(cls):
        support.write_small_city(cls.folder / "city.json")
        support.small_drive(cls.folder / "drive.csv")
        cls.world = cls.folder / "world"
        cls.zonecast("bake", cls.folder / "city.json", "-o", cls.world)
        cls.kept = cls.cache / "zonecast" / "trace_variants.json"

    def arguments(self, kernel, out, *more, reflections="proxy"):
        return ["replay", self.world, "--path", self.folder / "drive.csv", "--cap", "16MiB", "--frames", "0:2",
                "--size", "640x360", "--reflections", reflections, "--kernel", kernel, "-o", out, *more]

    def replay(self, kernel, *more, **others):
        """What the statistics say of the kernel, the pictures, and what was said on standard error."""
        out = self.folder / "out"
        done = self.run_zonecast(*self.arguments(kernel, out, *more, **others))
        self.assertEqual(done.returncode, 0, done.stderr)
        stats = support.read_stats(out)
        pictures = support.snapshot(out / "frames") if "--no-render" not in more else None
        return (stats["trace_variant"], stats["trace_variant_origin"], stats["trace_variant_measure_ms"], pictures,
                done.stderr)

    def test_it_is_measured_once_and_remembered(self):
        self.kept.unlink(missing_ok=True)
        # Whether `auto` has time for all kernels is the machine's affair; what it had no time for, it does not remember.
        name, origin, measure_ms, pictures, _ = self.replay("measure")
        print(f"{name}, measured in {measure_ms:.0f} ms")
        self.assertEqual(origin, "measured")
        self.assertGreater(measure_ms, 0)
        (entry,) = json.loads(self.kept.read_text())["entries"]
        self.assertEqual(entry["variant"], name)
        before = support.snapshot(self.kept.parent)
        self.assertEqual(list(before), [self.kept.name], "nothing else is left there")
        self.assertEqual(self.replay("auto"), (name, "cached", None, pictures, ""))
        self.assertEqual(support.snapshot(self.kept.parent), before)

    def test_what_is_remembered_is_used_until_it_is_measured_again(self):
        self.replay("measure")
        cache = json.loads(self.kept.read_text())
        cache["entries"][0]["variant"] = "single+storage+w32"
        self.kept.write_text(json.dumps(cache))
        self.assertEqual(self.replay("auto")[:2], ("single+storage+w32", "cached"))
        name, origin, *_ = self.replay("measure")
        self.assertEqual(origin, "measured")
        self.assertEqual(json.loads(self.kept.read_text())["entries"][0]["variant"], name)

    def test_a_damaged_or_foreign_cache_is_measured_anew(self):
        self.replay("measure")
        sound = self.kept.read_text()
        driver = json.loads(sound)["entries"][0]["driver"]
        for damaged in ("", sound[:-20], "[]", sound.replace("+", "-"), sound.replace(driver, "another driver")):
            self.kept.write_text(damaged)
            _, origin, _, _, said = self.replay("auto")
            self.assertEqual((origin, said), ("measured", ""), damaged)
            self.replay("measure")
            self.assertEqual(len(json.loads(self.kept.read_text())["entries"]), 1)

    def test_a_cache_that_cannot_be_written_is_one_warning(self):
        blocked = self.folder / "blocked"
        blocked.write_text("a file where the folder should be")
        out = self.folder / "out"
        done = self.run_zonecast(*self.arguments("measure", out), environment={"XDG_CACHE_HOME": str(blocked)})
        self.assertEqual(done.returncode, 0, done.stderr)
        (line,) = done.stderr.splitlines()
        self.assertIn(str(blocked), line)
        self.assertEqual(support.read_stats(out)["trace_variant_origin"], "measured")

    def test_kernels_by_name_draw_the_same_pictures_and_touch_no_cache(self):
        self.kept.unlink(missing_ok=True)
        seen = set()
        for name in NAMES:
            *how, pictures, said = self.replay(name, "--validate")
            self.assertEqual((how, said), ([name, "fixed", None], ""))
            self.assertEqual(len(pictures), 2)
            seen.add(json.dumps(pictures))
        self.assertEqual(len(seen), 1)
        self.assertFalse(self.kept.exists())

    def test_without_rays_nothing_is_measured(self):
        self.kept.unlink(missing_ok=True)
        self.assertEqual(self.replay("auto", "--no-render")[:3], (None, None, None))
        self.assertEqual(self.replay("measure", reflections="none")[1:3], ("default", None))
        self.assertFalse(self.kept.exists())

    def test_other_names_are_refused_and_the_known_ones_told(self):
        out = self.folder / "none"
        for name in ("", "fast", "packets64", "packets64+texels+w64"):
            self.assert_refused(self.arguments(name, out), ARGUMENTS, f"'{name}'", "auto", "packets64", "+texels")


if __name__ == "__main__":
    support.main()
