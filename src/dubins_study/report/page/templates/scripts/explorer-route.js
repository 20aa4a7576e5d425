"use strict";
// window.explorerRoute(svg, lines, signs): one path in the explorer's plane, by its turns.
//
// `draw(scenario, entries, plane)` draws legs one after another: left turns, straights and right turns
// differ in colour, width and dashes, faint circles are those of the start and those that the path drives on, and each leg has
// its word beside it. `plane` is {px, py, scale, freePlace, taken}: pixels of a point, pixels per length
// unit, and how a place for a word is found, away from the places that are taken.
window.explorerRoute = (svg, lines, signs) => {
  const {element, set, write} = window.svgElements;
  const SMALL_TURN = 0.1; // rad; the circle of an arc up to it is not drawn
  const group = element("g", {class: "explorer-route"}, svg);
  lines.before(group); // below the handles' arms
  const circles = element("path", {class: "driven-circle"}, group);
  const pieces = {};
  for (const letter of ["S", "L", "R"]) pieces[letter] = element("path", {class: `turn turn-${letter.toLowerCase()}`}, group);
  const texts = [];

  function draw(scenario, entries, {px, py, scale, freePlace, taken}) {
    const r = scenario.radius * scale, drawn = {L: "", S: "", R: "", circles: ""};
    const circle = ({x, y, heading}, radius) => { // on the left, or of a negative radius on the right
      const cx = px(x - Math.sin(heading) * radius), cy = py(y + Math.cos(heading) * radius);
      drawn.circles += `M${cx - r} ${cy}a${r} ${r} 0 0 0 ${2 * r} 0a${r} ${r} 0 0 0 ${-2 * r} 0`;
    };
    circle(scenario, scenario.radius);
    circle(scenario, -scenario.radius);
    for (const {start, curvatures, lengths} of entries) {
      // in halves, so that no arc is a full circle
      const halves = (list) => list.flatMap((value) => [value, value]);
      const poses = window.dubins.poses(start, halves(curvatures), halves(lengths.map((length) => length / 2)));
      curvatures.forEach((curvature, i) => {
        const letter = curvature === 0 ? "S" : curvature > 0 ? "L" : "R";
        const [from, middle, end] = poses.slice(2 * i, 2 * i + 3).map(({x, y}) => `${px(x)} ${py(y)}`);
        const to = curvature === 0 ? "L" : `A${r} ${r} 0 0 ${curvature > 0 ? 0 : 1} `;
        drawn[letter] += `M${from}${to}${middle}${to}${end}`;
        if (Math.abs(curvature) * lengths[i] > SMALL_TURN) circle(poses[2 * i], 1 / curvature);
      });
    }
    set(circles, {d: drawn.circles});
    for (const letter in pieces) set(pieces[letter], {d: drawn[letter]});
    drawWords(scenario, entries, freePlace, taken);
  }

  function drawWords(scenario, entries, freePlace, taken) {
    while (texts.length < entries.length) texts.push(element("text", {class: "leg-text"}, signs));
    texts.forEach((text, i) => {
      const entry = entries[i];
      write(text, entry ? entry.word : "");
      if (!entry || !entry.word) return;
      const place = freePlace(scenario, entry, taken);
      taken.push(place);
      set(text, {x: place.x + 7, y: place.y - 7});
    });
  }

  return {draw};
};
