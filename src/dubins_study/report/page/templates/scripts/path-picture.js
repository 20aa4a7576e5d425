"use strict";
// A drawing of one path beside the reference, as SVG: the start with its heading, via points, the
// target with its heading if that is given, both turning circles of the start, the solver's path
// solid and the reference dashed, and a scale bar.
(() => {
  const SVG = "http://www.w3.org/2000/svg";

  function shape(name, attributes, ...children) {
    const node = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    node.append(...children);
    return node;
  }

  // The points of the reference path; null if none is known or the question cannot be drawn. For
  // one leg with a free final heading the page computes the path; else it takes that of a right
  // attempt.
  function reference(data, i) {
    const scenario = data.scenario(i), branch = data.text("branch", i), route = data.route(i);
    const searched = route.via_x.length || data.ofScenario("heading", i) === null;
    if (searched || route.final_heading !== null) return data.rightPath(i);
    try {
      const path = branch === "best" ? window.dubins.shortest(scenario)
        : window.dubins.words(scenario).find((entry) => entry.branch === branch);
      if (!path || !path.exists) return null;
      return window.dubins.polyline(scenario, path.curvatures, path.lengths, 120);
    } catch {
      return null; // a radius that is tiny beside the distances
    }
  }

  // Centres of the circles on the left and on the right of the start.
  function centres({x, y, heading, radius}) {
    return [1, -1].map((side) => [
      x - side * radius * Math.sin(heading), y + side * radius * Math.cos(heading)]);
  }

  // The box [left, bottom, right, top] that is drawn, with room around it. A path that leads far
  // away is cut: start, points, target and reference stay large enough to be seen.
  function box(scenario, points, lines) {
    const {x, y, target_x, target_y, radius} = scenario;
    const near = [[x, y], ...points, [target_x, target_y], ...(lines[1] || [])];
    for (const [cx, cy] of centres(scenario)) {
      near.push([cx - radius, cy - radius], [cx + radius, cy + radius]);
    }
    const least = bounds(near), all = bounds([...near, ...(lines[0] || [])]);
    const span = Math.max(least[2] - least[0], least[3] - least[1]);
    const room = 0.06 * span, most = 2.5 * span;
    return [
      Math.max(all[0], least[0] - most) - room, Math.max(all[1], least[1] - most) - room,
      Math.min(all[2], least[2] + most) + room, Math.min(all[3], least[3] + most) + room];
  }

  function bounds(points) {
    const xs = points.map((p) => p[0]), ys = points.map((p) => p[1]);
    return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
  }

  // 1, 2 or 5 times a power of ten, at most `length`.
  function round(length) {
    const power = 10 ** Math.floor(Math.log10(length));
    return [5, 2, 1].find((factor) => factor * power <= length) * power;
  }

  // The drawing of a row, `width` by at most `height` CSS pixels; labels only in large drawings.
  function picture(data, i, {width, height, labels}) {
    const scenario = data.scenario(i), {via_x, via_y, final_heading} = data.route(i);
    const points = via_x.map((x, k) => [x, via_y[k]]);
    const lines = [data.path(i), reference(data, i)];
    const [left, bottom, right, top] = box(scenario, points, lines);
    const spare = labels ? 26 : 4; // pixels below the drawing, for the scale bar
    const scale = Math.min(width / (right - left), (height - spare) / (top - bottom));
    const size = [width, labels ? Math.max((top - bottom) * scale, 140) + spare : height];
    const shift = [(size[0] - (right - left) * scale) / 2, (size[1] - spare - (top - bottom) * scale) / 2];
    const at = (x, y) => [shift[0] + (x - left) * scale, shift[1] + (top - y) * scale];
    const text = summary(data, i, lines);
    const svg = shape("svg", {viewBox: `0 0 ${size[0].toFixed(1)} ${size[1].toFixed(1)}`, role: "img",
      "aria-label": text, class: "path-picture"});
    for (const [cx, cy] of centres(scenario)) {
      const [px, py] = at(cx, cy);
      svg.append(shape("circle", {cx: px, cy: py, r: scenario.radius * scale, class: "turning"}));
    }
    const names = ["solver", "reference"];
    lines.forEach((line, k) => {
      if (line) svg.append(shape("polyline", {points: line.map(([x, y]) => at(x, y).map(tidy)).join(" "),
        class: names[k]}));
    });
    svg.append(...marks(scenario, points, final_heading, at));
    if (labels) svg.append(...writing(scenario, lines, at, {scale, size}));
    return svg;
  }

  function tidy(value) {
    return Math.max(-1e5, Math.min(1e5, value)).toFixed(1);
  }

  // The start as an arrow along its heading, via points as dots, the target as a ring with a dot, and
  // an arrow if its heading is given.
  function marks(scenario, points, final_heading, at) {
    const [tx, ty] = at(scenario.target_x, scenario.target_y);
    const turned = (x, y, heading) => ({
      transform: `translate(${at(x, y).map(tidy).join(" ")}) rotate(${(-heading * 180 / Math.PI).toFixed(2)})`});
    const arrow = final_heading === null ? [] : [shape("path", {d: "M 6 0 H 20 M 15 -4 L 20 0 L 15 4",
      class: "target", ...turned(scenario.target_x, scenario.target_y, final_heading)})];
    const dots = points.map((point) => at(...point).map(tidy));
    return [
      ...dots.map(([cx, cy]) => shape("circle", {cx, cy, r: 2.4, class: "via"})), ...arrow,
      shape("path", {d: "M 13 0 L -5 -6 L -2 0 L -5 6 Z", class: "start",
        ...turned(scenario.x, scenario.y, scenario.heading)}),
      ...(scenario.has_target ? [shape("circle", {cx: tidy(tx), cy: tidy(ty), r: 6, class: "target"}),
        shape("circle", {cx: tidy(tx), cy: tidy(ty), r: 1.8, class: "start"})] : []),
    ];
  }

  // Names of the start and of the target, each away from the paths, and the scale bar.
  function writing(scenario, lines, at, {scale, size}) {
    const heading = [Math.cos(scenario.heading), -Math.sin(scenario.heading)];
    const start = at(scenario.x, scenario.y), target = at(scenario.target_x, scenario.target_y);
    const line = (lines[1] || lines[0] || []).map((point) => at(...point));
    const before = line.findLast((point) => distance(point, target) > 12) || start;
    const arriving = [target[0] - before[0], target[1] - before[1]];
    const taken = []; // boxes of names: the second keeps clear of the first
    const unit = round(size[0] / 4 / scale / scenario.radius) * scenario.radius, y = size[1] - 8;
    return [
      label(start, heading.map((part) => -part), "start", size, taken),
      ...(scenario.has_target ? [label(target, arriving, "target", size, taken)] : []),
      shape("path", {d: `M 4 ${y - 4} V ${y} H ${tidy(4 + unit * scale)} V ${y - 4}`, class: "scale"}),
      named(8 + unit * scale, y, `${window.attempts.number(unit / scenario.radius, 1)} R`)];
  }

  function distance(a, b) {
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  }

  function named(x, y, text) {
    return shape("text", {x: tidy(x), y: tidy(y)}, text);
  }

  // A name beside a place: in a direction (y down), else where it fits.
  function label(place, direction, text, [width, height], taken) {
    const wide = 6.6 * text.length; // pixels, a little more than the letters take
    const bearing = Math.atan2(direction[1], direction[0]);
    const around = [0, 90, -90, 125, -125, 180].map((degrees) => {
      const angle = bearing + degrees * Math.PI / 180;
      return [Math.cos(angle), Math.sin(angle)];
    });
    const boxes = around.map(([right, down]) => {
      const x = place[0] + 12 * right + (right > 0.4 ? 0 : right < -0.4 ? -wide : -wide / 2);
      const y = place[1] + 16 * down;
      return [x, y - 7, x + wide, y + 7];
    });
    const fits = ([x0, y0, x1, y1]) => x0 > 0 && y0 > 0 && x1 < width && y1 < height - 26
      && taken.every((other) => x1 < other[0] || x0 > other[2] || y1 < other[1] || y0 > other[3]);
    const box = boxes.find(fits) || boxes[0];
    taken.push(box);
    const node = named((box[0] + box[2]) / 2, box[1] + 11, text);
    node.setAttribute("text-anchor", "middle");
    return node;
  }

  // What the drawing shows, for readers who do not see it.
  function summary(data, i, lines) {
    const word = data.text("word", i);
    const path = lines[0] ? `a path ${word ? `of word ${word}` : "without turns or straights"}`
      : "no path that can be drawn";
    const compared = lines[1] ? "beside the reference" : "and no reference exists";
    return `The solver's answer, ${path}, ${compared}`;
  }

  Object.assign(window.attempts, {picture});
})();
