"use strict";
// window.explorerHandles(scene, model): the handles of target, start heading and turning radius, for
// mouse, touch and keyboard.
//
// `model` is {state(), side(), change(values, view), rest()}: `change` is called for every move, with
// the view "keep" in a drag; `rest` is called once a drag has ended. `place(places)` moves the handles
// to pixels of the plane, `speak(scenario, summary)` sets what screen readers say, `dragged()` says
// whether one is being dragged, `pointed(event)` returns the values of a target under the pointer.
window.explorerHandles = (scene, model) => {
  const {element, set, write} = window.svgElements, {svg} = scene, DEGREE = Math.PI / 180;
  const ROUGH = 10; // steps of an arrow key with shift, and of page up and down
  // Handles in the order of tabs; later ones lie over earlier ones.
  const LABELS = {
    heading: ["Start heading", "arrow keys turn it by 1 degree, with shift by 10", "θ"],
    radius: ["Turning radius", "arrow keys change it by 1 percent, with shift by 10", "R"],
    target: ["Target", "arrow keys move it by a twentieth of R, with shift by half of R", "T"],
  };
  const ARROWS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]};
  const PAGES = {PageUp: [0, 1], PageDown: [0, -1]};
  const RADIUS_KEYS = {"+": [1, 0], "=": [1, 0], "-": [-1, 0], "_": [-1, 0]};
  const handles = {};
  let dragged = null, pointer = null, offset = {x: 0, y: 0}, centres = {};

  const short = (value) => Number(value.toPrecision(12)); // 0.1 + 0.2 is 0.3 here

  // A heading (rad) in whole or tenth degrees, within half a turn.
  function turned(radians) {
    let degrees = Math.round(radians / DEGREE * 10) / 10 % 360;
    if (degrees > 180) degrees -= 360;
    if (degrees <= -180) degrees += 360;
    return {written: `${degrees}deg`, heading: degrees * DEGREE};
  }

  // A coordinate as exactly as a pointer can point.
  function rounded(value) {
    const digits = Math.max(0, Math.min(12, Math.ceil(-Math.log10(scene.pixel()))));
    return Number(value.toFixed(digits));
  }

  // What a pointer's place in the plane means, and what n steps of an arrow key do.
  const MOVES = {
    target: {
      drag: (point) => ({target_x: rounded(point.x), target_y: rounded(point.y)}),
      key: ([i, j], n) => {
        const {target_x, target_y, radius} = model.state(), step = 0.05 * n * radius;
        return {target_x: short(target_x + i * step), target_y: short(target_y + j * step)};
      },
    },
    heading: {
      drag: (point) => turned(Math.atan2(point.y - model.state().y, point.x - model.state().x)),
      key: ([i, j], n) => turned(model.state().heading + (j - i) * n * DEGREE), // left, up: counter-clockwise
    },
    radius: {
      drag: (point) => {
        const across = model.side() * scene.into(model.state(), point).left / 2;
        return {radius: rounded(Math.max(across, 6 * scene.pixel()))};
      },
      key: ([i, j], n) => ({radius: Number((model.state().radius * (1 + 0.01 * n) ** (i + j)).toPrecision(4))}),
    },
  };

  // Pixels of the plane under a pointer.
  function pixelsOf(event) {
    const box = svg.getBoundingClientRect(), scale = svg.viewBox.baseVal.width / box.width;
    return {x: (event.clientX - box.left) * scale, y: (event.clientY - box.top) * scale};
  }

  function handle(name) {
    const [label, help, letter] = LABELS[name], heading = name === "heading";
    const made = element("g", {class: `handle ${name}`, tabindex: 0, role: "slider",
      "aria-label": `${label}: ${help}`, "aria-valuemin": heading ? -180 : 0,
      "aria-valuemax": heading ? 180 : 1e13}, svg);
    for (const [kind, r] of [["touch", 22], ["focus", 15], ["knob", 9]]) element("circle", {class: kind, r}, made);
    write(element("text", {}, made), letter);
    made.addEventListener("pointerdown", begin);
    // a second finger is not the one that drags
    made.addEventListener("pointermove", (event) => event.pointerId === pointer && drag(event));
    for (const type of ["pointerup", "pointercancel"]) {
      made.addEventListener(type, (event) => event.pointerId === pointer && end());
    }
    made.addEventListener("keydown", (event) => press(event, name));
    return made;
  }

  // Handles may lie over each other: the one whose middle is nearest is dragged.
  function nearest({x, y}) {
    const distance = (name) => Math.hypot(centres[name].x - x, centres[name].y - y);
    return Object.keys(LABELS).reduce((best, name) => (distance(name) <= distance(best) ? name : best));
  }

  // The pointer keeps its distance from the middle, so that a press alone moves nothing.
  function begin(event) {
    event.preventDefault();
    if (event.button !== 0 || dragged) return;
    const at = pixelsOf(event);
    dragged = nearest(at);
    pointer = event.pointerId;
    offset = {x: centres[dragged].x - at.x, y: centres[dragged].y - at.y};
    handles[dragged].setPointerCapture(event.pointerId);
    handles[dragged].focus({preventScroll: true, focusVisible: false});
  }

  function drag(event) {
    const {x, y} = pixelsOf(event);
    model.change(MOVES[dragged].drag(scene.pointAt(x + offset.x, y + offset.y)), "keep");
  }

  function end() {
    dragged = pointer = null;
    model.rest();
  }

  function press(event, name) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const radius = RADIUS_KEYS[event.key], page = PAGES[event.key], step = ARROWS[event.key];
    if (!radius && !page && !step) return;
    event.preventDefault();
    const n = page || event.shiftKey && step ? ROUGH : 1;
    model.change(radius ? MOVES.radius.key(radius, n) : MOVES[name].key(step || page, n));
  }

  function place(places) {
    centres = places;
    for (const name in places) set(handles[name], {transform: `translate(${places[name].x} ${places[name].y})`});
  }

  function speak(scenario, summary) {
    const {number} = window.explorerNumbers, {X, Y} = window.dubins.local(scenario);
    const degrees = scenario.heading / DEGREE;
    const values = {
      target: [Math.hypot(X, Y), `${number(scenario.target_x)}, ${number(scenario.target_y)}`],
      heading: [degrees, `${number(degrees, 5)} degrees`],
      radius: [scenario.radius, number(scenario.radius)],
    };
    for (const [name, [value, text]] of Object.entries(values)) {
      set(handles[name], {"aria-valuenow": short(value), "aria-valuetext": `${text}. ${summary}`});
    }
  }

  for (const name in LABELS) handles[name] = handle(name);
  return {
    place, speak, dragged: () => dragged !== null,
    pointed(event) {
      const {x, y} = pixelsOf(event);
      return MOVES.target.drag(scene.pointAt(x, y));
    },
  };
};
