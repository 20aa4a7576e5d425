"""Time that the explorer takes to answer a drag.

It is measured in Chromium.

The browser's own input moves each handle 500 times. The handles are target, heading and radius of
one leg, a via point and the final heading of routes with five via points, and a via point of tours
with five. Three times are taken of each move:

* the handler's, with the layout that it causes;
* until the frame is painted, as the page itself sees it;
* the CPU time of the page's thread until the next move, from the browser's trace. Other programs on
  the machine do not enter it, but some 1 ms of the trace and the driver does.

The same moves are made three times. The least of the three is the move's own time, since what else
runs only ever adds; the slowest of these is compared with a frame. Garbage is not collected at the
same move each time, so the longest collection stands beside it.
"""

from __future__ import annotations

import json
import math
import random
import shutil
import tempfile
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.harness import Measurement, absent, sized
from dubins_study.report.page.explorer import write_explorer
from dubins_study.study.arrays import FloatArray

FRAME_MS = 16
TOUR_MS = 4 * FRAME_MS  # with the search for an order
MOVES = sized(125, 6)  # of each handle from each start
REPEATS = sized(3, 1)
_EDGE_PX = 16  # how far the pointer stays from the picture's edge
# A target in the middle, on a circle, far away, and next to the start.
STARTS = ("0,0,30deg,2,1.5,1", "0,0,30deg,1,1,1", "0,0,120deg,-100,20,1", "0,0,10deg,0.02,0.01,1")
# Five via points far apart, 2 R apart, 1 R apart, and in line; the final heading is given.
ROUTES = (
    "0,0,30deg,40,0,1;via=8,5,14,-3,20,6,28,-2,33,7;final=90deg",
    "0,0,0deg,9,0,1;via=2,1,3,3,5,-1,6,2,8,-1;final=-90deg",
    "0,0,60deg,1,1,1;via=0.9,0.2,0.3,1.1,1.4,0.8,0.6,-0.4,1.7,-0.1;final=180deg",
    "0,0,0deg,12,0,1;via=2,0,4,0,6,0,8,0,10,0;final=0deg",
)
TOURS = tuple(f"{route};order=free" for route in ROUTES)
DRAGS = {
    **{"target": STARTS, "heading": STARTS, "radius": STARTS},
    **{"via-3": ROUTES, "final": ROUTES, "via-4": TOURS},
}

_WATCH = """() => {
  const times = window.times = {handler: [], painted: []}, channel = new MessageChannel();
  let begin = 0;
  channel.port1.onmessage = () => times.painted.push(performance.now() - begin);
  addEventListener("pointermove", () => { begin = performance.now(); }, true);
  addEventListener("pointermove", () => {
    document.body.getBoundingClientRect();  // the layout belongs to the answer
    times.handler.push(performance.now() - begin);
    requestAnimationFrame(() => channel.port2.postMessage(0));  // arrives behind layout and paint
  });
}"""


class Times(NamedTuple):
    """Milliseconds of each move and each collection.

    The moves have shape (moves,); the collections are those of garbage.
    """

    handler: FloatArray
    painted: FloatArray
    cpu: FloatArray
    collections: FloatArray


def measure() -> Iterable[Measurement]:
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        yield absent("a drag in the explorer", "needs chromium on PATH")
        return
    with tempfile.TemporaryDirectory() as folder:
        address = write_explorer(Path(folder) / "explorer.html").as_uri()
        for name, repeats in drags(address, program):
            moves = len(repeats[0].painted)
            least = np.min([times.painted for times in repeats], axis=0).max()
            target = TOUR_MS if DRAGS[name] is TOURS else FRAME_MS
            yield Measurement(
                f"explorer: {moves} moves of the {name}, the slowest until it is painted",
                ours=least,
                unit="ms",
                ratio=least,
                target=target,
                note=f"ms: median, 99 %, most. {summary(repeats)}",
            )


def summary(repeats: Sequence[Times]) -> str:
    """Summary of the times of all moves.

    It has the least times of each move, all times as they were, and the longest collection.
    """
    parts = []
    for title, join in (("least", partial(np.min, axis=0)), ("all", np.concatenate)):
        for kind in ("handler", "painted", "cpu"):
            values = join([getattr(times, kind) for times in repeats])
            shown = ", ".join(f"{t:.1f}" for t in (*np.quantile(values, (0.5, 0.99)), values.max()))
            parts.append(f"{title} {kind} {shown}")
    pauses = np.concatenate([times.collections for times in repeats])
    return "; ".join([*parts, f"collections {len(pauses)}, longest {pauses.max(initial=0):.1f}"])


def drags(address: str, program: str) -> Iterator[tuple[str, list[Times]]]:
    """Each handle with the times of its moves.

    The moves are made several times.
    """
    from playwright.sync_api import sync_playwright  # an extra of the tests

    with sync_playwright() as playwright:
        arguments = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
        browser = playwright.chromium.launch(executable_path=program, args=arguments)
        for name, starts in DRAGS.items():
            repeats = []
            for _ in range(REPEATS):
                rows = [
                    _from_start(browser, f"{address}#explore={start}", name) for start in starts
                ]
                repeats.append(Times(*map(np.concatenate, zip(*rows, strict=True))))
            yield name, repeats
        browser.close()


def _from_start(browser: Any, address: str, name: str) -> Times:
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    page.goto(address)
    page.wait_for_timeout(1000)  # what belongs to opening the page is over
    times = _moved(browser, page, name)
    page.close()
    return times


def _moved(browser: Any, page: Any, name: str) -> Times:
    page.locator(".explorer-stage").scroll_into_view_if_needed()
    box = page.locator(".explorer-plane").bounding_box()
    x, y = _middle(page.locator(f".handle.{name} .knob").bounding_box())
    near = page.locator("circle[data-word=RL], .handle.via-2 .touch")
    disc = next(filter(None, (circle.bounding_box() for circle in near.all())))
    page.evaluate(_WATCH)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 1, y)
    page.wait_for_function("times.painted.length >= 2")
    page.evaluate("times.handler.length = times.painted.length = 0")
    browser.start_tracing(page=page, categories=["toplevel", "devtools.timeline"])
    for x, y in _places(box, disc):
        page.mouse.move(x, y)
    page.wait_for_function(f"times.painted.length >= {MOVES}")
    events = json.loads(browser.stop_tracing())["traceEvents"]
    page.mouse.up()
    seen = page.evaluate("times")
    return Times(np.array(seen["handler"]), np.array(seen["painted"]), *_on_thread(events))


def _middle(box: dict[str, float]) -> tuple[float, float]:
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def _places(box: dict[str, float], disc: dict[str, float]) -> Iterator[tuple[float, float]]:
    """Pixels for moves of a handle.

    They lie anywhere in the picture, a little further, and next to a circle. The circle is the
    left turning circle, or of a route one around its second via point.
    """
    chance = random.Random(1)
    cx, cy = _middle(disc)
    r = disc["width"] / 2
    x = y = 0.0
    for move in range(MOVES):
        if move % 3 == 0:
            x = box["x"] + chance.uniform(_EDGE_PX, box["width"] - _EDGE_PX)
            y = box["y"] + chance.uniform(_EDGE_PX, box["height"] - _EDGE_PX)
        elif move % 3 == 1:
            x, y = x + chance.uniform(-9, 9), y + chance.uniform(-9, 9)
        else:
            angle = chance.uniform(0, 2 * math.pi)
            off = chance.uniform(-2, 2)
            x, y = cx + (r + off) * math.cos(angle), cy + (r + off) * math.sin(angle)
        yield x, y


def _on_thread(events: list[dict[str, Any]]) -> tuple[FloatArray, FloatArray]:
    """CPU times (ms) of the page's main thread.

    They are from each move to the next, and of collections.
    """
    moves = [
        event
        for event in events
        if event["name"] == "EventDispatch" and event["args"]["data"]["type"] == "pointermove"
    ]
    thread = moves[0]["pid"], moves[0]["tid"]
    timed = [e for e in events if (e["pid"], e["tid"]) == thread and "tdur" in e]
    tasks: list[dict[str, Any]] = []
    for event in sorted(timed, key=lambda e: (e["ts"], -e["dur"])):
        if not tasks or event["ts"] >= tasks[-1]["ts"] + tasks[-1]["dur"]:
            tasks.append(event)  # no part of the task before it
    starts = [task["ts"] for task in tasks]
    first = [bisect_right(starts, move["ts"]) - 1 for move in moves]
    cpu = np.add.reduceat([task["tdur"] / 1000 for task in tasks], first)
    pauses = [e["tdur"] / 1000 for e in timed if e["name"] in ("MinorGC", "MajorGC")]
    return cpu, np.array(pauses)
