# SPDX-License-Identifier: Apache-2.0
"""A web server for tests: a folder with ETags, ranges and conditional requests, and, where a test asks for them, faults.

A fault is a word, or a status, that `server.fault(path)` gives for a request, from several threads at once:
  short      the connection closes in the middle of the body
  truncated  a shorter body, announced as such
  flipped    a bit of the body is another
  stall      silence in the middle of the body
  reset      the connection is reset instead of an answer
  range      another range than asked for
  whole      status 200 and all bytes, whatever the range
  long       far more bytes than there are, without a length
  packed     the body as it is, called gzip
  headers    headers without end
  loop       a redirection to itself
  NUMBER     that status, for which `retry_after` seconds are told when it is not None
"""
import email.utils
import hashlib
import http.server
import pathlib
import re
import socket
import struct
import threading
import time


class WebServer:
    def __init__(self, root):
        self.root = pathlib.Path(root)
        self.fault = lambda path: None
        self.retry_after = None
        self.etags = True
        self.requests = []  # (method, path, headers as a dict in lower case)
        self.stop_stalls = threading.Event()
        self.lock = threading.Lock()
        self.connections = set()
        self.port = 0
        self.start()

    def start(self):
        """Begins to listen: at the port it had before, if it had one."""
        owner = self

        class Handler(FaultyHandler):
            server_of_tests = owner

        class Server(http.server.ThreadingHTTPServer):
            allow_reuse_address = True
            daemon_threads = True
            request_queue_size = 64

            def handle_error(self, request, client_address):
                pass  # clients that give up are no news

        self.server = Server(("127.0.0.1", self.port), Handler)
        self.port = self.server.server_address[1]
        self.stop_stalls.clear()
        self.thread = threading.Thread(target=self.server.serve_forever, args=(0.02,), daemon=True)
        self.thread.start()

    def stop(self):
        """As if it died: connections go with it."""
        self.stop_stalls.set()
        self.server.shutdown()
        self.server.server_close()
        with self.lock:
            for connection in self.connections:
                reset(connection)
            self.connections.clear()
        self.thread.join()

    def url(self, name=""):
        return f"http://127.0.0.1:{self.port}/{name}"


def reset(connection):
    try:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        connection.shutdown(socket.SHUT_RD)
        connection.close()
    except OSError:
        pass


class FaultyHandler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True
    wbufsize = 1 << 16
    server_of_tests = None

    def setup(self):
        super().setup()
        with self.server_of_tests.lock:
            self.server_of_tests.connections.add(self.connection)

    def finish(self):
        with self.server_of_tests.lock:
            self.server_of_tests.connections.discard(self.connection)
        try:
            super().finish()
        except OSError:
            pass

    def log_message(self, *arguments):
        pass

    def do_HEAD(self):
        self.answer(False)

    def do_GET(self):
        self.answer(True)

    def answer(self, with_body):
        site = self.server_of_tests
        path = self.path.split("?")[0]
        headers = {key.lower(): value for key, value in self.headers.items()}
        with site.lock:
            site.requests.append((self.command, path, headers))
        fault = site.fault(path)
        if fault == "reset":
            self.close_connection = True
            return reset(self.connection)
        if fault == "loop":
            return self.send_whole(302, {"Location": path}, b"", with_body)
        if fault == "headers":
            self.send_response(200)
            try:
                for i in range(100000):
                    self.wfile.write(b"X-More: " + str(i).encode() + b"x" * 900 + b"\r\n")
            except OSError:
                self.close_connection = True
            return None
        if isinstance(fault, int):
            extra = {} if site.retry_after is None else {"Retry-After": str(site.retry_after)}
            return self.send_whole(fault, extra, b"an error, in words of the server's own", with_body)
        file = site.root / path.lstrip("/")
        if ".." in path or not file.is_file():
            return self.send_whole(404, {}, b"nothing here", with_body)
        return self.send_file(file, headers, fault, with_body)

    def send_file(self, file, headers, fault, with_body):
        body = file.read_bytes()
        extra = {"Last-Modified": email.utils.formatdate(file.stat().st_mtime, usegmt=True)}
        etag = f'"{hashlib.sha256(body).hexdigest()[:24]}"'
        if self.server_of_tests.etags:
            extra["ETag"] = etag
            if headers.get("if-none-match") == etag:
                return self.send_whole(304, extra, b"", False)
        status = 200
        wanted = re.fullmatch(r"bytes=(\d*)-(\d*)", headers.get("range", ""))
        if wanted and headers.get("if-range", etag) == etag and fault != "whole":
            first = int(wanted[1]) if wanted[1] else max(0, len(body) - int(wanted[2]))
            last = min(len(body) - 1, int(wanted[2]) if wanted[1] and wanted[2] else len(body) - 1)
            if first >= len(body):
                return self.send_whole(416, {"Content-Range": f"bytes */{len(body)}"}, b"", with_body)
            status = 206
            told = first + (7 if fault == "range" else 0)
            extra["Content-Range"] = f"bytes {told}-{last}/{len(body)}"
            body = body[first : last + 1]
        if fault == "flipped":
            middle = len(body) // 2
            body = body[:middle] + bytes([body[middle] ^ 4]) + body[middle + 1 :]
        if fault == "truncated":
            body = body[: len(body) // 2]
        if fault == "packed":
            extra["Content-Encoding"] = "gzip"
        if fault in ("short", "stall"):
            return self.send_half(status, extra, body, fault)
        if fault == "long":
            return self.send_endless(status, extra, body)
        return self.send_whole(status, extra, body, with_body)

    def send_whole(self, status, extra, body, with_body):
        self.send_response(status)
        for key, value in extra.items():
            self.send_header(key, value)
        if status != 304:
            self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if with_body:
            self.wfile.write(body)

    def send_half(self, status, extra, body, fault):
        self.send_response(status)
        for key, value in extra.items():
            self.send_header(key, value)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body[: len(body) // 2])
        self.wfile.flush()
        if fault == "stall":
            self.server_of_tests.stop_stalls.wait(30)
        self.close_connection = True

    def send_endless(self, status, extra, body):
        self.send_response(status)
        for key, value in extra.items():
            self.send_header(key, value)
        self.send_header("Connection", "close")
        self.end_headers()
        self.close_connection = True
        try:
            self.wfile.write(body)
            until = time.monotonic() + 5
            while time.monotonic() < until:
                self.wfile.write(b"x" * 65536)
        except OSError:
            pass
