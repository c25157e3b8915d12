# SPDX-License-Identifier: Apache-2.0
"""A world in one file pages, renders and shows as its folder does; other readers of ZIP open it."""

import shutil
import zipfile

import support

FAILURE = 1
ARGUMENTS = 2


class Archives(support.Case):
    @classmethod
    def prepare(cls):
        cls.world, cls.archive = cls.folder / "world", cls.folder / "world.3tz"
        cls.bake_small_city(cls.world, cls.archive)
        cls.path = cls.folder / "path.csv"
        support.small_drive(cls.path)

    def test_every_file_of_the_world_is_in_it_as_it_is_and_nothing_else(self):
        with zipfile.ZipFile(self.archive) as archive:
            self.assertIsNone(archive.testzip())
            names = archive.namelist()
            self.assertEqual(names[0], "world.zcw")
            self.assertEqual(names[-1], "@3dtilesIndex1@")
            files = {p.relative_to(self.world).as_posix() for p in self.world.rglob("*") if p.is_file()}
            self.assertEqual(set(names[:-1]), files - {"bake.cache"})
            for name in names[:-1]:
                self.assertEqual(archive.read(name), (self.world / name).read_bytes(), name)

    def test_packing_an_archive_or_twice_gives_the_same_bytes(self):
        for source in (self.world, self.archive):
            self.zonecast("pack", source, "-o", self.folder / "again.3tz")
            self.assertEqual((self.folder / "again.3tz").read_bytes(), self.archive.read_bytes())

    def test_it_is_inspected_and_paged_as_the_folder_is(self):
        self.assertEqual(self.zonecast("inspect", self.archive, "--json", "--verify"),
                         self.zonecast("inspect", self.world, "--json", "--verify"))
        stats = []
        for world in (self.world, self.archive):
            out = self.folder / "out"
            self.zonecast("replay", world, "--path", self.path, "--cap", "8MiB", "--no-render", "-o", out)
            stats.append(support.read_stats(out))
        self.assertEqual(stats[0]["event_log_xxh3"], stats[1]["event_log_xxh3"])
        self.assertEqual(stats[0]["bytes_read"], stats[1]["bytes_read"])
        self.assert_memory_within_cap(stats[1])

    def test_damage_is_not_packed(self):
        damaged = self.folder / "damaged"
        shutil.copytree(self.world, damaged)
        page = sorted(damaged.rglob("*.glb"))[1]
        data = bytearray(page.read_bytes())
        data[len(data) // 2] ^= 1
        page.write_bytes(data)
        self.assert_refused(["pack", damaged, "-o", self.folder / "damaged.3tz"], FAILURE, page.name)

    def test_what_cannot_be_packed_or_opened_is_one_line(self):
        damaged = self.folder / "damaged.3tz"
        damaged.write_bytes(self.archive.read_bytes()[:-30])
        text = self.folder / "text.3tz"
        text.write_text("not an archive")
        for arguments, code, *parts in (
                (["pack", self.world, "-o", self.folder / "x.zip"], ARGUMENTS, "x.zip", ".3tz"),
                (["pack", self.archive, "-o", self.archive], ARGUMENTS, "itself"),
                (["pack", self.folder / "none", "-o", self.folder / "x.3tz"], FAILURE, "none"),
                (["pack", self.world, "-o", self.folder / "none" / "x.3tz"], FAILURE, "x.3tz"),
                (["inspect", text], FAILURE, text, "not a 3D Tiles archive"),
                (["inspect", damaged], FAILURE, damaged)):
            with self.subTest(arguments=arguments):
                self.assert_refused(arguments, code, *parts)


if __name__ == "__main__":
    support.main()
