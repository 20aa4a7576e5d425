"use strict";
// window.explorerScene(stage): the plane of the explorer, drawn into an SVG inside the element `stage`.
//
// `fit(scenario, answer)` chooses the part of the plane that is shown, `draw(scenario, answer, side)`
// draws it. For one leg whose final heading is free that is the map of words, known in closed form
// (docs/derivation.md, section 6), and a path of each word: LS to the left of the start's axis and RS
// to its right, but RL inside the left turning circle and LR inside the right one. Otherwise it is the
// path as `explorer-route.js` draws it. A view is {x, y, scale}: the plane's point in the middle, and
// pixels per length unit.
window.explorerScene = (stage) => {
  const {element, set, write} = window.svgElements;
  // Pixels between what is shown and the picture's edge, and with the target's final heading
  const EDGE = 34, WIDE_EDGE = 62;
  const HEADING_ARM = 62, FINAL_ARM = 46; // pixels from start and target to their heading's handles
  const BRANCHES = ["RL", "LR", "RS", "LS"]; // later ones are drawn over earlier ones
  const NEAR_PATH = 14; // pixels; a click nearer to the path means the path
  const FAR = 1e5; // pixels; more than any screen has
  let width = 720, height = 500, view = {x: 0, y: 0, scale: 40};

  const svg = element("svg", {class: "explorer-plane"}, stage);
  const definitions = element("defs", {}, svg);
  for (const [word, [shape, attributes]] of Object.entries({ // regions differ without colours too
    RS: ["circle", {class: "mark", cx: 5, cy: 5, r: 1}],
    RL: ["path", {class: "stripe", d: "M-2 2L2 -2M0 10L10 0M8 12L12 8"}],
    LR: ["path", {class: "stripe", d: "M-2 8L2 12M0 0L10 10M8 -2L12 2"}],
  })) {
    const pattern = {id: `explorer-hatch-${word}`, width: 10, height: 10, patternUnits: "userSpaceOnUse"};
    element(shape, attributes, element("pattern", pattern, definitions));
  }
  const group = (name) => element("g", {class: name}, svg);
  const map = group("explorer-map"), lines = group("explorer-lines"), signs = group("explorer-signs");
  const regions = {
    LS: element("polygon", {class: "word-ls", "data-word": "LS"}, map),
    RS: element("polygon", {class: "word-rs", "data-word": "RS"}, map),
    RL: element("circle", {class: "word-rl", "data-word": "RL"}, map),
    LR: element("circle", {class: "word-lr", "data-word": "LR"}, map),
  };
  const hatches = {};
  for (const [word, region] of Object.entries(regions)) {
    if (word !== "LS") {
      hatches[word] = element(region.tagName, {fill: `url(#explorer-hatch-${word})`, class: "hatch"}, map);
    }
  }
  const axis = element("line", {class: "axis"}, map), behind = element("line", {class: "axis tie"}, map);
  const fronts = [1, -1].map(() => element("path", {class: "front"}, map));
  const regionTexts = {};
  for (const word of Object.keys(regions)) {
    regionTexts[word] = element("text", {class: "region-text"}, signs);
    write(regionTexts[word], word);
  }
  const [aheadText, behindText] = ["S", "LS = RS"].map((word) => {
    const text = element("text", {class: "axis-text"}, signs);
    write(text, word);
    return text;
  });
  const [arm, finalArm] = [0, 1].map(() => element("line", {class: "heading-arm"}, lines));
  const radiusLine = element("line", {class: "radius-line"}, lines);
  const paths = {}, pathTexts = {};
  for (const branch of BRANCHES) {
    paths[branch] = element("path", {class: `path ${branch.toLowerCase()}`}, lines);
  }
  for (const branch of BRANCHES) {
    pathTexts[branch] = element("text", {class: `path-text ${branch.toLowerCase()}`}, signs);
  }
  const radiusText = element("text", {class: "radius-text"}, signs);
  write(radiusText, "R");
  const start = element("circle", {class: "start", r: 4}, lines);

  // Pixels of a point of the plane; y grows upwards there and downwards here.
  const px = (x) => hundredth(width / 2 + (x - view.x) * view.scale);
  const py = (y) => hundredth(height / 2 - (y - view.y) * view.scale);
  const hundredth = (pixels) => Math.round(100 * pixels) / 100;

  // A point of the plane from the vehicle's frame (length unit), and back.
  function outOf({x, y, heading}, forward, left) {
    const cos = Math.cos(heading), sin = Math.sin(heading);
    return {x: x + forward * cos - left * sin, y: y + forward * sin + left * cos};
  }

  function into({x, y, heading}, point) {
    const cos = Math.cos(heading), sin = Math.sin(heading), dx = point.x - x, dy = point.y - y;
    return {forward: dx * cos + dy * sin, left: dy * cos - dx * sin};
  }

  // The radius is dragged at the far side of the circle that the target is farther from.
  const radiusSide = (scenario) => (into(scenario, {x: scenario.target_x, y: scenario.target_y}).left > 0 ? -1 : 1);

  function handlePlaces(scenario, side) {
    const {x, y, heading, target_x, target_y, radius, via, final_heading} = scenario;
    const far = outOf(scenario, 0, 2 * side * radius), at = (u, v) => ({x: px(u), y: py(v)});
    const places = {
      target: at(target_x, target_y), heading: ahead(at(x, y), heading, HEADING_ARM), radius: at(far.x, far.y),
    };
    via.forEach((point, i) => { places[`via-${i + 1}`] = at(...point); });
    if (final_heading !== null) places.final = ahead(places.target, final_heading, FINAL_ARM);
    return places;
  }

  // The pixel at a distance from another, along a heading.
  function ahead({x, y}, heading, distance) {
    return {x: x + distance * Math.cos(heading), y: y - distance * Math.sin(heading)};
  }

  // Choose the view: start, both circles, all points and every path that is drawn are in it.
  function fit(scenario, {drawn}) {
    const points = [{x: scenario.x, y: scenario.y}, {x: scenario.target_x, y: scenario.target_y}];
    for (const [x, y] of scenario.via) points.push({x, y});
    for (const side of [1, -1]) {
      const centre = outOf(scenario, 0, side * scenario.radius);
      for (const [i, j] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
        points.push({x: centre.x + i * scenario.radius, y: centre.y + j * scenario.radius});
      }
    }
    for (const entry of drawn) {
      const line = window.dubins.polyline(entry.start || scenario, entry.curvatures, entry.lengths, 24);
      for (const [x, y] of line) points.push({x, y});
    }
    const xs = points.map((p) => p.x), ys = points.map((p) => p.y);
    const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    const edge = scenario.final_heading === null ? EDGE : WIDE_EDGE;
    const scale = Math.min((width - 2 * edge) / (right - left), (height - 2 * edge) / (high - low));
    view = {x: (left + right) / 2, y: (low + high) / 2, scale};
  }

  // Whether all handles are in view and the circles are neither dots nor larger than the picture.
  function fits(scenario) {
    const places = Object.values(handlePlaces(scenario, radiusSide(scenario)));
    const inside = ({x, y}) => x > 8 && x < width - 8 && y > 8 && y < height - 8;
    return places.every(inside) && view.scale * scenario.radius > 14;
  }

  function resize(newWidth, newHeight) {
    width = newWidth;
    height = newHeight;
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  }

  // An SVG path of arcs and straights; arcs in two halves, so that none is a full circle.
  function outline(scenario, entry) {
    const half = (list) => list.flatMap((value) => [value, value]);
    const poses = window.dubins.poses(scenario, half(entry.curvatures), half(entry.lengths.map((l) => l / 2)));
    const r = scenario.radius * view.scale;
    let text = `M${px(poses[0].x)} ${py(poses[0].y)}`;
    poses.slice(1).forEach(({x, y}, i) => {
      const curvature = entry.curvatures[i >> 1];
      const sweep = curvature > 0 ? 0 : 1;
      text += curvature === 0 ? "L" : `A${r} ${r} 0 0 ${sweep} `; // a half is never above pi
      text += `${px(x)} ${py(y)}`;
    });
    return text;
  }

  function drawMap(scenario, places) {
    const {x, y, heading, radius} = scenario, r = radius * view.scale;
    const cos = Math.cos(heading), sin = Math.sin(heading), sx = px(x), sy = py(y);
    const corner = (forward, left) => `${sx + forward * cos - left * sin},${sy - forward * sin - left * cos}`;
    for (const [word, side] of [["LS", 1], ["RS", -1]]) {
      const points = [corner(-FAR, 0), corner(FAR, 0), corner(FAR, side * FAR), corner(-FAR, side * FAR)];
      for (const part of [regions[word], hatches[word]]) if (part) set(part, {points: points.join(" ")});
    }
    [["RL", 1], ["LR", -1]].forEach(([word, side], i) => {
      const centre = {cx: sx - side * r * sin, cy: sy - side * r * cos, r};
      set(regions[word], centre);
      set(hatches[word], centre);
      const top = outOf(scenario, 0, 2 * side * radius);
      set(fronts[i], {d: `M${sx} ${sy}A${r} ${r} 0 0 ${side > 0 ? 0 : 1} ${px(top.x)} ${py(top.y)}`});
    });
    set(axis, {x1: sx, y1: sy, x2: sx + FAR * cos, y2: sy - FAR * sin});
    set(behind, {x1: sx, y1: sy, x2: sx - FAR * cos, y2: sy + FAR * sin});
    placeRegionTexts(scenario, r, places);
  }

  // Names of the half-planes where the picture reaches farthest into them, of discs and axis near the
  // start; none where a handle is.
  function placeRegionTexts(scenario, r, places) {
    const cos = Math.cos(scenario.heading), sin = Math.sin(scenario.heading);
    const sx = px(scenario.x), sy = py(scenario.y), inset = 30;
    const taken = Object.values(places), free = ([x, y], apart = 48) => taken.every((p) => Math.hypot(p.x - x, p.y - y) > apart);
    const spots = [inset, width / 2, width - inset].flatMap((x) => [22, height / 2, height - 14].map((y) => [x, y]))
      .filter((spot) => free(spot));
    for (const [word, side] of [["LS", 1], ["RS", -1]]) {
      const depth = ([x, y]) => side * (-(y - sy) * cos - (x - sx) * sin);
      const [x, y] = spots.reduce((best, spot) => (depth(spot) > depth(best) ? spot : best));
      set(regionTexts[word], {x, y, visibility: depth([x, y]) > 2 * r + 12 || depth([x, y]) > 60 ? "visible" : "hidden"});
    }
    for (const [word, side] of [["RL", 1], ["LR", -1]]) {
      const inwards = 0.6 * r; // nearer the start than the middle, where the radius is drawn
      set(regionTexts[word], {x: sx - side * inwards * sin, y: sy - side * inwards * cos + 5,
        visibility: r > 34 ? "visible" : "hidden"});
    }
    for (const [text, along] of [[aheadText, HEADING_ARM + 38], [behindText, -64]]) {
      const spot = [sx + along * cos, sy - along * sin];
      set(text, {x: spot[0], y: spot[1] + 4, visibility: free(spot, 30) ? "visible" : "hidden"});
    }
  }

  function drawPaths(scenario, entries, places) {
    const taken = Object.values(places);
    for (const entry of entries) {
      const path = paths[entry.branch], text = pathTexts[entry.branch];
      set(path, {d: entry.exists ? outline(scenario, entry) : ""});
      path.classList.toggle("optimal", entry.optimal);
      text.classList.toggle("optimal", entry.optimal);
      write(text, entry.exists && entry.word ? entry.branch : "");
      if (!entry.exists || !entry.word) continue;
      const place = freePlace(scenario, entry, taken);
      taken.push(place);
      set(text, {x: place.x + 7, y: place.y - 7});
    }
  }

  // A place on a path for its name, away from handles and other names if there is one.
  function freePlace(scenario, entry, taken) {
    const spots = [0.55, 0.45, 0.65, 0.35, 0.75, 0.25].map((share) => {
      const {x, y} = along(entry.start || scenario, entry, share * entry.length);
      return {x: px(x), y: py(y)};
    });
    const room = (spot) => Math.min(...taken.map(({x, y}) => Math.hypot(x - spot.x, y - spot.y)));
    return spots.find((spot) => room(spot) > 36) || spots[0];
  }

  // The point of a path at a distance from its start.
  function along(scenario, entry, distance) {
    let left = distance;
    const lengths = entry.lengths.map((length) => {
      const driven = Math.min(length, left);
      left -= driven;
      return driven;
    });
    return window.dubins.poses(scenario, entry.curvatures, lengths).pop();
  }

  const route = window.explorerRoute(svg, lines, signs);

  function draw(scenario, answer, side) {
    const places = handlePlaces(scenario, side), centre = outOf(scenario, 0, side * scenario.radius);
    svg.classList.toggle("routed", answer.kind !== "point");
    if (answer.kind === "point") {
      drawMap(scenario, places);
      drawPaths(scenario, answer.entries, places);
    } else route.draw(scenario, answer.drawn, {px, py, scale: view.scale, freePlace, taken: Object.values(places)});
    const sx = px(scenario.x), sy = py(scenario.y), {heading, target, final} = places;
    set(start, {cx: sx, cy: sy});
    set(arm, {x1: sx, y1: sy, x2: heading.x, y2: heading.y});
    set(finalArm, {visibility: final ? "visible" : "hidden"});
    if (final) set(finalArm, {x1: target.x, y1: target.y, x2: final.x, y2: final.y});
    const from = {x: px(centre.x), y: py(centre.y)};
    set(radiusLine, {x1: from.x, y1: from.y, x2: places.radius.x, y2: places.radius.y});
    set(radiusText, {x: (from.x + places.radius.x) / 2 + 6, y: (from.y + places.radius.y) / 2 + 4,
      visibility: scenario.radius * view.scale > 60 ? "visible" : "hidden"});
    return places;
  }

  // The leg whose drawn path passes within a few pixels of one; the last leg if none does.
  function legAt(scenario, {drawn}, {x, y}) {
    const distances = drawn.map((entry) => {
      const line = window.dubins.polyline(entry.start || scenario, entry.curvatures, entry.lengths, 60);
      const pixels = line.map(([u, v]) => [px(u) - x, py(v) - y]);
      return Math.min(...pixels.slice(1).map((end, i) => fromOrigin(pixels[i], end)));
    });
    const least = Math.min(...distances);
    return least < NEAR_PATH ? distances.indexOf(least) : drawn.length - 1;
  }

  // Distance of the origin from the line between two points.
  function fromOrigin([x1, y1], [x2, y2]) {
    const dx = x2 - x1, dy = y2 - y1, square = dx * dx + dy * dy;
    const share = square > 0 ? Math.max(0, Math.min(1, -(x1 * dx + y1 * dy) / square)) : 0;
    return Math.hypot(x1 + share * dx, y1 + share * dy);
  }

  // The plane's point under a point of the picture.
  const pointAt = (x, y) => ({x: view.x + (x - width / 2) / view.scale, y: view.y - (y - height / 2) / view.scale});

  return {
    svg, fit, fits, resize, draw, pointAt, legAt, radiusSide, into,
    pixel: () => 1 / view.scale, // length unit
  };
};
