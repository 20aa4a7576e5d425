"use strict";
// window.dubins.route(scenario): a short path through the via points of a scenario, in order.
//
// A scenario has `via`, a list of points [x, y], and `final_heading` (rad; null: free) beside what
// `dubins.js` says. Returns {headings, entries, length}: the heading at every point, and each leg's
// shortest path as `dubins.pose.words` has it.
//
// A dynamic program over a grid of headings at each point finds a few routes. Further dynamic
// programs improve each of them, over headings ever closer to those of the route. All programs also
// try the headings at which a leg's length jumps. There the leg is two arcs, or one
// (docs/derivation.md, section 16), and the shortest route often has such a leg. Nothing here
// proves that no route is shorter.
// tests/browser/test_dubins_script.py says how often it is the shortest.
window.dubins.route = (() => {
  const {shortest, uncertainty, words} = window.dubins.pose, {rightLeftPair} = window.dubins;
  const GRID = 18, ROUTES = 4; // headings a point, and routes that are improved
  const WIDTH = Math.PI / GRID, NARROW = 0.03, NARROWEST = 1e-6; // rad, between headings that are tried
  const CLOSER = 3, MOVES = 2; // they come closer by this factor, after at most this many moves
  const MOST = 48, MOST_NEAR = 16; // headings at a point: on the grid, and while a route is improved
  const SAME = 1e-6; // headings closer than this part of the distance are one
  const FULL_TURN = 2 * Math.PI;

  // For each point, the headings that are tried, the length of the best route up to each (`cost`,
  // radii), and the place of that route's heading at the point before (`before`). The arrays are
  // kept from call to call: a drag allocates nothing.
  const layers = [];

  function layer(i) {
    const numbers = () => new Float64Array(MOST);
    layers[i] ||= {size: 0, angle: numbers(), sin: numbers(), cos: numbers(), cost: numbers(), before: new Int32Array(MOST)};
    layers[i].size = 0;
    return layers[i];
  }

  function add(headings, angle, apart = 0) {
    const i = headings.size;
    if (i === MOST) return;
    for (let k = 0; k < i; k += 1) if (Math.abs(headings.angle[k] - angle) < apart) return;
    headings.size += 1;
    headings.angle[i] = angle;
    headings.sin[i] = Math.sin(angle);
    headings.cos[i] = Math.cos(angle);
  }

  // The legs in radii, and which headings are free.
  function problemOf({x, y, heading, target_x, target_y, radius, via, final_heading}) {
    const points = [[x, y], ...via, [target_x, target_y]];
    const legs = points.slice(1).map((point, i) => legOf(points[i], point, radius));
    const n = legs.length;
    const given = points.map((_, i) => (i === 0 ? heading : i === n ? final_heading : null));
    return {points, legs, given};
  }

  // A leg between two points, in radii.
  function legOf([x1, y1], [x2, y2], radius) {
    const x = (x2 - x1) / radius, y = (y2 - y1) / radius;
    const extent = (Math.abs(x1) + Math.abs(y1) + Math.abs(x2) + Math.abs(y2)) / radius;
    return {x, y, delta: uncertainty(extent, x, y), arcs: singleArcs(x, y), near: x * x + y * y < 16};
  }

  // Headings [first, last] with which a leg is one arc: two turns, a short and a long way.
  function singleArcs(x, y) {
    const half = Math.asin(Math.hypot(x, y) / 2), chord = Math.atan2(y, x);
    if (Number.isNaN(half)) return [];
    return [half, Math.PI - half, -half, half - Math.PI].map((turn) => [chord - turn, chord + turn]);
  }

  // Headings at (x, y) of paths of two arcs from (0, 0, heading).
  function twoArcs({x, y, delta}, heading) {
    const sin = Math.sin(heading), cos = Math.cos(heading);
    return [1, -1].flatMap((side) => {
      const [a, b, otherA, otherB] = rightLeftPair(x * cos + y * sin, side * (y * cos - x * sin), delta);
      return Number.isNaN(a) ? [] : [heading + side * (b - a), heading + side * (otherB - otherA)];
    });
  }

  // Headings at (0, 0) of paths of two arcs to (x, y, heading): the way back.
  function twoArcsBack({x, y, delta}, heading) {
    return twoArcs({x: -x, y: -y, delta}, heading + Math.PI).map((angle) => angle - Math.PI);
  }

  // Fill `cost` and `before` of the layers, point by point; return the length of the best route. If
  // `lengths` is given, it is filled with each leg's length between every two headings.
  function program(legs, lengths) {
    layers[0].cost.fill(0);
    legs.forEach(({x, y, delta}, i) => {
      const from = layers[i], to = layers[i + 1], straight = Math.hypot(x, y);
      for (let k = 0; k < to.size; k += 1) {
        let least = Infinity, before = 0;
        for (let j = 0; j < from.size; j += 1) {
          if (!lengths && from.cost[j] + straight >= least) continue;
          const bound = lengths ? Infinity : least - from.cost[j];
          const length = shortest(x, y, from.sin[j], from.cos[j], to.sin[k], to.cos[k], delta, bound);
          if (lengths) lengths[i][j * MOST + k] = length;
          if (length < bound && from.cost[j] + length < least) {
            least = from.cost[j] + length;
            before = j;
          }
        }
        to.cost[k] = least;
        to.before[k] = before;
      }
    });
    const {cost, size} = layers[legs.length];
    return Math.min(...cost.subarray(0, size));
  }

  // The headings of the best route to heading `k` of point `i`, from the first point on.
  function traced(i, k) {
    const headings = [layers[i].angle[k]];
    for (let at = i, index = k; at > 0; at -= 1) {
      index = layers[at].before[index];
      headings.unshift(layers[at - 1].angle[index]);
    }
    return headings;
  }

  const tables = [];

  // A few routes on the coarse grid. A route is taken if it is the best through one of a point's
  // headings, and shorter than the best through both neighbours of this heading.
  function coarse({legs, given}) {
    const n = legs.length;
    given.forEach((heading, i) => {
      const headings = layer(i);
      if (heading !== null) {
        add(headings, heading);
        return;
      }
      const angles = Array.from({length: GRID}, (_, j) => (j + 0.5) * FULL_TURN / GRID);
      if (i > 0) angles.push(...legs[i - 1].arcs.map(([, last]) => last));
      if (i < n) angles.push(...legs[i].arcs.map(([first]) => first));
      if (i === 1 && legs[0].near) angles.push(...twoArcs(legs[0], given[0]));
      const inOrder = angles.map((angle) => angle - FULL_TURN * Math.floor(angle / FULL_TURN)).sort((a, b) => a - b);
      for (const angle of inOrder) add(headings, angle);
    });
    while (tables.length < n) tables.push(new Float64Array(MOST * MOST));
    program(legs, tables);
    const routes = new Map();
    let ahead = new Float64Array(layers[n].size), following = Array.from(layers[n].angle.subarray(0, layers[n].size), () => []);
    for (let i = n; i > 0; i -= 1) {
      const {size, cost, angle} = layers[i];
      const through = (k) => cost[(k + size) % size] + ahead[(k + size) % size];
      for (let k = 0; k < size; k += 1) {
        if (through(k) > through(k - 1) || through(k) > through(k + 1)) continue;
        const headings = [...traced(i, k), ...following[k]];
        routes.set(headings.join(), {headings, length: through(k)});
      }
      const before = layers[i - 1].size, costs = new Float64Array(before).fill(Infinity), rest = [];
      for (let j = 0; j < before; j += 1) {
        for (let k = 0; k < size; k += 1) {
          const length = tables[i - 1][j * MOST + k] + ahead[k];
          if (length < costs[j]) {
            costs[j] = length;
            rest[j] = [angle[k], ...following[k]];
          }
        }
      }
      ahead = costs;
      following = rest;
    }
    return [...routes.values()].sort((a, b) => a.length - b.length).slice(0, ROUTES);
  }

  // An improved route. At each point three headings are tried, and those nearby at which a leg is
  // two arcs or one. The three are `width` (rad) apart at first and `narrowest` in the end.
  function improved({legs, given}, route, width, narrowest) {
    const n = legs.length;
    let {headings, length} = route;
    const nearby = (i, angles, within, step) => {
      if (given[i] !== null) return;
      for (const angle of angles) {
        const away = angle - headings[i], turned = away - FULL_TURN * Math.round(away / FULL_TURN);
        if (Math.abs(turned) <= within && layers[i].size < MOST_NEAR) add(layers[i], headings[i] + turned, step * SAME);
      }
    };
    for (let step = width; step > narrowest; step /= CLOSER) {
      for (let move = 0; move < MOVES; move += 1) {
        given.forEach((heading, i) => {
          const tried = layer(i);
          for (const shift of heading === null ? [0, -step, step] : [0]) add(tried, headings[i] + shift);
        });
        const within = 1.5 * step;
        legs.forEach((leg, i) => {
          nearby(i, leg.arcs.map(([first]) => first), within, step);
          nearby(i + 1, leg.arcs.map(([, last]) => last), within, step);
        });
        // from point to point, so that legs in a row may jump together; then back
        for (let i = 0; i < n; i += 1) {
          const {size, angle} = layers[i];
          for (let j = 0; legs[i].near && j < size; j += 1) nearby(i + 1, twoArcs(legs[i], angle[j]), within, step);
        }
        for (let i = n - 1; i >= 0; i -= 1) {
          const {size, angle} = layers[i + 1];
          for (let k = 0; legs[i].near && k < size; k += 1) nearby(i, twoArcsBack(legs[i], angle[k]), within, step);
        }
        const least = program(legs);
        if (!(least < length * (1 - 4 * Number.EPSILON))) break;
        length = least;
        headings = traced(n, layers[n].cost.subarray(0, layers[n].size).indexOf(least));
      }
    }
    return {headings, length};
  }

  const shorter = (a, b) => (b.length < a.length ? b : a);

  function route(scenario) {
    const problem = problemOf(scenario), {points} = problem;
    const best = coarse(problem).map((route) => improved(problem, route, WIDTH, NARROW)).reduce(shorter);
    const {headings} = improved(problem, best, NARROW, NARROWEST);
    const pose = (i) => ({x: points[i][0], y: points[i][1], heading: headings[i]});
    const entries = problem.legs.map((_, i) => words(pose(i), pose(i + 1), scenario.radius).find((entry) => entry.optimal));
    if (scenario.final_heading === null) { // the last leg is known exactly
      const start = pose(entries.length - 1), last = window.dubins.shortest({...scenario, ...start});
      entries.splice(-1, 1, Object.assign(last, {start}));
      headings.splice(-1, 1, last.curvatures.reduce((heading, turn, i) => heading + turn * last.lengths[i], start.heading));
    }
    return {headings, entries, length: entries.reduce((sum, entry) => sum + entry.length, 0)};
  }

  // The length (radii) of the best route near these headings at the via points, roughly.
  function near(scenario, headings) {
    const problem = problemOf(scenario), {given, legs} = problem, last = legs.at(-1);
    const all = [given[0], ...headings, given.at(-1) ?? Math.atan2(last.y, last.x)];
    return improved(problem, {headings: all, length: Infinity}, WIDTH, NARROW).length;
  }

  return Object.assign(route, {near, shorter, legOf, twoArcs, twoArcsBack});
})();
