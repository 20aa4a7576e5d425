"use strict";
// The explorer: a scenario that handles, fields, examples and the address (#explore=...) change, and
// everything that is computed from it. The static drawings that the page holds for readers without
// scripts make room for it. For tests, `window.explorer` hands out {set, state, ...}.
(() => {
  const root = document.querySelector("[data-explorer]");
  if (!root) return;
  const {set: setAttributes} = window.svgElements;
  const HASH = "#explore=", DEGREE = Math.PI / 180;
  const SETTLED_MS = 250; // after the last change: address, spoken summary
  const LARGEST = 1e100; // beyond it, squares of pixels and scales of axes overflow
  const NUMBERS = ["x", "y", "target_x", "target_y", "radius"];
  const scene = window.explorerScene(root.querySelector(".explorer-stage")), {svg} = scene;
  const handles = window.explorerHandles(scene, {
    state: () => state, side: () => side, change: changed, rest: () => set({}),
  });
  const answers = window.explorerAnswers(root), copies = window.explorerCopies(root);
  const sweep = window.explorerSweep(root.querySelector(".explorer-sweep"),
    (radius) => changed({radius: Number(radius.toPrecision(3))}));
  const fields = {};
  for (const input of root.querySelectorAll("input[name]")) fields[input.name] = input;
  const problem = root.querySelector("[data-answer=problem]");

  // The scenario, and the heading as people write it ("120deg", or a number: rad). `touched` says
  // whether a reader changed anything: only then the address follows.
  let state = null, entries = [], side = 1, settle = 0, frame = 0, touched = false;

  // Angle in rad of "120deg" or of a number in rad; NaN if it is neither.
  function angle(text) {
    const match = /^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*(deg|°|rad)?\s*$/i.exec(text);
    if (!match) return NaN;
    return ["deg", "°"].includes(match[2]) ? Number(match[1]) * DEGREE : Number(match[1]);
  }

  // The scenario of "x,y,heading,target x,target y,radius"; an error says why there is none.
  function parsed(text) {
    const parts = text.split(",");
    if (parts.length !== 6 || parts.some((part) => !part.trim())) throw new RangeError(`${text} has not six parts`);
    const [x, y, written, target_x, target_y, radius] = parts;
    const scenario = {x: Number(x), y: Number(y), heading: angle(written),
      target_x: Number(target_x), target_y: Number(target_y), radius: Number(radius), written: written.trim()};
    const message = refusal(scenario);
    if (message) throw new RangeError(message);
    return scenario;
  }

  // Why a scenario cannot be shown; "" if it can be.
  function refusal(scenario) {
    const message = window.dubins.refusal(scenario);
    if (message) return message;
    const name = NUMBERS.find((each) => Math.abs(scenario[each]) > LARGEST);
    if (name) return `${name} is ${scenario[name]}; expected at most ${LARGEST}, which can be drawn`;
    return scenario.radius < 1 / LARGEST
      ? `radius is ${scenario.radius}; expected at least ${1 / LARGEST}, which can be drawn` : "";
  }

  const listed = ({x, y, written, target_x, target_y, radius}) => [x, y, written, target_x, target_y, radius].join(",");

  // The only place where the scenario changes. `view`: "fit", "keep", or undefined: fit if need be.
  function set(change, view) {
    const next = {...state, ...change}, message = refusal(next);
    if (message || Object.keys(change).length) problem.textContent = message;
    if (message) return false;
    state = next;
    entries = window.dubins.words(state);
    if (!handles.dragged()) side = scene.radiusSide(state);
    if (view === "fit" || (view !== "keep" && !scene.fits(state))) scene.fit(state, entries);
    refresh();
    return true;
  }

  // A change by the reader.
  function changed(change, view) {
    touched = true;
    return set(change, view);
  }

  let summary = "";
  function refresh() {
    handles.place(scene.draw(state, entries, side));
    summary = answers.fill(state, entries);
    handles.speak(state, summary);
    for (const name of NUMBERS) show(fields[name], state[name]);
    stepRadius(state.radius);
    show(fields.heading, Number((state.heading / DEGREE).toPrecision(12)));
    copies.fill(state, `${location.href.split("#")[0]}${HASH}${listed(state)}`);
    cancelAnimationFrame(frame); // once a frame is enough for what is drawn beside the plane
    frame = requestAnimationFrame(() => sweep.draw(state, entries.find((entry) => entry.optimal).length));
    clearTimeout(settle);
    settle = setTimeout(settled, SETTLED_MS);
  }

  // A number in its field, unless someone writes there.
  function show(input, value) {
    const text = String(value);
    if (input !== document.activeElement && input.value !== text) input.value = text;
  }

  // Arrow keys change the radius by a power of ten that is at most a tenth of it, so that it never
  // becomes 0. Browsers count steps from `min` on: it is what the radius has beyond whole steps, or
  // one step. For 1.234 the step is 0.1 and `min` 0.034; for 1.2 both are 0.1.
  function stepRadius(radius) {
    const [digits, power] = radius.toExponential().split("e"), step = Number(`0.1e${power}`);
    setAttributes(fields.radius, {step, min: Number(`0.0${digits.slice(3)}e${power}`) || step});
  }

  function settled() {
    answers.announce(summary);
    if (touched && !handles.dragged()) history.replaceState(null, "", `${HASH}${listed(state)}`);
  }

  svg.addEventListener("click", (event) => { // a click beside the handles sets the target
    if (!event.target.closest(".handle")) changed(handles.pointed(event), "keep");
  });
  for (const [name, input] of Object.entries(fields)) {
    input.addEventListener("input", () => {
      if (!input.value.trim()) return;
      const value = Number(input.value);
      changed(name === "heading" ? {heading: value * DEGREE, written: `${value}deg`} : {[name]: value}, "fit");
    });
    input.addEventListener("blur", () => { // a number that was refused gives way to the last good one
      problem.textContent = "";
      set({});
    });
  }
  for (const button of root.querySelectorAll("button[data-scenario]")) {
    button.addEventListener("click", () => changed(parsed(button.dataset.scenario), "fit"));
  }
  root.querySelector("button[data-fit]").addEventListener("click", () => set({}, "fit"));

  function fromAddress() {
    if (!location.hash.startsWith(HASH)) return;
    try {
      set(parsed(decodeURIComponent(location.hash.slice(HASH.length))), "fit");
    } catch (error) { // no scenario, or no text in percent-encoding
      problem.textContent = `The address holds no scenario: ${error.message}. `
        + "Expected: x, y, heading, target x, target y, radius.";
    }
    root.scrollIntoView({behavior: "instant"});
  }

  function resize() {
    const {width} = svg.getBoundingClientRect();
    if (!width) return;
    const height = Math.round(Math.max(300, Math.min(0.62 * width, 380)));
    svg.style.height = `${height}px`;
    scene.resize(width, height);
    sweep.resize(width);
    set({}, "fit");
  }

  root.classList.add("live");
  state = parsed(root.dataset.explorer);
  new ResizeObserver(resize).observe(svg.parentElement);
  addEventListener("hashchange", fromAddress);
  resize();
  fromAddress();
  window.explorer = {set, state: () => state, entries: () => entries, sweep};
})();
