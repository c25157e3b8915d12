# SPDX-License-Identifier: Apache-2.0
"""The same input gives the same bytes, at any thread count."""

import json

import support

THREADS = (1, 2, 4)


class Determinism(support.Case):
    @classmethod
    def prepare(cls):
        cls.city = cls.folder / "city"
        cls.zonecast("generate", "--size-km", "0.3", "--seed", "5", "-o", cls.city)
        for threads in THREADS:
            cls.zonecast("bake", cls.city / "city.glb", "--threads", threads, "-o", cls.world(threads))

    @classmethod
    def world(cls, threads):
        return cls.folder / f"world{threads}"

    def test_a_city_is_its_seed(self):
        again, other = self.folder / "again", self.folder / "other"
        self.zonecast("generate", "--size-km", "0.3", "--seed", "5", "-o", again)
        self.zonecast("generate", "--size-km", "0.3", "--seed", "6", "-o", other)
        self.assertEqual(support.snapshot(again), support.snapshot(self.city))
        self.assertNotEqual(support.snapshot(other)["city.glb"], support.snapshot(self.city)["city.glb"])

    def test_a_world_has_the_same_bytes_at_any_thread_count(self):
        worlds = [support.snapshot(self.world(threads)) for threads in THREADS]
        for world in worlds:
            del world["bake.json"]  # how long it took
        self.assertGreater(len(worlds[0]), 50)
        self.assertEqual(worlds[1], worlds[0])
        self.assertEqual(worlds[2], worlds[0])

    def test_a_bake_replaces_a_world_by_the_same_bytes(self):
        before = support.snapshot(self.world(2))
        self.zonecast("bake", self.city / "city.glb", "-o", self.world(2))
        after = support.snapshot(self.world(2))
        del before["bake.json"], after["bake.json"]
        self.assertEqual(after, before)

    def test_a_replay_pages_the_same_at_any_thread_count(self):
        smallest = smallest_cap(self, self.world(1))
        logs = set()
        for threads in THREADS:
            out = self.folder / f"paged{threads}"
            self.zonecast("replay", self.world(1), "--path", self.city / "drive.csv", "--no-render", "--clock",
                          "virtual", "--source-latency", "50ms", "--source-bandwidth", "20MB/s", "--cap",
                          6 * smallest, "--threads", threads, "-o", out)
            stats = support.read_stats(out)
            self.assertGreater(stats["zones_evicted"], 0, "the cap is not tight")
            self.assert_memory_within_cap(stats)
            self.assertGreaterEqual(stats["request_to_resident_ms"]["p50"], 50)
            logs.add(stats["event_log_xxh3"])
            log = (out / "frames.csv").read_bytes()
            self.assertEqual(log, (self.folder / "paged1" / "frames.csv").read_bytes())
        self.assertEqual(len(logs), 1, logs)


def smallest_cap(case, world):
    return json.loads(case.zonecast("inspect", world, "--json"))["smallest_cap_bytes"]


if __name__ == "__main__":
    support.main()
