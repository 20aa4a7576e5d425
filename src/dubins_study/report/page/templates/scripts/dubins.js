"use strict";
// window.dubins: the closed form in the page, for one scenario at a time.
//
// The formulas of study/closed_form/shortest.py and study/body_coordinates.py (docs/derivation.md,
// sections 1 to 6): no reduction modulo 2 pi but for a first arc below zero, no acos, and a target
// within half of delta of a circle, of the axis or of the start is taken to be there.
// tests/browser/test_dubins_script.py compares both.
//
// A scenario is {x, y, heading, target_x, target_y, radius}: heading in rad, counter-clockwise from
// +x, everything else in one length unit. X and Y are the target in the vehicle's frame, in radii:
// X forward, Y to the left.
window.dubins = (() => {
  const EPS = Number.EPSILON, FULL_TURN = 2 * Math.PI;
  const PER_EXTENT = 2 * EPS, PER_DISTANCE = 12 * EPS; // derivation, eq. 6
  const LARGEST_EXTENT = 1e13; // radii; beyond it the circles are lost in rounding
  const RATE = {L: 1, S: 0, R: -1}; // curvature times radius
  const NUMBERS = ["x", "y", "heading", "target_x", "target_y", "radius"];
  const NO_PATH = [NaN, NaN];

  // Why there is no answer to a scenario; "" if there is one.
  function refusal(scenario) {
    for (const name of NUMBERS) {
      const value = scenario[name];
      if (typeof value !== "number" || !Number.isFinite(value)) {
        return `${name} is ${value}; expected a finite number`;
      }
    }
    const {radius} = scenario, extent = extentOf(scenario);
    if (radius <= 0) return `radius is ${radius}; expected a number above 0`;
    return extent > LARGEST_EXTENT * radius
      ? `radius is ${radius}; expected at least ${extent / LARGEST_EXTENT}` : "";
  }

  function extentOf({x, y, target_x, target_y}) {
    return Math.abs(x) + Math.abs(y) + Math.abs(target_x) + Math.abs(target_y);
  }

  function local(scenario) {
    const message = refusal(scenario);
    if (message) throw new RangeError(message);
    const {x, y, heading, target_x, target_y, radius} = scenario, extent = extentOf(scenario);
    const dx = target_x - x, dy = target_y - y;
    const cos = Math.cos(heading), sin = Math.sin(heading);
    const X = (dx * cos + dy * sin) / radius, Y = (dy * cos - dx * sin) / radius;
    const delta = PER_EXTENT * extent / radius + PER_DISTANCE * (Math.abs(X) + Math.abs(Y));
    return {X, Y, delta};
  }

  // 1 - |T - C_L|^2: positive inside the left disc; zero within delta / 2 of its circle.
  function power(X, Y, delta) {
    const w = Y * (2 - Y) - X * X;
    return Math.abs(w) <= delta ? 0 : w;
  }

  // An angle (rad) brought to [0, 2 pi]; one just below zero is a full turn.
  function wrapped(angle) {
    const rest = angle % FULL_TURN;
    return rest < 0 ? rest + FULL_TURN : rest;
  }

  // Arc (rad) and straight (radii) of the shortest LS path; NaN inside the left disc.
  function leftStraight(X, Y, delta) {
    if (Math.abs(Y) <= 0.5 * delta && -0.5 * delta <= X) return [0, 0.5 * delta < X ? X : 0];
    const w = power(X, Y, delta);
    if (w > 0) return NO_PATH;
    const s = Math.sqrt(-w);
    let a;
    if (s === 0) a = Math.atan2(X, 1 - Y); // on the circle: the arc's angle at its centre
    else if (X >= 0) a = 2 * Math.atan2(Y, X + s); // two forms of tan(a / 2), eq. 3,
    else a = 2 * Math.atan2(s - X, Y - 2); // each without cancellation on its side
    return [a >= 0 ? a : a + FULL_TURN, s];
  }

  // Both arcs (rad) of the shortest RL path; NaN unless the target is 1 to 3 radii from C_R.
  function rightLeft(X, Y, delta) {
    const [a, b, otherA, otherB] = rightLeftPair(X, Y, delta);
    return otherA + otherB < a + b ? [otherA, otherB] : [a, b];
  }

  // The arcs of both RL paths, second arc above pi first; equal where the second arc is pi.
  function rightLeftPair(X, Y, delta) {
    if (Math.abs(X) <= 0.5 * delta && Math.abs(Y) <= 0.5 * delta) return [0, FULL_TURN, 0, 0];
    const w = power(X, Y, delta);
    const p = X * X + Y * (Y + 2); // |T - C_R|^2 - 1
    const q = 4 * (2 - Y) + w; // 9 - |T - C_R|^2
    const bearing = Math.atan2(X, 1 + Y); // of T from C_R, from straight up, clockwise
    if (w === 0) { // on the left circle: the arc to T, and the path whose second arc is the rest
      const arc = wrapped(Math.atan2(X, 1 - Y)), rest = FULL_TURN - arc, turn = wrapped(2 * bearing);
      return arc > Math.PI ? [0, arc, turn, rest] : [turn, rest, 0, arc];
    }
    const a = wrapped(bearing);
    if (Math.abs(p) <= delta) return [a, FULL_TURN, a, 0]; // on the right circle
    if (Math.abs(q) <= 3 * delta) return [a, Math.PI, a, Math.PI]; // as far as RL reaches
    if (p < 0 || q < 0) return [NaN, NaN, NaN, NaN];
    const A = p + 4 * Y + 8;
    const D = Math.sqrt(p * q);
    const bend = 2 * Math.atan2(Math.sqrt(p), Math.sqrt(q)); // eq. 4
    let plus, minus;
    if (A > 1) { // the roots of A t^2 - 8 X t - w = 0, t = tan(a1 / 2), in their stable forms
      plus = 2 * (X >= 0 ? Math.atan2(4 * X + D, A) : Math.atan2(w, D - 4 * X));
      minus = 2 * (X < 0 ? Math.atan2(4 * X - D, A) : Math.atan2(-w, D + 4 * X));
    } else { // next to (0, -2) and (0, -4), where A and X vanish
      const between = Math.atan2(D, p + 4);
      plus = bearing + between;
      minus = bearing - between;
    }
    return [wrapped(plus), FULL_TURN - bend, wrapped(minus), bend];
  }

  // The branches whose path is the shortest of all: one, or LS and RS straight behind.
  function optimalBranches({X, Y, delta}) {
    const left = -0.25 * delta <= Y;
    if (power(X, Math.abs(Y), delta) > 0) return [left ? "RL" : "LR"];
    return Math.abs(Y) <= 0.25 * delta ? ["LS", "RS"] : [left ? "LS" : "RS"];
  }

  // Every word's shortest path, in the order LS, RS, LR, RL: {branch, word, exists, length,
  // curvatures, lengths, segments, optimal, certificate}. `branch` is the word that is asked for;
  // `word` leaves out letters of no length ("S" on the axis ahead, "L" on the left circle).
  // `segments` are in radii (for an arc: rad), `length` and `lengths` in the length unit.
  function words(scenario) {
    const target = local(scenario), best = optimalBranches(target);
    const entries = ["LS", "RS", "LR", "RL"].map((branch) => pathOf(scenario, target, branch));
    // where a letter of the best word has no length, another branch may be the same path
    const bestWords = new Set(entries.filter((e) => best.includes(e.branch)).map((e) => e.word));
    for (const entry of entries) entry.optimal = entry.exists && bestWords.has(entry.word);
    return entries;
  }

  function pathOf(scenario, {X, Y, delta}, branch) {
    const side = branch === "RS" || branch === "LR" ? -1 : 1; // RS and LR are LS and RL mirrored
    const both = (branch[1] === "S" ? leftStraight : rightLeft)(X, side * Y, delta);
    const exists = !Number.isNaN(both[0]);
    const driven = exists ? [0, 1].filter((i) => both[i] > 0) : [];
    const word = driven.map((i) => branch[i]).join("");
    const segments = driven.map((i) => both[i]), {radius} = scenario;
    return {
      branch, word, exists, segments,
      length: exists ? (both[0] + both[1]) * radius : NaN,
      curvatures: [...word].map((letter) => RATE[letter] / radius),
      lengths: segments.map((length) => length * radius),
      optimal: false,
      get certificate() { // when it is asked for: it costs more than all the rest
        return exists ? window.dubins.certificate(scenario.heading, word, segments) : null;
      },
    };
  }

  // Only the lengths of the words' shortest paths, {LS, RS, LR, RL} in the length unit (NaN where a
  // word has no path), and the word `best` that is shortest: for many scenarios at once.
  function lengths(scenario) {
    const target = local(scenario), {X, Y, delta} = target, {radius} = scenario;
    const total = ([a, b]) => (a + b) * radius;
    return {
      LS: total(leftStraight(X, Y, delta)), RS: total(leftStraight(X, -Y, delta)),
      LR: total(rightLeft(X, -Y, delta)), RL: total(rightLeft(X, Y, delta)),
      best: optimalBranches(target)[0],
    };
  }

  // The shortest path of all, as an entry of `words`; LS of the two straight behind.
  function shortest(scenario) {
    return words(scenario).find((entry) => entry.optimal);
  }

  // "outside", "circle", "left disc" or "right disc".
  function region(scenario) {
    const {X, Y, delta} = local(scenario);
    const left = power(X, Y, delta), right = power(X, -Y, delta);
    if (left > 0) return "left disc";
    if (right > 0) return "right disc";
    return left === 0 || right === 0 ? "circle" : "outside";
  }

  // Distance from the target to the nearer turning circle, in radii.
  function margin(scenario) {
    const {X, Y} = local(scenario), y = Math.abs(Y);
    return Math.abs(y * (2 - y) - X * X) / (1 + Math.hypot(X, y - 1));
  }

  // Poses {x, y, heading} at the ends of arcs driven one after another; the first is the start.
  // Driven in the start's frame, as study/path.py does (derivation, eq. 2).
  function poses(start, curvatures, lengths) {
    const cos = Math.cos(start.heading), sin = Math.sin(start.heading);
    let turned = 0, forward = 0, left = 0;
    const driven = [{x: start.x, y: start.y, heading: start.heading}];
    curvatures.forEach((curvature, i) => {
      const turn = curvature * lengths[i], half = turn / 2 || 1e-20; // sin(x) / x is 1 there
      const chord = lengths[i] * (Math.sin(half) / half), middle = turned + turn / 2;
      turned += turn;
      forward += chord * Math.cos(middle);
      left += chord * Math.sin(middle);
      driven.push({
        x: start.x + (forward * cos - left * sin),
        y: start.y + (forward * sin + left * cos),
        heading: start.heading + turned,
      });
    });
    return driven;
  }

  // About `points` points [x, y] of a path, closest where it turns; all ends of pieces are points.
  function polyline(start, curvatures, lengths, points = 100) {
    const turns = curvatures.map((curvature, i) => Math.abs(curvature * lengths[i]));
    const all = turns.reduce((sum, turn) => sum + turn, 0) || 1;
    const rates = [], steps = [];
    turns.forEach((turn, i) => {
      const parts = Math.max(1, Math.ceil(points * turn / all));
      for (let part = 0; part < parts; part += 1) {
        rates.push(curvatures[i]);
        steps.push(lengths[i] / parts);
      }
    });
    return poses(start, rates, steps).map(({x, y}) => [x, y]);
  }

  return {words, lengths, shortest, polyline, poses, region, margin, local, refusal, rightLeftPair};
})();
