"use strict";
// The explorer: a scenario that pointer, keyboard, fields, examples and the address (#explore=...)
// change, and everything that is computed from it. The static drawings that the page holds for
// readers without scripts make room for it. For tests, `window.explorer` hands out {set, state}.
(() => {
  const root = document.querySelector("[data-explorer]");
  if (!root) return;
  const HASH = "#explore=", DEGREE = Math.PI / 180, NAMESPACE = "http://www.w3.org/2000/svg";
  const SETTLED_MS = 250; // after the last change: address, spoken summary
  const NUMBERS = ["x", "y", "target_x", "target_y", "radius"];
  const scene = window.explorerScene(root.querySelector(".explorer-stage")), {svg} = scene;
  const answers = window.explorerAnswers(root);
  const sweep = window.explorerSweep(root.querySelector(".explorer-sweep"), (radius) => {
    touched = true;
    set({radius: Number(radius.toPrecision(3))});
  });
  const fields = {};
  for (const input of root.querySelectorAll("input[name]")) fields[input.name] = input;
  const problem = root.querySelector("[data-answer=problem]");

  // The scenario, and the heading as people write it ("120deg", or a number: rad).
  let state = null, entries = [], side = 1, dragged = null, settle = 0, frame = 0, touched = false;

  // Angle in rad of "120deg" or of a number in rad; NaN if it is neither.
  function angle(text) {
    const match = /^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*(deg|°|rad)?\s*$/i.exec(text);
    if (!match) return NaN;
    return ["deg", "°"].includes(match[2]) ? Number(match[1]) * DEGREE : Number(match[1]);
  }

  // "x,y,heading,target x,target y,radius" -> a scenario; null if it is none.
  function parsed(text) {
    const parts = text.split(",");
    if (parts.length !== 6 || parts.some((part) => !part.trim())) return null;
    const [x, y, written, target_x, target_y, radius] = parts;
    const scenario = {x: Number(x), y: Number(y), heading: angle(written),
      target_x: Number(target_x), target_y: Number(target_y), radius: Number(radius), written: written.trim()};
    return refusal(scenario) ? null : scenario;
  }

  function refusal(scenario) {
    try {
      window.dubins.local(scenario);
      return "";
    } catch (error) {
      return error.message;
    }
  }

  const short = (value) => Number(value.toPrecision(12)); // 0.1 + 0.2 is 0.3 here
  const listed = ({x, y, written, target_x, target_y, radius}) => [x, y, written, target_x, target_y, radius].join(",");

  // The only place where the scenario changes. `view`: "fit", "keep", or undefined: fit if need be.
  function set(change, view) {
    const next = {...state, ...change}, message = refusal(next);
    problem.textContent = message;
    if (message) return false;
    state = next;
    entries = window.dubins.words(state);
    if (!dragged) side = scene.radiusSide(state);
    if (view === "fit" || (view !== "keep" && !scene.fits(state))) scene.fit(state, entries);
    refresh();
    return true;
  }

  function turned(radians) { // a heading in whole or tenth degrees, within half a turn
    let degrees = Math.round(radians / DEGREE * 10) / 10 % 360;
    if (degrees > 180) degrees -= 360;
    if (degrees <= -180) degrees += 360;
    return {written: `${degrees}deg`, heading: degrees * DEGREE};
  }

  let summary = "";
  function refresh() {
    const places = scene.draw(state, entries, side);
    for (const [name, {x, y}] of Object.entries(places)) handles[name].setAttribute("transform", `translate(${x} ${y})`);
    summary = answers.fill(state, entries);
    for (const name of NUMBERS) if (fields[name] !== document.activeElement) fields[name].value = state[name];
    if (fields.heading !== document.activeElement) fields.heading.value = short(state.heading / DEGREE);
    copies.command.textContent = command();
    copies.python.textContent = python();
    speak();
    cancelAnimationFrame(frame); // once a frame is enough for what is drawn beside the plane
    frame = requestAnimationFrame(() => sweep.draw(state, entries));
    clearTimeout(settle);
    settle = setTimeout(settled, SETTLED_MS);
  }

  // What screen readers say at a handle.
  function speak() {
    const {number} = window.explorerNumbers, degrees = `${number(state.heading / DEGREE, 5)} degrees`;
    const texts = {
      target: `${number(state.target_x)}, ${number(state.target_y)}. ${summary}`,
      heading: `${degrees}. ${summary}`, radius: `${number(state.radius)}. ${summary}`,
    };
    const local = window.dubins.local(state);
    const values = {target: Math.hypot(local.X, local.Y), heading: state.heading / DEGREE, radius: state.radius};
    for (const [name, handle] of Object.entries(handles)) {
      handle.setAttribute("aria-valuetext", texts[name]);
      handle.setAttribute("aria-valuenow", short(values[name]));
    }
  }

  function settled() {
    answers.announce(summary);
    copies.link.textContent = `${location.href.split("#")[0]}${HASH}${listed(state)}`;
    if (touched && !dragged) history.replaceState(null, "", `${HASH}${listed(state)}`);
  }

  function command() { // a heading of more than a turn is taken only with its unit
    const {x, y, written, target_x, target_y, radius} = state;
    const heading = written.replace("°", "deg").replace(/\d$/, "$&rad").replace(/\s/g, "");
    return `dubins-study solve ${target_x} ${target_y} --from ${x} ${y} ${heading} --radius ${radius}`;
  }

  function python() {
    const {x, y, written, target_x, target_y, radius} = state;
    const heading = /[a-z°]/i.test(written.replace(/e[+-]?\d+$/i, "")) ? `"${written}"` : written;
    return `from dubins_study import Scenario, solve\n\nanswer = solve(Scenario(${x}, ${y}, ${heading}, `
      + `${target_x}, ${target_y}, radius=${radius}))\nprint(answer.word, answer.length, answer.verdict)`;
  }

  // Handles: what a pointer's place (plane) means, and what an arrow key does.
  const steps = (event) => (event.shiftKey ? 10 : 1);
  const STEPS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]};
  const MOVES = {
    target: {
      drag: (point) => ({target_x: rounded(point.x), target_y: rounded(point.y)}),
      key: ([i, j], n) => {
        const step = 0.05 * n * state.radius;
        return {target_x: short(state.target_x + i * step), target_y: short(state.target_y + j * step)};
      },
    },
    heading: {
      drag: (point) => turned(Math.atan2(point.y - state.y, point.x - state.x)),
      key: ([i, j], n) => turned(state.heading + (j - i) * n * DEGREE), // left and up: counter-clockwise
    },
    radius: {
      drag: (point) => {
        const across = side * scene.into(state, point).left / 2;
        return {radius: rounded(Math.max(across, 6 * scene.pixel()))};
      },
      key: ([i, j], n) => ({radius: Number((state.radius * (1 + 0.01 * n) ** (i + j)).toPrecision(4))}),
    },
  };
  const LABELS = {
    target: ["Target", "arrow keys move it by a twentieth of R, with shift by half of R", "T"],
    heading: ["Start heading", "arrow keys turn it by 1 degree, with shift by 10", "θ"],
    radius: ["Turning radius", "arrow keys change it by 1 percent, with shift by 10", "R"],
  };

  // A coordinate as exactly as a pointer can point.
  function rounded(value) {
    const digits = Math.max(0, Math.min(12, Math.ceil(-Math.log10(scene.pixel()))));
    return Number(value.toFixed(digits));
  }

  function pointOf(event) {
    const box = svg.getBoundingClientRect(), scale = svg.viewBox.baseVal.width / box.width;
    return scene.pointAt((event.clientX - box.left) * scale, (event.clientY - box.top) * scale);
  }

  const handles = {};
  for (const name of ["heading", "radius", "target"]) handles[name] = handle(name);

  function handle(name) {
    const made = document.createElementNS(NAMESPACE, "g"), [label, help, letter] = LABELS[name];
    const attributes = {class: `handle ${name}`, tabindex: 0, role: "slider", "aria-label": `${label}: ${help}`,
      "aria-valuemin": name === "heading" ? -180 : 0, "aria-valuemax": name === "heading" ? 180 : 1e13};
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    for (const [kind, r] of [["touch", 22], ["focus", 15], ["knob", 9]]) {
      const circle = document.createElementNS(NAMESPACE, "circle");
      circle.setAttribute("class", kind);
      circle.setAttribute("r", r);
      made.append(circle);
    }
    const text = document.createElementNS(NAMESPACE, "text");
    text.textContent = letter;
    made.append(text);
    made.addEventListener("pointerdown", (event) => begin(event, name));
    made.addEventListener("pointermove", (event) => dragged === name && drag(event));
    for (const type of ["pointerup", "pointercancel"]) made.addEventListener(type, () => dragged === name && end());
    made.addEventListener("keydown", (event) => press(event, name));
    return svg.appendChild(made);
  }

  function begin(event, name) {
    if (event.button !== 0) return;
    event.preventDefault();
    handles[name].setPointerCapture(event.pointerId);
    handles[name].focus({preventScroll: true, focusVisible: false});
    dragged = name;
    touched = true;
  }

  function drag(event) {
    set(MOVES[dragged].drag(pointOf(event)), "keep");
  }

  function end() {
    dragged = null;
    set({});
  }

  function press(event, name) {
    const signs = {"+": [1, 0], "=": [1, 0], "-": [-1, 0], "_": [-1, 0]};
    const radius = signs[event.key], step = STEPS[event.key];
    if ((!radius && !step) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    touched = true;
    set(radius ? MOVES.radius.key(radius, steps(event)) : MOVES[name].key(step, steps(event)));
  }

  svg.addEventListener("click", (event) => { // a click beside the handles sets the target
    if (event.target.closest(".handle")) return;
    touched = true;
    set(MOVES.target.drag(pointOf(event)), "keep");
  });

  for (const [name, input] of Object.entries(fields)) {
    input.addEventListener("input", () => {
      touched = true;
      if (!input.value.trim()) return;
      const value = Number(input.value);
      set(name === "heading" ? {heading: value * DEGREE, written: `${value}deg`} : {[name]: value}, "fit");
    });
    input.addEventListener("blur", () => set({}));
  }
  for (const button of root.querySelectorAll("button[data-scenario]")) {
    button.addEventListener("click", () => {
      touched = true;
      set(parsed(button.dataset.scenario), "fit");
    });
  }
  root.querySelector("button[data-fit]").addEventListener("click", () => set({}, "fit"));

  const copies = {};
  for (const code of root.querySelectorAll("[data-copy]")) copies[code.dataset.copy] = code;
  for (const button of root.querySelectorAll("button[data-copies]")) {
    button.addEventListener("click", () => copy(button, copies[button.dataset.copies]));
  }

  async function copy(button, code) {
    getSelection().selectAllChildren(code); // if the browser refuses, the text is selected for Ctrl+C
    let done = false;
    try {
      await navigator.clipboard.writeText(code.textContent);
      done = true;
    } catch {
      done = document.execCommand("copy");
    }
    const label = button.textContent;
    button.textContent = done ? "copied" : "press Ctrl+C";
    setTimeout(() => { button.textContent = label; }, 1500);
  }

  function fromAddress() {
    if (!location.hash.startsWith(HASH)) return false;
    let scenario = null;
    try {
      scenario = parsed(decodeURIComponent(location.hash.slice(HASH.length)));
    } catch { /* no text in percent-encoding: no scenario */ }
    if (scenario) set(scenario, "fit");
    root.scrollIntoView({behavior: "instant"});
    return Boolean(scenario);
  }

  function resize() {
    const {width} = svg.getBoundingClientRect();
    if (!width) return;
    const height = Math.round(Math.max(300, Math.min(0.62 * width, 560)));
    svg.style.height = `${height}px`;
    scene.resize(width, height);
    set({}, "fit");
  }

  root.classList.add("live");
  state = parsed(root.dataset.explorer);
  new ResizeObserver(resize).observe(svg.parentElement);
  addEventListener("hashchange", fromAddress);
  resize();
  fromAddress();
  window.explorer = {set, parsed, state: () => state, entries: () => entries, sweep};
})();
