"""A run while it goes on, as a page for a browser on the same machine: `python3 -m dovetail watch RESULTS.h5 --page`."""

import io
import json
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Lock

from .results import Results
from .saved_picture import save_picture
from .watch import PAUSE, SHARE, head_of, is_running, shares_of

HOSTS = ("127.0.0.1", "localhost")  # by which the page may be asked for: other names are those of strangers' pages
PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>dovetail watch</title>
<link rel="icon" href="data:,">
<style>
body { font: 16px sans-serif; max-width: 60em; height: calc(100vh - 2em); margin: 1em auto; padding: 0 1em; color: #000;
  background: #fff; display: flex; flex-direction: column }
h1 { margin: 0 } progress { width: 100% } img { width: 100%; flex: 1; min-height: 20em; object-fit: contain }
[hidden] { display: none } pre { font: inherit; white-space: pre-wrap; margin: .5em 0 }
</style></head><body>
<h1 id="title"></h1><pre id="state">no answer yet</pre><progress id="done" max="1" value="0"></progress>
<pre id="shares"></pre><img id="curve" alt="the curve so far" hidden>
<script>
"use strict";
let drawn = "", waiting = false;  // for a picture: asking for the next one would call it off
const put = (name, text) => { document.getElementById(name).textContent = text; };
async function look() {
  let wait = 1000;
  try {
    const answer = await fetch("state.json");
    if (!answer.ok) throw new Error(await answer.text());
    const found = await answer.json();
    put("title", found.title); put("state", found.state); put("shares", found.shares);
    document.title = found.title;
    const done = document.getElementById("done");
    done.value = found.done; done.hidden = !found.running;
    if (found.points && found.drawn !== drawn && !waiting) {
      const curve = document.getElementById("curve");
      curve.onload = () => { curve.hidden = waiting = false; };
      curve.onerror = () => { curve.hidden = true; waiting = false; drawn = ""; };
      curve.src = "curve.svg?" + encodeURIComponent(found.drawn);
      drawn = found.drawn; waiting = true;
    }
    if (!found.running) wait = 5000;
  } catch (error) { put("state", error instanceof TypeError ? "dovetail watch has ended" : error.message); wait = 5000; }
  setTimeout(look, wait);
}
look();
</script></body></html>
"""


class Page:
    """What is served of a results file `path`; `dof`, `model` as for `watch`."""

    def __init__(self, path, dof=None, model=None):
        self.path, self.dof, self.model = path, dof, model
        self._drawing, self._drawn, self._picture, self._next = Lock(), None, b"", 0.0

    def state(self):
        """What the page shows besides the curve, as JSON."""
        running = is_running(self.path.parent)
        results, title, lines, status = head_of(self.path, running, self.model)
        points = 0 if results is None else len(results)
        drawn = f"{points} {running}" if not running or time.monotonic() > self._next else self._drawn
        return json.dumps({"title": title, "state": "\n".join(lines), "running": running, "points": points,
                           "done": status.get("done", 0.0), "drawn": drawn,
                           "shares": f"contact points at the last point: {shares_of(results)}" if points else "no point yet"})

    def picture(self):
        """The curve as SVG; one at a time, as pyplot wants, and the less often the longer it takes."""
        from .plot import response

        with self._drawing:
            began, running, results = time.monotonic(), is_running(self.path.parent), Results(self.path, self.model)
            results.need_points()
            drawn = f"{len(results)} {running}"
            if drawn != self._drawn and (not running or began > self._next):
                figure, file = response(results, [self.dof] if self.dof else None), io.BytesIO()
                save_picture(figure, file, format="svg")
                self._drawn, self._picture = drawn, file.getvalue()
                self._next = time.monotonic() + max(PAUSE, SHARE * (time.monotonic() - began))
            return self._picture

    def answer(self, target):
        """Media type and content of what is asked for, or None."""
        name = target.partition("?")[0]
        if name == "/":
            return "text/html; charset=utf-8", PAGE.encode()
        if name == "/state.json":
            return "application/json", self.state().encode()
        if name == "/curve.svg":
            return "image/svg+xml", self.picture()
        return None


def server_of(page, port=0):
    """A server of a Page on this machine alone; port 0: any that is free."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            if self.headers.get("Host", "").partition(":")[0] not in HOSTS:
                return self.send_error(403)
            try:
                found = page.answer(self.path)
            except (ValueError, KeyError, OSError) as error:  # as of a run that begins anew
                return self.send(503, "text/plain; charset=utf-8", str(error).encode())
            if found is None:
                return self.send_error(404)
            self.send(200, *found)

        def send(self, status, kind, content):
            self.send_response(status)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(content)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, *_):
            pass

    return ThreadingHTTPServer((HOSTS[0], port), Handler)


def serve(page, port):
    """Until Ctrl-C."""
    try:
        server = server_of(page, port)
    except (OSError, OverflowError) as error:
        raise ValueError(f"--page {port}: no page can be served there: {error}") from None
    with server:
        print(f"http://{HOSTS[0]}:{server.server_port}/ shows {page.path}; Ctrl-C ends it", flush=True)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            print()
