"use strict";
// window.dubins.tour(scenario): a short path through the via points of a scenario, in any order.
//
// Takes and returns what `window.dubins.route` does, and {order, given}: the places in `via` in the
// order of the visits, and the length of the route in the order of `via`.
//
// A dynamic program over sets of points lists the best orders on a grid of headings. Each is improved
// from there, and the few shortest are searched as routes are. A leg's length jumps where it is two
// arcs or one, so a cell of the grid has the least length at its middle and at the jumps inside it:
// with the middle alone 36 of 120 tours of dense points are too long, with the jumps 8. Nothing is
// proved; tests/browser/test_dubins_script.py says how often a tour is the shortest.
window.dubins.tour = (() => {
  const {route} = window.dubins, {shortest} = window.dubins.pose;
  const FULL_TURN = 2 * Math.PI;
  const FEW = 6, ORDERS = 24, ROUTES = 3; // orders: improved, at least and at most; then searched
  const SLACK = 3; // radii beyond the best; beyond it only a few orders are improved
  const GRIDS = [18, 12, 8]; // headings a point, so that each has its opposite
  const STEPS = 4e6; // of the program: the grid gets coarser from ten points on
  // These arrays are kept from call to call, so that a drag allocates nothing.
  let ahead = new Float64Array(0), least = new Float64Array(0);

  const withSines = (angles, cell) => ({size: angles.length, angles, sin: angles.map(Math.sin), cos: angles.map(Math.cos), cell});

  function gridOf(points) {
    const pairs = points * (points - 1) * 2 ** (points - 2);
    const size = GRIDS.find((each) => pairs * each * each < STEPS) || GRIDS.at(-1);
    const cell = (angle) => Math.floor((angle / FULL_TURN - Math.floor(angle / FULL_TURN)) * size) % size;
    return withSines(Array.from({length: size}, (_, k) => (k + 0.5) * FULL_TURN / size), cell);
  }

  // A given heading as a grid without cells.
  const givenGrid = (angle) => withSines([angle], () => -1);

  // Lengths of a leg in radii: `table[k * to.size + l]` from heading k to l.
  function tableOf(leg, from, to) {
    const {x, y, delta, arcs, near} = leg, table = new Float64Array(from.size * to.size);
    for (let k = 0; k < from.size; k += 1) {
      for (let l = 0; l < to.size; l += 1) {
        table[k * to.size + l] = shortest(x, y, from.sin[k], from.cos[k], to.sin[l], to.cos[l], delta);
      }
    }
    const lower = (k, l, a, b) => {
      if (k < 0 || l < 0) return;
      const length = shortest(x, y, Math.sin(a), Math.cos(a), Math.sin(b), Math.cos(b), delta);
      table[k * to.size + l] = Math.min(table[k * to.size + l], length);
    };
    for (const [a, b] of arcs) lower(from.cell(a), to.cell(b), a, b);
    if (!near) return table;
    from.angles.forEach((a, k) => { for (const b of route.twoArcs(leg, a)) lower(k, to.cell(b), a, b); });
    to.angles.forEach((b, l) => { for (const a of route.twoArcsBack(leg, b)) lower(from.cell(a), l, a, b); });
    return table;
  }

  // The same leg driven back, at opposite headings.
  function tableBack(table, size) {
    const back = new Float64Array(size * size), opposite = (k) => (k + size / 2) % size;
    for (let k = 0; k < size; k += 1) {
      for (let l = 0; l < size; l += 1) back[opposite(l) * size + opposite(k)] = table[k * size + l];
    }
    return back;
  }

  // Tables of legs: `first[i]` from the start, `between[i][j]`, and `last[i]` to the target, the shortest
  // where its heading is free. `away[i][j]` is straight.
  function tablesOf({x, y, heading, target_x, target_y, radius, via, final_heading}, grid) {
    const legs = via.map((from) => via.map((to) => route.legOf(from, to, radius)));
    const between = via.map(() => []), end = [target_x, target_y];
    via.forEach((_, i) => {
      for (let j = 0; j < i; j += 1) {
        between[i][j] = tableOf(legs[i][j], grid, grid);
        between[j][i] = tableBack(between[i][j], grid.size);
      }
    });
    const toTarget = ([u, v], angle) => {
      const lengths = window.dubins.lengths({x: u, y: v, heading: angle, target_x, target_y, radius});
      return lengths[lengths.best] / radius;
    };
    return {
      between, away: legs.map((row) => row.map((leg) => Math.hypot(leg.x, leg.y))),
      first: via.map((point) => tableOf(route.legOf([x, y], point, radius), givenGrid(heading), grid)),
      last: via.map((point) => (final_heading === null ? grid.angles.map((angle) => toTarget(point, angle))
        : tableOf(route.legOf(point, end, radius), grid, givenGrid(final_heading)))),
    };
  }

  // Fill `ahead[(passed * n + i) * size + k]`: the length of the shortest way on, from point i at
  // heading k, when the points of the set `passed` (i included) are behind. `least` gets the least
  // over the headings.
  function program({between, away, last}, {size}) {
    const n = last.length, all = 2 ** n - 1;
    if (ahead.length < 2 ** n * n * size) ahead = new Float64Array(2 ** n * n * size);
    if (least.length < 2 ** n * n) least = new Float64Array(2 ** n * n);
    const nearest = away.map((row) => row.map((_, j) => j).sort((a, b) => row[a] - row[b]));
    const nexts = new Int32Array(n), bounds = new Float64Array(n); // points that may follow, nearest first
    for (let passed = all; passed > 0; passed -= 1) {
      for (let i = 0; i < n; i += 1) {
        if (!(passed >> i & 1)) continue;
        let follow = 0, lowest = Infinity;
        for (const j of nearest[i]) {
          if (passed >> j & 1) continue;
          nexts[follow] = j;
          bounds[follow] = away[i][j] + least[(passed | 1 << j) * n + j];
          follow += 1;
        }
        const at = (passed * n + i) * size;
        for (let k = 0; k < size; k += 1) {
          let best = passed === all ? last[i][k] : Infinity;
          for (let choice = 0; choice < follow; choice += 1) {
            if (bounds[choice] >= best) continue;
            const j = nexts[choice], table = between[i][j], row = k * size;
            const on = ((passed | 1 << j) * n + j) * size;
            for (let l = 0; l < size; l += 1) {
              const length = table[row + l] + ahead[on + l];
              if (length < best) best = length;
            }
          }
          ahead[at + k] = best;
          if (best < lowest) lowest = best;
        }
        least[passed * n + i] = lowest;
      }
    }
  }

  // The best orders on the grid, shortest first, with their headings.
  function bestOrders({between, first}, {size, angles}) {
    const n = first.length, all = 2 ** n - 1, found = [];

    // The costs of each heading of point j behind point i, and the heading before each.
    function stepTo(j, i, costs) {
      const reached = {j, costs: new Float64Array(size), before: new Int32Array(size)};
      for (let l = 0; l < size; l += 1) {
        let best = Infinity;
        for (let k = 0; k < size; k += 1) {
          const length = costs[k] + between[i][j][k * size + l];
          if (length >= best) continue;
          best = length;
          reached.before[l] = k;
        }
        reached.costs[l] = best;
      }
      return reached;
    }

    const limit = () => Math.min(found[FEW - 1] ? found[0].length + SLACK : Infinity, found[ORDERS - 1]?.length ?? Infinity);

    function extend(passed, steps) {
      const {j: i, costs} = steps.at(-1) || {};
      if (passed === all) {
        keep(steps, costs.map((cost, k) => cost + ahead[(all * n + i) * size + k]));
        return;
      }
      const choices = [];
      for (let j = 0; j < n; j += 1) {
        if (passed >> j & 1) continue;
        const step = steps.length ? stepTo(j, i, costs) : {j, costs: first[j], before: null};
        const on = ((passed | 1 << j) * n + j) * size;
        choices.push({step, bound: Math.min(...step.costs.map((cost, l) => cost + ahead[on + l]))});
      }
      choices.sort((a, b) => a.bound - b.bound);
      for (const {step, bound} of choices) {
        if (bound < limit()) extend(passed | 1 << step.j, [...steps, step]);
      }
    }

    function keep(steps, lengths) {
      const length = Math.min(...lengths), headings = [];
      let k = lengths.indexOf(length);
      for (const {before} of steps.toReversed()) {
        headings.unshift(angles[k]);
        k = before && before[k];
      }
      found.push({order: steps.map(({j}) => j), headings, length});
      found.sort((a, b) => a.length - b.length);
      while (found.length > FEW && (found.length > ORDERS || found.at(-1).length > limit())) found.pop();
    }

    extend(0, []);
    return found;
  }

  return (scenario) => {
    const {via} = scenario, grid = gridOf(via.length), tables = tablesOf(scenario, grid);
    const inOrder = (order) => ({...scenario, via: order.map((i) => via[i])});
    program(tables, grid);
    const improved = bestOrders(tables, grid)
      .map(({order, headings}) => ({order, length: route.near(inOrder(order), headings)}))
      .sort((a, b) => a.length - b.length).slice(0, ROUTES);
    const given = {order: via.map((_, i) => i), ...route(scenario)};
    const tours = improved.filter(({length}) => length < improved[0].length + SLACK)
      .map(({order}) => ({order, ...route(inOrder(order))}));
    return {...tours.reduce(route.shorter, given), given: given.length};
  };
})();
