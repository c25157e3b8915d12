# SPDX-License-Identifier: Apache-2.0
"""A world on a web server pages as its folder does, from a folder there and from an archive, with a cache and without."""
import json
import shutil

import support
import web_server

FAILURE = 1
ARGUMENTS = 2


class Worlds(support.Case):
    @classmethod
    def prepare(cls):
        cls.site = cls.folder / "site"
        cls.site.mkdir()
        cls.world = cls.site / "world"
        cls.bake_small_city(cls.world, cls.site / "world.3tz")
        cls.path = cls.folder / "path.csv"
        support.small_drive(cls.path)
        cls.expected, _ = cls.replay(cls.world)

    def setUp(self):
        self.server = web_server.WebServer(self.site)
        self.addCleanup(self.server.stop)

    @classmethod
    def replay(cls, world, *options):
        """The summary and the source's figures."""
        out = cls.folder / "out"
        cls.zonecast("replay", world, "--path", cls.path, "--cap", cls.cap_for(world), "--no-render", "-o", out, *options)
        stats = json.loads((out / "stats.json").read_text())
        return stats["summary"], stats["source"]

    def assert_same_paging(self, summary):
        for key in ("event_log_xxh3", "bytes_read", "zones_loaded", "requests"):
            self.assertEqual(summary[key], self.expected[key], key)
        free = [one["cap_bytes"] - one["peak_ledger_bytes"] for one in (summary, self.expected)]
        self.assertEqual(*free)
        self.assert_memory_within_cap(summary)

    def test_a_folder_pages_as_the_one_on_the_disk_at_any_thread_count(self):
        for threads in (1, 4):
            summary, source = self.replay(self.server.url("world"), "--threads", threads)
            self.assert_same_paging(summary)
            self.assertEqual(source["failed"], 0)
            self.assertGreaterEqual(source["bytes_received"], summary["bytes_read"])
        self.replay(self.server.url("world/?token=secret"))
        self.assertTrue(self.server.requests[-1][1].startswith("/world/zones/"))

    def test_an_archive_pages_as_the_folder_with_one_range_a_page(self):
        summary, source = self.replay(self.server.url("world.3tz"))
        self.assert_same_paging(summary)
        # The end, the index's header, the index; header and data of world.zcw; a page each.
        self.assertLessEqual(source["requests"], 5 + summary["requests"]["issued"])
        self.assertTrue(all("range" in headers for _, _, headers in self.server.requests))
        tail, *others = self.server.requests
        self.assertNotIn("if-range", tail[2])
        self.assertEqual(len({headers["if-range"] for _, _, headers in others}), 1)

    def test_every_command_that_reads_a_world_reads_it_from_there(self):
        for name in ("world", "world.3tz"):
            there, here = (json.loads(self.zonecast("inspect", place, "--json", "--verify"))
                           for place in (self.server.url(name), self.world))
            least = there.pop("smallest_cap_bytes")
            self.assertEqual(least, self.cap_for(self.server.url(name), here.pop("smallest_cap_bytes")))
            self.assertEqual(there, here)
            self.zonecast("pack", self.server.url(name), "-o", self.folder / "again.3tz")
            self.assertEqual((self.folder / "again.3tz").read_bytes(), (self.site / "world.3tz").read_bytes())

    def test_a_cache_answers_for_the_server(self):
        for name in ("world", "world.3tz"):
            with self.subTest(name):
                options = ("--cache", self.folder / f"cache_{name}")
                cold, cold_source = self.replay(self.server.url(name), *options)
                warm, warm_source = self.replay(self.server.url(name), *options)
                self.assert_same_paging(cold)
                self.assert_same_paging(warm)
                self.assertEqual(cold_source["cache_hits"], 0)
                self.assertEqual(warm_source["requests"], 1)  # whether it is still the same world
                self.assertGreaterEqual(warm_source["cache_hits"], 2 * warm["requests"]["issued"])
                self.assertLess(warm_source["bytes_received"], 1025)

    def test_damage_in_the_cache_is_read_again(self):
        cache = self.folder / "cache_damaged"
        self.replay(self.server.url("world"), "--cache", cache)
        entries = sorted(cache.iterdir())
        for i, entry in enumerate(entries):
            data = bytearray(entry.read_bytes())
            data[i * 7 % len(data)] ^= 1
            entry.write_bytes(data if i % 3 else data[: len(data) // 2])
        summary, source = self.replay(self.server.url("world"), "--cache", cache)
        self.assert_same_paging(summary)
        self.assertEqual(source["cache_damaged"], len(entries) - 1)  # without a sound ETag, no index is looked for
        self.assertEqual(source["failed"], 0)

    def test_a_small_cache_stays_small(self):
        cache = self.folder / "cache_small"
        summary, _ = self.replay(self.server.url("world"), "--cache", cache, "--cache-bytes", "40KiB")
        self.assert_same_paging(summary)
        self.assertLessEqual(sum(entry.stat().st_size for entry in cache.iterdir()), 40 << 10)

    def test_a_server_without_etags_will_do(self):
        self.server.etags = False
        for name in ("world", "world.3tz"):
            summary, _ = self.replay(self.server.url(name), "--cache", self.folder / f"cache_no_etag_{name}")
            self.assert_same_paging(summary)

    def test_what_cannot_be_opened_is_one_line(self):
        (self.site / "text.3tz").write_text("no archive" * 500)
        self.addCleanup((self.site / "text.3tz").unlink)
        closed = web_server.WebServer(self.site)
        closed.stop()
        for arguments, code, *parts in (
                (["inspect", self.server.url("none")], FAILURE, self.server.url("none/world.zcw"), "404"),
                (["inspect", self.server.url("none").replace("http:", "HTTP:")], FAILURE, "404"),
                (["inspect", self.server.url("none.3tz")], FAILURE, "none.3tz", "404"),
                (["inspect", self.server.url("text.3tz")], FAILURE, "text.3tz", "not a 3D Tiles archive"),
                (["inspect", closed.url("world")], FAILURE, closed.url("world/world.zcw")),
                (["inspect", "http://"], ARGUMENTS, "address"),
                (["inspect", self.server.url("world"), "--timeout", "0s"], ARGUMENTS, "--timeout"),
                (["inspect", self.server.url("world"), "--cache", "/dev/null/x"], FAILURE, "/dev/null/x"),
                (["inspect", self.server.url("world"), "--cache-bytes", "many"], ARGUMENTS, "many"),
                (["inspect", f"http://user:secret@127.0.0.1:{self.server.port}/none?key=secret"], FAILURE, "404")):
            with self.subTest(arguments=arguments):
                line = self.assert_refused(arguments, code, *parts)
                self.assertNotIn("secret", line)


if __name__ == "__main__":
    support.main()
