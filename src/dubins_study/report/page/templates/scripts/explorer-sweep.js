"use strict";
// window.explorerSweep(host, choose): below the explorer's plane, every word's length against the
// turning radius, as in the paper's Figures 6.1 to 6.5; bold where a word is the shortest.
//
// `draw(scenario)` draws it, `data()` returns {limit, radii, lengths: {LS: [...], ...}, best: [...]}
// (length unit, null where a word has no path). A click calls `choose(radius)`.
window.explorerSweep = (host, choose) => {
  const NAMESPACE = "http://www.w3.org/2000/svg", SAMPLES = 160, HEIGHT = 190;
  const BRANCHES = ["RL", "LR", "RS", "LS"], MARGIN = {left: 52, right: 34, top: 12, bottom: 34};
  // of two neighbouring lengths, as a share of the largest radius: no word grows faster without a jump
  const JUMP = 0.12;
  let width = 720, limit = 0, top = 1, kept = null;

  function element(name, attributes, parent) {
    const made = document.createElementNS(NAMESPACE, name);
    set(made, attributes);
    return parent.appendChild(made);
  }

  function set(target, attributes) {
    for (const [name, value] of Object.entries(attributes)) target.setAttribute(name, value);
  }

  const svg = element("svg", {class: "explorer-sweep-plot", role: "img", height: HEIGHT}, host);
  const rules = element("g", {class: "rules"}, svg), curves = {}, names = {};
  const now = element("line", {class: "now"}, svg);
  for (const branch of BRANCHES) {
    curves[branch] = {
      thin: element("path", {class: `path ${branch.toLowerCase()}`}, svg),
      bold: element("path", {class: `path optimal ${branch.toLowerCase()}`}, svg),
    };
  }
  for (const branch of BRANCHES) {
    names[branch] = element("text", {class: `path-text ${branch.toLowerCase()}`}, svg);
    names[branch].textContent = branch;
  }
  const dot = element("circle", {class: "start", r: 5}, svg);
  svg.addEventListener("click", (event) => {
    const box = svg.getBoundingClientRect(), share = (event.clientX - box.left) * width / box.width;
    const radius = (share - MARGIN.left) / (width - MARGIN.left - MARGIN.right) * limit;
    if (radius > 0 && radius <= limit) choose(radius);
  });

  const sx = (radius) => MARGIN.left + radius / limit * (width - MARGIN.left - MARGIN.right);
  const sy = (length) => HEIGHT - MARGIN.bottom - length / top * (HEIGHT - MARGIN.top - MARGIN.bottom);

  // A step of 1, 2 or 5 times a power of ten that cuts a range into at most `parts`.
  function stepOf(range, parts) {
    const power = 10 ** Math.floor(Math.log10(range / parts));
    return [1, 2, 5, 10].map((factor) => factor * power).find((step) => range / step <= parts);
  }

  // The radii stay while the scenario's is well inside of them, so that a drag does not move them.
  function chooseLimit(radius) {
    if (radius > 0.12 * limit && radius < 0.93 * limit) return;
    const step = stepOf(2.5 * radius, 5);
    limit = step * Math.ceil(2.5 * radius / step);
  }

  // No lengths at radii that doubles are too coarse for beside so far a target.
  function wordsAt(scenario) {
    try {
      return window.dubins.words(scenario);
    } catch {
      return BRANCHES.map((branch) => ({branch, exists: false}));
    }
  }

  function sample(scenario) {
    const radii = [], lengths = {LS: [], RS: [], LR: [], RL: []}, best = [];
    for (let i = 1; i <= SAMPLES; i += 1) {
      const radius = limit * i / SAMPLES;
      radii.push(radius);
      let shortest = null;
      for (const entry of wordsAt({...scenario, radius})) {
        lengths[entry.branch].push(entry.exists ? entry.length : null);
        if (entry.optimal && !shortest) shortest = entry.branch;
      }
      best.push(shortest);
    }
    return {limit, radii, lengths, best};
  }

  // A line through those samples that `wanted` takes, broken where it takes none and at jumps.
  function line(lengths, wanted) {
    let text = "", before = null;
    lengths.forEach((length, i) => {
      const here = length !== null && wanted(i);
      if (here) {
        const joined = before !== null && Math.abs(length - before) <= JUMP * limit;
        text += `${joined ? "L" : "M"}${sx(kept.radii[i]).toFixed(1)} ${sy(length).toFixed(1)}`;
      }
      before = here ? length : null;
    });
    return text;
  }

  function drawRules() {
    const {number} = window.explorerNumbers, bottom = HEIGHT - MARGIN.bottom, scales = `${width} ${limit} ${top}`;
    if (rules.dataset.scales === scales) return;
    rules.dataset.scales = scales;
    rules.replaceChildren();
    const [stepR, stepL] = [stepOf(limit, width < 500 ? 4 : 8), stepOf(top, 4)];
    for (let i = 0; i * stepR <= limit * 1.0001; i += 1) {
      const x = sx(i * stepR);
      element("line", {x1: x, x2: x, y1: bottom, y2: bottom + 4}, rules);
      element("text", {x, y: bottom + 16, class: "tick middle"}, rules).textContent = number(i * stepR, 4);
    }
    for (let i = 0; i * stepL <= top * 1.0001; i += 1) {
      const y = sy(i * stepL);
      element("line", {x1: MARGIN.left, x2: width - MARGIN.right, y1: y, y2: y}, rules);
      element("text", {x: MARGIN.left - 6, y: y + 4, class: "tick end"}, rules).textContent = number(i * stepL, 4);
    }
    element("text", {x: (MARGIN.left + width - MARGIN.right) / 2, y: HEIGHT - 3, class: "tick middle"}, rules)
      .textContent = "turning radius R";
    const turn = `rotate(-90) translate(${-(HEIGHT - MARGIN.bottom + MARGIN.top) / 2} 12)`;
    element("text", {transform: turn, class: "tick middle"}, rules).textContent = "length";
  }

  function placeNames() {
    const taken = [];
    for (const branch of [...BRANCHES].reverse()) {
      const last = kept.lengths[branch].findLastIndex((length) => length !== null);
      names[branch].setAttribute("visibility", last < 0 ? "hidden" : "visible");
      if (last < 0) continue;
      const x = sx(kept.radii[last]) + 4;
      let y = sy(kept.lengths[branch][last]) + 4;
      const next = y + 13 > HEIGHT - MARGIN.bottom ? -13 : 13;
      while (taken.some(([a, b]) => Math.abs(a - x) < 24 && Math.abs(b - y) < 13)) y += next;
      taken.push([x, y]);
      set(names[branch], {x, y});
    }
  }

  function draw(scenario, entries) {
    width = host.clientWidth || width;
    svg.setAttribute("viewBox", `0 0 ${width} ${HEIGHT}`);
    chooseLimit(scenario.radius);
    kept = sample(scenario);
    const all = Object.values(kept.lengths).flat().concat(entries.map((entry) => entry.length));
    const most = Math.max(limit * 0.01, ...all.filter((length) => length > 0));
    const step = stepOf(most, 4);
    top = step * Math.ceil(most / step);
    drawRules();
    for (const branch of BRANCHES) {
      const lengths = kept.lengths[branch];
      curves[branch].thin.setAttribute("d", line(lengths, () => true));
      curves[branch].bold.setAttribute("d", line(lengths, (i) => kept.best[i] === branch));
    }
    placeNames();
    const best = entries.find((entry) => entry.optimal), x = sx(scenario.radius);
    set(now, {x1: x, x2: x, y1: MARGIN.top, y2: HEIGHT - MARGIN.bottom});
    set(dot, {cx: x, cy: sy(best.length)});
    const {number} = window.explorerNumbers;
    svg.setAttribute("aria-label", `Length of every word's path against the turning radius from 0 to ${number(limit)}; `
      + `at the chosen radius ${number(scenario.radius)} the shortest is ${number(best.length)}`);
  }

  return {draw, data: () => kept};
};
