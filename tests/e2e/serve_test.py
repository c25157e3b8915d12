# SPDX-License-Identifier: Apache-2.0
"""`zonecast serve`: what it answers, what it refuses, and that a world pages from it as from its folder."""
import concurrent.futures
import http.client
import json
import re
import shutil
import signal
import socket
import subprocess
import time
import urllib.parse

import support

FAILURE = 1
ARGUMENTS = 2


def ask(address, target, method="GET", headers=(), body=None):
    """(status, headers in lower case, body), of a connection of its own; the target goes as it is."""
    place = urllib.parse.urlsplit(address)
    connection = http.client.HTTPConnection(place.hostname, place.port, timeout=20)
    try:
        connection.putrequest(method, target, skip_accept_encoding=True)
        for key, value in dict(headers).items():
            connection.putheader(key, value)
        if body is not None:
            connection.putheader("Content-Length", str(len(body)))
        connection.endheaders(body)
        answer = connection.getresponse()
        return answer.status, {key.lower(): value for key, value in answer.getheaders()}, answer.read()
    finally:
        connection.close()


def raw(address, data, timeout_s=20):
    """All that comes back for these bytes until the server closes."""
    place = urllib.parse.urlsplit(address)
    with socket.create_connection((place.hostname, place.port), timeout=timeout_s) as connection:
        try:
            connection.sendall(data)
        except OSError:
            pass  # refused before all was sent
        answer = b""
        try:
            while chunk := connection.recv(65536):
                answer += chunk
        except ConnectionResetError:
            pass
        return answer


def metric(address, name):
    text = ask(address, "/metrics")[2].decode()
    found = re.search(rf"^{re.escape(name)} (\S+)$", text, re.MULTILINE)
    return float(found[1]) if found else 0.0


class Served(support.Case):
    @classmethod
    def prepare(cls):
        cls.world, cls.archive = cls.folder / "world", cls.folder / "packed.3tz"
        cls.bake_small_city(cls.world, cls.archive)
        cls.path = cls.folder / "path.csv"
        support.small_drive(cls.path)
        cls.index = (cls.world / "world.zcw").read_bytes()
        server = cls.serve(cls.world)
        cls.address = server.__enter__()
        cls.addClassCleanup(server.__exit__, None, None, None)

    def replay(self, world, *options):
        out = self.folder / "out"
        self.zonecast("replay", world, "--path", self.path, "--cap", self.cap_for(world), "--no-render", "-o", out,
                      *options)
        return json.loads((out / "stats.json").read_text())

    def test_a_world_pages_from_it_as_from_its_folder(self):
        expected = self.replay(self.world)["summary"]
        with self.serve(self.archive) as archive:
            self.assertTrue(archive.endswith("/packed.3tz"))
            for address in (self.address, archive):
                stats = self.replay(address)
                for key in ("event_log_xxh3", "bytes_read", "zones_loaded", "requests"):
                    self.assertEqual(stats["summary"][key], expected[key], key)
                self.assertEqual(stats["source"]["failed"], 0)
            self.assertEqual(ask(archive, "/world.zcw")[0], 404)
            self.assertEqual(ask(archive, "/packed.3tz")[2], self.archive.read_bytes())

    def test_every_file_of_the_world_is_served_as_it_is_and_nothing_else(self):
        for file in self.world.rglob("*"):
            name = file.relative_to(self.world).as_posix()
            status, headers, body = ask(self.address, f"/{name}")
            if file.is_dir() or name == "bake.cache":
                self.assertEqual(status, 404, name)
                continue
            self.assertEqual((status, body), (200, file.read_bytes()), name)
            self.assertRegex(headers["etag"], r'^"[0-9a-f-]+"$')
            self.assertEqual(headers["accept-ranges"], "bytes")
            self.assertNotIn("content-encoding", headers)
        self.assertEqual(ask(self.address, "//world.zcw")[2], self.index)
        types = {"tileset.json": "application/json", "world.zcw": "application/octet-stream"}
        for name, kind in types.items():
            self.assertEqual(ask(self.address, f"/{name}")[1]["content-type"], kind)
        status, headers, body = ask(self.address, "/world.zcw", headers={"Accept-Encoding": "gzip, br"})
        self.assertEqual((status, body), (200, self.index))

    def test_nothing_outside_the_world_is_served(self):
        (self.folder / "secret.glb").write_text("secret")
        (self.world / "secret.txt").write_text("secret")
        (self.world / "zones" / "secret.glb").write_text("secret")
        self.addCleanup((self.world / "secret.txt").unlink)
        self.addCleanup((self.world / "zones" / "secret.glb").unlink)
        for target in ("/../secret.glb", "/%2e%2e/secret.glb", "/..%2fsecret.glb", "//secret.glb", "/secret.txt", "/.",
                       "/zones/../../secret.glb", "/zones/../world.zcw", "/zones/secret.glb", "/zones", "/zones/", "/",
                       "/bake.cache", "/world.zcw/", "/world.zcw%00", "/%2fetc/passwd", "//etc/passwd", "/zones/0/0_0.glb%00",
                       "/..\\secret.glb", "/zones/0/0_0.glb/../../../secret.glb", "/zones/00000000000000000000/0_0.glb",
                       "/WORLD.ZCW", "/world.zcw.", "http://elsewhere/world.zcw", "*", "world.zcw.."):
            with self.subTest(target):
                status, _, body = ask(self.address, target)
                self.assertIn(status, (400, 404))
                self.assertNotIn(b"secret", body)

    def test_no_link_is_followed_out_of_the_world(self):
        secret = self.folder / "secrets"
        (secret / "1").mkdir(parents=True)
        (secret / "1" / "0_0.glb").write_text("secret")
        world = self.folder / "linked"
        shutil.copytree(self.world, world)
        self.addCleanup(shutil.rmtree, world)
        self.addCleanup(shutil.rmtree, secret)
        (self.folder / "name").symlink_to(world)  # the name of a world may be one
        self.addCleanup((self.folder / "name").unlink)
        with self.serve(self.folder / "name") as address:
            self.assertEqual(ask(address, "/zones/1/0_0.glb")[0], 200)
            (world / "zones" / "1" / "0_0.glb").unlink()
            (world / "zones" / "1" / "0_0.glb").symlink_to(secret / "1" / "0_0.glb")
            (world / "zones" / "9").symlink_to(secret / "1")
            (world / "bake.json").unlink()
            (world / "bake.json").symlink_to("tileset.json")
            for target in ("/zones/1/0_0.glb", "/zones/9/0_0.glb", "/bake.json"):
                status, _, body = ask(address, target)
                self.assertEqual(status, 404, target)
                self.assertNotIn(b"secret", body)
            shutil.move(world / "zones", secret / "zones")
            (world / "zones").symlink_to(secret / "zones")
            self.assertEqual(ask(address, "/zones/0/0_0.glb")[0], 404)
            self.assertEqual(ask(address, "/world.zcw")[2], self.index)
        shutil.move(world / "world.zcw", secret / "world.zcw")
        (world / "world.zcw").symlink_to(secret / "world.zcw")
        self.assert_refused(["serve", world, "--port", "0"], FAILURE, "world.zcw: is a link")

    def test_ranges(self):
        size = len(self.index)
        for text, first, last in (("0-0", 0, 0), ("0-9", 0, 9), ("5-", 5, size - 1), ("-7", size - 7, size - 1),
                                  (f"0-{size - 1}", 0, size - 1), ("10-99999999999", 10, size - 1),
                                  (f"{size - 1}-", size - 1, size - 1), ("-99999999999", 0, size - 1),
                                  ("3-99999999999999999999999", 3, size - 1)):
            with self.subTest(text):
                status, headers, body = ask(self.address, "/world.zcw", headers={"Range": f"bytes={text}"})
                self.assertEqual((status, headers["content-range"]), (206, f"bytes {first}-{last}/{size}"))
                self.assertEqual(body, self.index[first : last + 1])
        for text in (f"{size}-", f"{size}-{size + 5}", "-0", "99999999999999999999999-"):
            status, headers, _ = ask(self.address, "/world.zcw", headers={"Range": f"bytes={text}"})
            self.assertEqual((status, headers["content-range"]), (416, f"bytes */{size}"), text)
        for text in ("bytes=5-2", "bytes=", "bytes=a-b", "bytes=1", "lines=0-1", "bytes=0-1,", "bytes=--1", "x" * 4000,
                     "bytes=" + ",".join(f"{i}-{i}" for i in range(100)), "bytes=0-,0-", "bytes=" + "1" * 4000 + "x-"):
            status, _, body = ask(self.address, "/world.zcw", headers={"Range": text})
            self.assertEqual((status, body), (200, self.index), text[:40])

    def test_several_ranges_at_once(self):
        size = len(self.index)
        status, headers, body = ask(self.address, "/world.zcw", headers={"rAnGe": "bytes=0-3, 100-199,-5"})
        self.assertEqual((status, int(headers["content-length"])), (206, len(body)))
        boundary = re.fullmatch(r"multipart/byteranges; boundary=(\S+)", headers["content-type"])[1].encode()
        parts = body.split(b"--" + boundary)
        self.assertEqual((parts[0], parts[-1], len(parts)), (b"", b"--\r\n", 5))
        for part, (first, last) in zip(parts[1:-1], ((0, 3), (100, 199), (size - 5, size - 1)), strict=True):
            head, data = part.split(b"\r\n\r\n", 1)
            self.assertIn(f"Content-Range: bytes {first}-{last}/{size}".encode(), head)
            self.assertEqual(data, self.index[first : last + 1] + b"\r\n")

    def test_conditions_on_the_version(self):
        etag = ask(self.address, "/world.zcw")[1]["etag"]
        for value, status in ((etag, 304), (f'"x", {etag}', 304), (f"W/{etag}", 304), ("*", 304), ('"x"', 200), ("", 200)):
            found, headers, body = ask(self.address, "/world.zcw", headers={"If-None-Match": value, "Range": "bytes=0-"})
            self.assertEqual(found, 206 if status == 200 else status, value)
            self.assertEqual(headers["etag"], etag)
            self.assertEqual(body == b"", status == 304)
        for value, status in ((etag, 206), ('"x"', 200), (f"W/{etag}", 200), ("Sat, 01 Jan 2000 00:00:00 GMT", 200)):
            headers = {"If-Range": value, "Range": "bytes=2-3"}
            self.assertEqual(ask(self.address, "/world.zcw", headers=headers)[0], status, value)
        report = self.world / "bake.json"
        before = ask(self.address, "/bake.json")[1]["etag"]
        report.write_bytes(report.read_bytes())
        self.assertNotEqual(ask(self.address, "/bake.json")[1]["etag"], before)

    def test_methods(self):
        whole = ask(self.address, "/tileset.json")
        status, headers, body = ask(self.address, "/tileset.json", "HEAD")
        self.assertEqual((status, body), (200, b""))
        self.assertEqual({k: headers[k] for k in ("etag", "content-length", "content-type")},
                         {k: whole[1][k] for k in ("etag", "content-length", "content-type")})
        status, headers, _ = ask(self.address, "/tileset.json", "HEAD", {"Range": "bytes=0-9"})
        self.assertEqual((status, headers["content-length"]), (206, "10"))
        status, headers, _ = ask(self.address, "/world.zcw", "OPTIONS", {
            "Origin": "https://city.example", "Access-Control-Request-Method": "GET",
            "Access-Control-Request-Headers": "range"})
        self.assertEqual((status, headers["access-control-allow-origin"]), (200, "*"))
        self.assertIn("Range", headers["access-control-allow-headers"])
        for method in ("POST", "PUT", "DELETE", "PATCH", "TRACE"):
            status, headers, _ = ask(self.address, "/world.zcw", method, body=b"GET /healthz HTTP/1.1\r\n\r\n")
            self.assertEqual((status, headers["allow"], headers["connection"]), (405, "GET, HEAD, OPTIONS", "close"))
        for status, headers, _ in (whole, ask(self.address, "/none"), ask(self.address, "/world.zcw", "POST")):
            self.assertEqual(headers["access-control-allow-origin"], "*", status)
            self.assertIn("Content-Range", headers["access-control-expose-headers"])

    def test_a_body_is_not_taken_for_a_request(self):
        inner = b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n"
        head = b"GET /none HTTP/1.1\r\nHost: x\r\nContent-Length: %d\r\n\r\n" % len(inner)
        self.assertEqual(raw(self.address, head + inner).count(b"HTTP/1.1 "), 1)
        chunked = b"GET /none HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n"
        self.assertEqual(raw(self.address, chunked + inner).count(b"HTTP/1.1 "), 1)
        last = b"GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n"
        self.assertEqual(raw(self.address, inner + inner + last).count(b"HTTP/1.1 200"), 3, "requests one behind the other")

    def test_what_is_no_request_or_too_large_is_refused(self):
        long_line = b"GET /world.zcw HTTP/1.1\r\nX: " + b"x" * 9000 + b"\r\n\r\n"
        for data, status in ((b"GET /world.zcw HTTP/1.1\r\nX: " + b"x" * 100_000, b"431"), (b"x" * 200_000, b"431"),
                             (b"GET /world.zcw HTTP/1.1\r\n" + b"A: b\r\n" * 10_000 + b"\r\n", b"431"), (long_line, b"400"),
                             (b"GET /" + b"x" * 9000 + b" HTTP/1.1\r\n\r\n", b"414"), (b"nonsense\r\n\r\n", b"400"),
                             (b"GET / HTTP/9\r\n\r\n", b"400"), (b"\0\xff" * 50 + b"\r\n\r\n", b"400")):
            with self.subTest(data[:40]):
                self.assertTrue(raw(self.address, data).startswith(b"HTTP/1.1 " + status))
        self.assertEqual(ask(self.address, "/healthz")[0], 200)

    def test_connections_beyond_the_limit_are_told_to_come_back(self):
        with self.serve(self.world, "--connections", 2) as address:
            place = urllib.parse.urlsplit(address)
            idle = [socket.create_connection((place.hostname, place.port)) for _ in range(2)]
            until = time.monotonic() + 20
            while b"503" not in (answer := raw(address, b"")) and time.monotonic() < until:
                pass  # until both are accepted
            self.assertIn(b"Retry-After: 1", answer)
            for connection in idle:
                connection.close()
            while time.monotonic() < until:
                if ask(address, "/healthz")[0] == 200:
                    break
            self.assertGreaterEqual(metric(address, "zonecast_http_refused_connections_total"), 1)

    def test_lines_that_can_be_read_in_two_ways_are_no_request(self):
        for head in (b"A: b\nRange: bytes=0-9", b"A: b\rRange: bytes=0-9", b"Content-Length : 4", b" A: b", b": b", b"A"):
            with self.subTest(head):
                answer = raw(self.address, b"GET /world.zcw HTTP/1.1\r\nHost: x\r\n" + head + b"\r\n\r\n")
                self.assertTrue(answer.startswith(b"HTTP/1.1 400 "), answer[:80])
                self.assertEqual(answer.count(b"HTTP/1.1"), 1)

    def test_figures(self):
        with self.serve(self.world) as address:
            etag = ask(address, "/world.zcw")[1]["etag"]
            ask(address, "/world.zcw", headers={"If-None-Match": etag})
            ask(address, "/world.zcw", headers={"Range": "bytes=0-9"})
            ask(address, "/none")
            text, ended = "", 0
            while "zonecast_http_in_flight 1\n" not in text:  # an answer counts once its last byte is sent
                text, ended = ask(address, "/metrics")[2].decode(), ended + 1
            for code, count in ((200, ended), (304, 1), (206, 1), (404, 1)):
                self.assertIn(f'zonecast_http_requests_total{{code="{code}"}} {count}\n', text)
            self.assertIn("zonecast_http_cache_hits_total 1\n", text)
            self.assertIn("zonecast_http_in_flight 1\n", text)
            self.assertGreater(metric(address, "zonecast_http_sent_bytes_total"), len(self.index))
            buckets = [int(n) for n in re.findall(r'_bucket\{le="[^"]+"\} (\d+)', text)]
            self.assertEqual(buckets, sorted(buckets))
            self.assertIn(f"zonecast_http_request_duration_seconds_count {buckets[-1]}\n", text)
            for line in text.splitlines():
                self.assertRegex(line, r'^(# (HELP|TYPE) \w+ .+|\w+(\{\w+="[^"]+"\})? [0-9.e+-]+)$')

    def test_many_clients_at_once_get_whole_files(self):
        names = [p.relative_to(self.world).as_posix() for p in self.world.rglob("*.glb")]
        with concurrent.futures.ThreadPoolExecutor(16) as pool:
            for name, (status, _, body) in zip(names, pool.map(lambda n: ask(self.address, f"/{n}"), names)):
                self.assertEqual((status, body), (200, (self.world / name).read_bytes()))

    def test_it_ends_on_a_signal_with_connections_open(self):
        for sign in (signal.SIGINT, signal.SIGTERM):
            words = [support.BINARY, "serve", str(self.world), "--port", "0"]
            with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
                place = urllib.parse.urlsplit(server.stdout.readline().split(" at ")[1].strip())
                with socket.create_connection((place.hostname, place.port)), \
                        socket.create_connection((place.hostname, place.port)) as half:
                    half.sendall(b"GET /world.zcw HT")
                    server.send_signal(sign)
                    self.assertEqual(server.communicate(timeout=20)[1], "")
                self.assertEqual(server.returncode, 0)

    def test_health_tells_when_the_world_is_gone(self):
        moved = self.folder / "moved"
        with self.serve(self.world) as address:
            self.assertEqual(ask(address, "/healthz")[::2], (200, b"ok\n"))
            self.world.rename(moved)
            try:
                self.assertEqual(ask(address, "/healthz")[0], 503)
                self.assertEqual(ask(address, "/world.zcw")[0], 404)
            finally:
                moved.rename(self.world)
            self.assertEqual(ask(address, "/healthz")[0], 200)

    def test_what_cannot_be_served_is_one_line(self):
        (self.folder / "empty").mkdir(exist_ok=True)
        port = urllib.parse.urlsplit(self.address).port
        for arguments, code, *parts in (
                (["serve", self.folder / "none"], FAILURE, "none"),
                (["serve", self.folder / "empty"], FAILURE, "world.zcw"),
                (["serve", self.folder / "city.json"], FAILURE, "city.json"),
                (["serve", self.address], ARGUMENTS, self.address),
                (["serve", self.world, "--port", port], FAILURE, str(port)),
                (["serve", self.world, "--bind", "203.0.113.1"], FAILURE, "203.0.113.1"),
                (["serve", self.world, "--bind", "no.such.host.invalid"], FAILURE, "no such address"),
                (["serve", self.world, "--port", "70000"], ARGUMENTS, "70000"),
                (["serve", self.world, "--listen", "8080"], ARGUMENTS, "ADDR:PORT"),
                (["serve", self.world, "--connections", "0"], ARGUMENTS, "--connections")):
            with self.subTest(arguments=arguments):
                self.assert_refused(arguments, code, *parts)


if __name__ == "__main__":
    support.main()
