"use strict";
// window.dubins.pose: the six words of one leg whose final heading is given.
//
// The formulas of study/closed_form/pose.py (docs/derivation.md, section 14), in radii. A word that
// begins with R is one that begins with L, mirrored. tests/browser/test_dubins_script.py compares both.
window.dubins.pose = (() => {
  const EPS = Number.EPSILON, TWO_PI = 2 * Math.PI;
  const RATE = {L: 1, S: 0, R: -1}; // curvature times radius
  const WORDS = ["LSL", "RSR", "LSR", "RSL", "RLR", "LRL"];
  const NEAR_ZERO = 1e-3; // rad; the sign of an angle below this is taken from coordinates, not from it
  // The segments of the word that was computed last. All calls fill this one array: a route
  // computes some ten thousand words in every frame of a drag, and new arrays would have to be
  // collected.
  const driven = new Float64Array(3);

  // How exactly a leg (dx, dy) is known (radii). `extent` is the sum of the absolute values of its
  // four coordinates.
  const uncertainty = (extent, dx, dy) => EPS * (2 * extent + 12 * (Math.abs(dx) + Math.abs(dy)) + 16);

  function total(first, middle, last) {
    driven[0] = first;
    driven[1] = middle;
    driven[2] = last;
    return first + middle + last;
  }

  // The length of a word; its segments are written to `driven`. Infinity if the word has no path,
  // or none that is shorter than `bound`. The end is at (X, Y) in the start's frame; `s` and `c`
  // are the sine and cosine of its heading there.
  function word(X, Y, s, c, index, delta, bound) {
    const mirrored = index === 1 || index === 3 || index === 4;
    const form = index < 2 ? leftStraightLeft : index < 4 ? leftStraightRight : leftRightLeft;
    return form(X, mirrored ? -Y : Y, mirrored ? -s : s, c, delta, bound);
  }

  function leftStraightLeft(X, Y, s, c, delta, bound) {
    const half = 0.5 * delta, x1 = X - s, y1 = Y + (c - 1);
    const x2 = x1 * c + y1 * s, y2 = x1 * s - y1 * c;
    const straight = Math.sqrt(x1 * x1 + y1 * y1);
    if (straight >= bound) return Infinity;
    if (Math.abs(y1) <= half && x1 >= -half) return total(0, Math.max(x1, 0), turn(Math.atan2(s, c), half));
    if (Math.abs(y2) <= half && x2 >= -half) return total(turn(Math.atan2(s, c), half), Math.max(x2, 0), 0);
    const first = onSide(Math.atan2(y1, x1), y1 >= 0), last = onSide(Math.atan2(y2, x2), y2 >= 0);
    return total(first, straight, last);
  }

  function leftStraightRight(X, Y, s, c, delta, bound) {
    const half = 0.5 * delta, x1 = X + s, y1 = Y - (c + 1);
    const x2 = x1 * c + y1 * s, y2 = y1 * c - x1 * s;
    const square = x1 * x1 + (y1 - 2) * (y1 + 2);
    if (square < -2 * delta || square >= bound * bound) return Infinity;
    if (Math.abs(y1 + 2) <= half && x1 >= -half) return total(0, Math.max(x1, 0), turn(Math.atan2(-s, c), half));
    if (Math.abs(y2 + 2) <= half && x2 >= -half) return total(turn(Math.atan2(s, c), half), Math.max(x2, 0), 0);
    const straight = Math.sqrt(Math.max(square, 0));
    const first = Math.atan2(2 * x1 + straight * y1, straight * x1 - 2 * y1);
    const last = Math.atan2(2 * x2 + straight * y2, straight * x2 - 2 * y2);
    return total(onSide(first, x1 >= 0 && y1 >= -2), straight, onSide(last, x2 >= 0 && y2 >= -2));
  }

  function leftRightLeft(X, Y, s, c, delta, bound) {
    const half = 0.5 * delta, x1 = X - s, y1 = Y + (c - 1);
    const x2 = x1 * c + y1 * s, y2 = x1 * s - y1 * c;
    const d = Math.sqrt(x1 * x1 + y1 * y1);
    if (d > 4 + half || TWO_PI - 0.25 * Math.PI * d >= bound) return Infinity; // a chord of the arcsine
    if (d <= half) return total(turn(Math.atan2(s, c), half), TWO_PI, 0); // one circle
    // |C - (0, -1)|^2 - 4 of the last centre C: zero where the first arc vanishes
    const firstEdge = x1 * x1 + y1 * (y1 + 4), lastEdge = x2 * x2 + y2 * (y2 + 4);
    if (Math.abs(firstEdge) <= 2 * delta && x1 <= half) {
      const middle = TWO_PI - Math.atan2(Math.max(-x1, 0), y1 + 2);
      return total(0, middle, turn(principal(Math.atan2(s, c) + middle), half));
    }
    if (Math.abs(lastEdge) <= 2 * delta && x2 <= half) {
      const middle = TWO_PI - Math.atan2(Math.max(-x2, 0), y2 + 2);
      return total(turn(principal(Math.atan2(s, c) + middle), half), middle, 0);
    }
    const halfMiddle = 0.5 * Math.PI + Math.atan2(Math.sqrt(Math.max((4 - d) * (4 + d), 0)), d);
    const first = principal(Math.atan2(y1, x1) + halfMiddle), last = principal(Math.atan2(y2, x2) + halfMiddle);
    return total(onSide(first, firstEdge <= 0 || x1 > 0), 2 * halfMiddle, onSide(last, lastEdge <= 0 || x2 > 0));
  }

  // An angle in (-pi, 3 pi] brought to (-pi, pi].
  const principal = (angle) => (angle <= Math.PI ? angle : angle - TWO_PI);

  // An angle in (-pi, pi] as one in [0, 2 pi). An angle within its uncertainty of zero becomes 0.
  function turn(angle, uncertain) {
    if (Math.abs(angle) <= uncertain) return 0;
    return angle > 0 ? angle : angle + TWO_PI;
  }

  // An angle in (-pi, pi] as one in [0, 2 pi]; next to zero it has the sign that is given.
  function onSide(angle, positive) {
    if (Math.abs(angle) < NEAR_ZERO) return positive ? Math.max(angle, 0) : Math.min(angle, 0) + TWO_PI;
    return angle > 0 ? angle : angle + TWO_PI;
  }

  // The shortest length from (0, 0, a) to (x, y, b), given the sines and cosines of a and b;
  // `bound` if no word is shorter than that.
  function shortest(x, y, sinA, cosA, sinB, cosB, delta, bound = Infinity) {
    const X = x * cosA + y * sinA, Y = y * cosA - x * sinA;
    const s = sinB * cosA - cosB * sinA, c = cosB * cosA + sinB * sinA;
    const tried = x * x + y * y < 16 ? 6 : 4; // three arcs are the shortest only between near points
    let best = bound;
    for (let index = 0; index < tried; index += 1) {
      const length = word(X, Y, s, c, index, delta, best);
      if (length < best) best = length;
    }
    return best;
  }

  // An entry for each of WORDS: its path from pose to pose, with the fields of `dubins.words` and
  // the start. There is no certificate, since the shortest of all six is the shortest path.
  function words(start, end, radius) {
    const x = (end.x - start.x) / radius, y = (end.y - start.y) / radius;
    const extent = (Math.abs(start.x) + Math.abs(start.y) + Math.abs(end.x) + Math.abs(end.y)) / radius;
    const delta = uncertainty(extent, x, y);
    const sinA = Math.sin(start.heading), cosA = Math.cos(start.heading);
    const sinB = Math.sin(end.heading), cosB = Math.cos(end.heading);
    const X = x * cosA + y * sinA, Y = y * cosA - x * sinA;
    const s = sinB * cosA - cosB * sinA, c = cosB * cosA + sinB * sinA;
    const entries = WORDS.map((branch, index) => {
      const length = word(X, Y, s, c, index, delta, Infinity) * radius, exists = length < Infinity;
      const used = exists ? [0, 1, 2].filter((i) => driven[i] > 0) : [];
      const segments = used.map((i) => driven[i]);
      return {
        branch, start, exists, segments, word: used.map((i) => branch[i]).join(""),
        length: exists ? length : NaN,
        curvatures: used.map((i) => RATE[branch[i]] / radius),
        lengths: segments.map((segment) => segment * radius),
      };
    });
    const best = Math.min(...entries.filter((entry) => entry.exists).map((entry) => entry.length));
    // the data allow a length to differ by less than 4 delta: what could be equal ties
    for (const entry of entries) entry.optimal = entry.length <= best + 8 * delta * radius;
    return entries;
  }

  return {shortest, uncertainty, words};
})();
