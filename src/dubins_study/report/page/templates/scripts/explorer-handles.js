"use strict";
// window.explorerHandles(scene, model): the handles of target, via points, headings and turning
// radius, for mouse, touch and keyboard.
//
// `model` is {state(), side(), change(values, view), rest()}. `change` is called for every move,
// in a drag with the view "keep"; `rest` is called once a drag has ended. It returns functions:
// - `place(places)` moves the handles to pixels of the plane and hides those without a place;
// - `number(order, tour)` numbers the via points by their visits;
// - `speak(scenario, summary)` sets the texts of screen readers;
// - `dragged()` says whether a handle is being dragged;
// - `pointed(event)` returns the place under the pointer: its pixel, and the plane's point [x, y],
//   rounded to what a pointer can resolve.
window.explorerHandles = (scene, model) => {
  const {element, set, write} = window.svgElements, {svg} = scene, DEGREE = Math.PI / 180;
  const ROUGH = 10; // steps of an arrow key with shift, and of page up and down
  const TWICE_MS = 400; // at most, between two presses of a handle that remove its point or heading
  const MOVED_BY = "arrow keys move it by a twentieth of R, with shift by half of R";
  const REMOVED_BY = `${MOVED_BY}, Delete removes it`;
  const TURNED_BY = "arrow keys turn it by 1 degree, with shift by 10";
  // Handles in the order of tabs; later ones lie over earlier ones.
  const LABELS = {
    heading: ["Start heading", TURNED_BY, "θ"],
    radius: ["Turning radius", "arrow keys change it by 1 percent, with shift by 10", "R"],
  };
  for (let number = 1; number <= window.explorerHandles.MOST_VIA; number += 1) {
    LABELS[`via-${number}`] = [`Via point ${number}`, REMOVED_BY, String(number)];
  }
  Object.assign(LABELS, {
    final: ["Final heading", `${TURNED_BY}, Delete sets it free`, "φ"],
    target: ["Target", MOVED_BY, "T"],
  });
  const ARROWS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]};
  const PAGES = {PageUp: [0, 1], PageDown: [0, -1]};
  const RADIUS_KEYS = {"+": [1, 0], "=": [1, 0], "-": [-1, 0], "_": [-1, 0]};
  const handles = {};
  let dragged = null, pointer = null, offset = {x: 0, y: 0}, centres = {};
  let moved = false, pressed = {name: "", time: 0}; // last press: dragged, of what, when

  const short = (value) => Number(value.toPrecision(12)); // 0.1 + 0.2 is 0.3 here

  // A heading (rad) in whole or tenth degrees, within half a turn, and as people write it.
  function turned(radians) {
    let degrees = Math.round(radians / DEGREE * 10) / 10 % 360;
    if (degrees > 180) degrees -= 360;
    if (degrees <= -180) degrees += 360;
    return [degrees * DEGREE, `${degrees}deg`];
  }

  // A coordinate rounded to a pixel's size.
  function rounded(value) {
    const digits = Math.max(0, Math.min(12, Math.ceil(-Math.log10(scene.pixel()))));
    return Number(value.toFixed(digits));
  }

  // {drag, key} of a handle: the change that a pointer's place makes, and the change of n steps of
  // an arrow key. `placed` is for a point, which `at` returns and `to` changes; the other for a
  // heading.
  const placed = (at, to) => ({
    drag: (point) => to(rounded(point.x), rounded(point.y)),
    key: ([i, j], n) => {
      const [x, y] = at(model.state()), step = 0.05 * n * model.state().radius;
      return to(short(x + i * step), short(y + j * step));
    },
  });
  const pointing = (from, angle, to) => ({
    drag: (point) => {
      const [x, y] = from(model.state());
      return to(...turned(Math.atan2(point.y - y, point.x - x)));
    },
    key: ([i, j], n) => to(...turned(angle(model.state()) + (j - i) * n * DEGREE)), // left, up: counter-clockwise
  });
  const target = ({target_x, target_y}) => [target_x, target_y];
  const MOVES = {
    target: placed(target, (target_x, target_y) => ({target_x, target_y})),
    heading: pointing(({x, y}) => [x, y], ({heading}) => heading, (heading, written) => ({heading, written})),
    final: pointing(target, (state) => state.final_heading,
      (final_heading, final_written) => ({final_heading, final_written})),
    radius: {
      drag: (point) => {
        const across = model.side() * scene.into(model.state(), point).left / 2;
        return {radius: rounded(Math.max(across, 6 * scene.pixel()))};
      },
      key: ([i, j], n) => ({radius: Number((model.state().radius * (1 + 0.01 * n) ** (i + j)).toPrecision(4))}),
    },
  };
  for (const name in LABELS) {
    const i = viaOf(name);
    if (i >= 0) MOVES[name] = placed(({via}) => via[i], (x, y) => ({via: model.state().via.with(i, [x, y])}));
  }

  // The place of a handle's via point in the list of via points; -1 for other handles.
  function viaOf(name) {
    return name.startsWith("via-") ? Number(name.slice(4)) - 1 : -1;
  }

  // The change that removes a handle's via point or final heading; null for other handles.
  function without(name) {
    if (name === "final") return {final_heading: null, final_written: ""};
    return viaOf(name) < 0 ? null : {via: model.state().via.toSpliced(viaOf(name), 1)};
  }

  function remove(name) {
    if (!model.change(without(name), "keep")) return;
    const left = centres[name] ? name : "target";
    handles[left].focus({preventScroll: true});
  }

  // Pixels of the plane under a pointer.
  function pixelsOf(event) {
    const box = svg.getBoundingClientRect(), scale = svg.viewBox.baseVal.width / box.width;
    return {x: (event.clientX - box.left) * scale, y: (event.clientY - box.top) * scale};
  }

  function handle(name) {
    const [label, help, letter] = LABELS[name], heading = ["heading", "final"].includes(name);
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
    made.addEventListener("click", (event) => clicked(event));
    made.addEventListener("keydown", (event) => press(event, name));
    return made;
  }

  // Handles may lie over each other: the one whose middle is nearest is dragged.
  function nearest({x, y}) {
    const distance = (name) => Math.hypot(centres[name].x - x, centres[name].y - y);
    return Object.keys(LABELS).filter((name) => centres[name])
      .reduce((best, name) => (distance(name) <= distance(best) ? name : best));
  }

  // The pointer keeps its distance from the middle, so that a press alone moves nothing.
  function begin(event) {
    event.preventDefault();
    if (event.button !== 0 || dragged) return;
    const at = pixelsOf(event);
    dragged = nearest(at);
    pointer = event.pointerId;
    moved = false;
    offset = {x: centres[dragged].x - at.x, y: centres[dragged].y - at.y};
    handles[dragged].setPointerCapture(event.pointerId);
    handles[dragged].focus({preventScroll: true, focusVisible: false});
  }

  function drag(event) {
    const {x, y} = pixelsOf(event), at = centres[dragged];
    if (x + offset.x !== at.x || y + offset.y !== at.y) moved = true;
    model.change(MOVES[dragged].drag(scene.pointAt(x + offset.x, y + offset.y)), "keep");
  }

  function end() {
    dragged = pointer = null;
    model.rest();
  }

  // A second press of the same handle: by time and not by `dblclick`, which touch may not send.
  function clicked(event) {
    const name = nearest(pixelsOf(event)), twice = pressed.name === name && event.timeStamp - pressed.time < TWICE_MS;
    pressed = moved || twice ? {name: "", time: 0} : {name, time: event.timeStamp};
    if (twice && !moved && without(name)) remove(name);
  }

  function press(event, name) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (["Delete", "Backspace"].includes(event.key) && without(name)) {
      event.preventDefault();
      remove(name);
    }
    const radius = RADIUS_KEYS[event.key], page = PAGES[event.key], step = ARROWS[event.key];
    if (!radius && !page && !step) return;
    event.preventDefault();
    const n = page || event.shiftKey && step ? ROUGH : 1;
    model.change(radius ? MOVES.radius.key(radius, n) : MOVES[name].key(step || page, n));
  }

  function place(places) {
    centres = places;
    for (const name in LABELS) {
      set(handles[name], {display: places[name] ? "inline" : "none"});
      if (places[name]) set(handles[name], {transform: `translate(${places[name].x} ${places[name].y})`});
    }
  }

  function number(order, tour) {
    order.forEach((i, visit) => {
      const visited = tour ? `, visit ${visit + 1}` : "", made = handles[`via-${i + 1}`];
      write(made.querySelector("text"), String(visit + 1));
      set(made, {"aria-label": `Via point ${i + 1}${visited}: ${REMOVED_BY}`});
    });
  }

  function speak(scenario, summary) {
    const {number} = window.explorerNumbers, {x, y, radius, via, final_heading} = scenario;
    const place = ([px, py]) => [Math.hypot(px - x, py - y) / radius, `${number(px)}, ${number(py)}`];
    const angle = (radians) => [radians / DEGREE, `${number(radians / DEGREE, 5)} degrees`];
    const values = {
      target: place(target(scenario)), heading: angle(scenario.heading), radius: [radius, number(radius)],
    };
    via.forEach((point, i) => { values[`via-${i + 1}`] = place(point); });
    if (final_heading !== null) values.final = angle(final_heading);
    for (const [name, [value, text]] of Object.entries(values)) {
      set(handles[name], {"aria-valuenow": short(value), "aria-valuetext": `${text}. ${summary}`});
    }
  }

  for (const name in LABELS) handles[name] = handle(name);
  return {
    place, number, speak, rounded, dragged: () => dragged !== null,
    pointed(event) {
      const pixel = pixelsOf(event), {x, y} = scene.pointAt(pixel.x, pixel.y);
      return {pixel, point: [rounded(x), rounded(y)]};
    },
  };
};
window.explorerHandles.MOST_VIA = 12;
