"use strict";
// window.explorerSweep(host, choose): below the explorer's plane, every word's length against the
// turning radius, as in the paper's Figures 6.1 to 6.5; bold where a word is the shortest.
//
// `resize(width)` sets its width (CSS px) and `draw(scenario, best)` draws it, `best` the length at
// the scenario's own radius; `data()` returns {limit, radii, lengths: {LS: [...], ...}, best: [...]}
// (length unit, null where a word has no path). A click calls `choose(radius)`. The picture is
// drawn anew in every frame of a drag. Arrays are therefore kept from one drawing to the next: the
// browser would collect new ones in the middle of a drag.
window.explorerSweep = (host, choose) => {
  const {element, set, write} = window.svgElements;
  const SAMPLES = 160, HEIGHT = 190;
  const BRANCHES = ["RL", "LR", "RS", "LS"], MARGIN = {left: 60, right: 34, top: 12, bottom: 34};
  const BOTTOM = HEIGHT - MARGIN.bottom; // px, where lengths are zero
  const NAME = {width: 24, height: 18, ascent: 14}; // px, of a word's name with room around it
  // The largest difference of two neighbouring lengths on one line, as a share of the largest
  // radius. No word grows faster; where the difference is larger, its length jumps.
  const JUMP = 0.12;
  let width = 720, limit = 0, top = 0;
  const lengths = {}, places = new Array(SAMPLES), best = new Array(SAMPLES);
  for (const branch of BRANCHES) lengths[branch] = new Float64Array(SAMPLES);

  const svg = element("svg", {class: "explorer-sweep-plot", role: "img", height: HEIGHT}, host);
  const rules = element("g", {class: "rules"}, svg), curves = {}, names = {};
  const now = element("line", {class: "now", y1: MARGIN.top, y2: BOTTOM}, svg);
  for (const branch of BRANCHES) {
    curves[branch] = {
      thin: element("path", {class: `path ${branch.toLowerCase()}`}, svg),
      bold: element("path", {class: `path optimal ${branch.toLowerCase()}`}, svg),
    };
  }
  for (const branch of BRANCHES) {
    names[branch] = element("text", {class: `path-text ${branch.toLowerCase()}`}, svg);
    write(names[branch], branch);
  }
  const dot = element("circle", {class: "start", r: 5}, svg);
  svg.addEventListener("click", (event) => {
    const box = svg.getBoundingClientRect(), share = (event.clientX - box.left) * width / box.width;
    const radius = (share - MARGIN.left) / (width - MARGIN.left - MARGIN.right) * limit;
    if (radius > 0 && radius <= limit) choose(radius);
  });

  const tenth = (pixels) => Math.round(10 * pixels) / 10;
  const sx = (radius) => MARGIN.left + radius / limit * (width - MARGIN.left - MARGIN.right);
  const sy = (length) => BOTTOM - length / top * (BOTTOM - MARGIN.top);
  const radiusAt = (i) => limit * (i + 1) / SAMPLES;

  function resize(newWidth) {
    width = newWidth;
    set(svg, {viewBox: `0 0 ${width} ${HEIGHT}`});
    const step = (width - MARGIN.left - MARGIN.right) / SAMPLES;
    for (let i = 0; i < SAMPLES; i += 1) places[i] = String(tenth(MARGIN.left + (i + 1) * step));
  }

  // A step of 1, 2 or 5 times a power of ten that cuts a range into at most `parts`.
  function stepOf(range, parts) {
    const power = 10 ** Math.floor(Math.log10(range / parts));
    return [1, 2, 5, 10].map((factor) => factor * power).find((step) => range / step <= parts);
  }

  // A scale stays while its values fill it well, so that a drag does not move it.
  function chooseLimit(radius) {
    if (radius > 0.12 * limit && radius < 0.93 * limit) return;
    const step = stepOf(2.5 * radius, 5);
    limit = step * Math.ceil(2.5 * radius / step);
  }

  function chooseTop(most) {
    if (most <= top && most > 0.45 * top) return;
    const step = stepOf(most, 4);
    top = step * Math.ceil(most / step);
  }

  // Fill `lengths` and `best`; return the largest length. A radius has no lengths if the target is
  // so far away that doubles are too coarse.
  function sample(scenario) {
    const there = {...scenario};
    let most = 0;
    for (let i = 0; i < SAMPLES; i += 1) {
      there.radius = radiusAt(i);
      const answer = window.dubins.refusal(there) ? null : window.dubins.lengths(there);
      best[i] = answer ? answer.best : null;
      for (const branch of BRANCHES) {
        const length = lengths[branch][i] = answer ? answer[branch] : NaN;
        if (length > most) most = length;
      }
    }
    return most;
  }

  // The lines of a word: through all its samples, and through those where it is the shortest; broken
  // where it has no path, and at jumps.
  function drawCurve(branch) {
    const values = lengths[branch];
    let thin = "", bold = "";
    for (let i = 0; i < SAMPLES; i += 1) {
      const length = values[i];
      if (Number.isNaN(length)) continue;
      const joined = i > 0 && Math.abs(length - values[i - 1]) <= JUMP * limit; // false beside a NaN
      const point = `${places[i]} ${tenth(sy(length))}`;
      thin += (joined ? "L" : "M") + point;
      if (best[i] === branch) bold += (joined && best[i - 1] === branch ? "L" : "M") + point;
    }
    set(curves[branch].thin, {d: thin});
    set(curves[branch].bold, {d: bold});
  }

  function drawRules() {
    const {brief} = window.explorerNumbers, scales = `${width} ${limit} ${top}`;
    if (rules.dataset.scales === scales) return;
    rules.dataset.scales = scales;
    rules.replaceChildren();
    const [stepR, stepL] = [stepOf(limit, width < 500 ? 4 : 8), stepOf(top, 4)];
    for (let i = 0; i * stepR <= limit * 1.0001; i += 1) {
      const x = sx(i * stepR);
      element("line", {x1: x, x2: x, y1: BOTTOM, y2: BOTTOM + 4}, rules);
      write(element("text", {x, y: BOTTOM + 16, class: "tick middle"}, rules), brief(i * stepR));
    }
    for (let i = 0; i * stepL <= top * 1.0001; i += 1) {
      const y = sy(i * stepL);
      element("line", {x1: MARGIN.left, x2: width - MARGIN.right, y1: y, y2: y}, rules);
      write(element("text", {x: MARGIN.left - 6, y: y + 4, class: "tick end"}, rules), brief(i * stepL));
    }
    const middle = {x: (MARGIN.left + width - MARGIN.right) / 2, y: HEIGHT - 3, class: "tick middle"};
    write(element("text", middle, rules), "turning radius R");
    const turn = `rotate(-90) translate(${-(BOTTOM + MARGIN.top) / 2} 11)`;
    write(element("text", {transform: turn, class: "tick middle"}, rules), "length");
  }

  // Names stand where their lines end, or as near above or below as there is room between the axis
  // and the picture's edge: four names of 18 px fit there in any order.
  function placeNames() {
    const taken = [];
    for (const branch of [...BRANCHES].reverse()) {
      const last = lengths[branch].findLastIndex((length) => !Number.isNaN(length));
      set(names[branch], {visibility: last < 0 ? "hidden" : "visible"});
      if (last < 0) continue;
      const x = Number(places[last]) + 4, end = sy(lengths[branch][last]) + 4;
      const y = freeHeight(taken.filter((place) => Math.abs(place.x - x) < NAME.width), end);
      taken.push({x, y});
      set(names[branch], {x, y: tenth(y)});
    }
  }

  // The height (px, of the base line) next to a wanted one that is clear of others and inside.
  function freeHeight(others, wanted) {
    const low = NAME.ascent, high = BOTTOM - 4;
    const inside = Math.min(high, Math.max(low, wanted));
    const heights = [inside, ...others.flatMap(({y}) => [y - NAME.height, y + NAME.height])];
    const free = heights.filter((y) => y >= low && y <= high
      && others.every((other) => Math.abs(other.y - y) > NAME.height - 0.01)); // rounding
    return free.reduce((next, y) => (Math.abs(y - inside) < Math.abs(next - inside) ? y : next), free[0]);
  }

  function draw(scenario, length) {
    chooseLimit(scenario.radius);
    chooseTop(Math.max(limit * 0.01, sample(scenario), length));
    drawRules();
    BRANCHES.forEach(drawCurve);
    placeNames();
    const x = tenth(sx(scenario.radius));
    set(now, {x1: x, x2: x});
    set(dot, {cx: x, cy: tenth(sy(length))});
    const {number} = window.explorerNumbers;
    set(svg, {"aria-label": `Length of every word's path against the turning radius from 0 to ${number(limit)}; `
      + `at the chosen radius ${number(scenario.radius)} the shortest is ${number(length)}`});
  }

  function data() {
    const listed = (values) => Array.from(values, (length) => (Number.isNaN(length) ? null : length));
    return {
      limit, radii: Array.from(best, (_, i) => radiusAt(i)), best: [...best],
      lengths: Object.fromEntries(BRANCHES.map((branch) => [branch, listed(lengths[branch])])),
    };
  }

  return {draw, resize, data};
};
