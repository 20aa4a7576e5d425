"use strict";
// The explorer: a scenario that handles, fields, examples and the address (#explore=...) change, and
// everything that is computed from it. The static drawings that the page holds for readers without
// scripts make room for it. For tests, `window.explorer` hands out {set, state, ...}.
(() => {
  const root = document.querySelector("[data-explorer]");
  if (!root) return;
  const {set: setAttributes} = window.svgElements;
  const {MOST_VIA} = window.explorerHandles;
  const HASH = "#explore=", DEGREE = Math.PI / 180;
  const SETTLED_MS = 250; // after the last change: address, spoken summary
  const LARGEST = 1e100; // beyond it, squares of pixels and scales of axes overflow
  const NUMBERS = ["x", "y", "target_x", "target_y", "radius"];
  const FORM = "x, y, heading, target x, target y, radius; then ;via=x,y,x,y..., ;order=free and ;final=heading";
  const scene = window.explorerScene(root.querySelector(".explorer-stage")), {svg} = scene;
  const handles = window.explorerHandles(scene, {
    state: () => state, side: () => side, change: changed, rest: () => set({}),
  });
  const answers = window.explorerAnswers(root), legs = window.explorerLegs(root), copies = window.explorerCopies(root);
  const sweep = window.explorerSweep(root.querySelector(".explorer-sweep"),
    (radius) => changed({radius: Number(radius.toPrecision(3))}));
  const fields = {};
  for (const input of root.querySelectorAll("input[name]")) fields[input.name] = input;
  const problem = root.querySelector("[data-answer=problem]"), more = root.querySelector(".explorer-more");
  const finalButton = root.querySelector("[data-final]"), orderButton = root.querySelector("[data-order]");

  // The scenario, and its headings as people write them ("120deg", or a number: rad). `touched` says
  // whether a reader changed anything: only then the address follows.
  let state = null, answer = null, side = 1, settle = 0, frame = 0, touched = false;

  // Angle in rad of "120deg" or of a number in rad; NaN if it is neither.
  function angle(text) {
    const match = /^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*(deg|°|rad)?\s*$/i.exec(text);
    if (!match) return NaN;
    return ["deg", "°"].includes(match[2]) ? Number(match[1]) * DEGREE : Number(match[1]);
  }

  // The scenario that a text of the form FORM describes; an error says what is wrong with the text.
  function parsed(text) {
    const [leg, ...options] = text.split(";"), parts = leg.split(",");
    if (parts.length !== 6 || parts.some((part) => !part.trim())) throw new RangeError(`${leg} has not six parts`);
    const [x, y, written, target_x, target_y, radius] = parts;
    const scenario = {x: Number(x), y: Number(y), heading: angle(written),
      target_x: Number(target_x), target_y: Number(target_y), radius: Number(radius), written: written.trim(),
      via: [], order: "given", final_heading: null, final_written: ""};
    for (const option of options) {
      const [name, value = ""] = option.split("="), numbers = value.split(",");
      if (name === "via" && numbers.length % 2 === 0 && numbers.every((number) => number.trim())) {
        for (let i = 0; i < numbers.length; i += 2) scenario.via.push([Number(numbers[i]), Number(numbers[i + 1])]);
      } else if (name === "final" && value) {
        Object.assign(scenario, {final_heading: angle(value), final_written: value.trim()});
      } else if (option === "order=free") {
        scenario.order = "free";
      } else throw new RangeError(`${option} is neither via=x,y,... nor final=heading nor order=free`);
    }
    const message = refusal(scenario);
    if (message) throw new RangeError(message);
    return scenario;
  }

  // Why a scenario cannot be shown; "" if it can be.
  function refusal(scenario) {
    const {x, y, target_x, target_y, via, order, final_heading} = scenario;
    if (Number.isNaN(final_heading)) return "final heading is not an angle; expected one such as 90deg";
    if (via.length > MOST_VIA) return `there are ${via.length} via points; expected at most ${MOST_VIA}: the command takes more`;
    const points = [[x, y], ...via, [target_x, target_y]];
    for (let i = 1; i < points.length; i += 1) {
      const before = order === "free" ? points.slice(0, i) : [points[i - 1]], [x2, y2] = points[i];
      for (const [x1, y1] of before) {
        const message = refusalOfLeg({...scenario, x: x1, y: y1, target_x: x2, target_y: y2});
        if (message) return i < points.length - 1 ? `via point ${i}: ${message}` : message;
        if (!via.length || x1 !== x2 || y1 !== y2) continue;
        return order === "free" ? "two points are equal; expected points apart"
          : "a via point is equal to the point before or after it; expected another place";
      }
    }
    return "";
  }

  function refusalOfLeg(scenario) {
    const message = window.dubins.refusal(scenario);
    if (message) return message;
    const name = NUMBERS.find((each) => Math.abs(scenario[each]) > LARGEST);
    if (name) return `${name} is ${scenario[name]}; expected at most ${LARGEST}, which can be drawn`;
    return scenario.radius < 1 / LARGEST
      ? `radius is ${scenario.radius}; expected at least ${1 / LARGEST}, which can be drawn` : "";
  }

  function listed({x, y, written, target_x, target_y, radius, via, order, final_written}) {
    const leg = [x, y, written, target_x, target_y, radius].join(",");
    const points = via.length ? `;via=${via.join(",")}` : "", free = order === "free" ? ";order=free" : "";
    return leg + points + free + (final_written && `;final=${final_written}`);
  }

  // The answer to a scenario. `entries` are the paths: one for every word to a point or to a pose,
  // or one for every leg of a route or tour. `drawn` are those that the plane shows. `order` has
  // the numbers of the via points in the order of the visits.
  function answerTo(scenario) {
    const {target_x, target_y, radius, via, order, final_heading} = scenario;
    if (order === "free" && via.length > 1) {
      const tour = window.dubins.tour(scenario);
      return {kind: "tour", drawn: tour.entries, ...tour};
    }
    if (via.length) {
      const {entries, headings} = window.dubins.route(scenario);
      return {kind: "route", entries, headings, drawn: entries, order: via.map((_, i) => i)};
    }
    if (final_heading === null) {
      const entries = window.dubins.words(scenario);
      return {kind: "point", entries, drawn: entries};
    }
    const end = {x: target_x, y: target_y, heading: final_heading};
    const entries = window.dubins.pose.words(scenario, end, radius);
    return {kind: "pose", entries, drawn: [entries.find((entry) => entry.optimal)]};
  }

  // The only place where the scenario changes. `view`: "fit", "keep", or undefined: fit if need be.
  function set(change, view) {
    const next = {...state, ...change};
    if (!next.via.length) next.order = "given"; // as in Python
    const message = refusal(next);
    if (message || Object.keys(change).length) problem.textContent = message;
    if (message) return false;
    state = next;
    answer = answerTo(state);
    if (!handles.dragged()) side = scene.radiusSide(state);
    if (view === "fit" || (view !== "keep" && !scene.fits(state))) scene.fit(state, answer);
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
    const onMap = answer.kind === "point";
    if (!onMap && root.dataset.kind === "point") more.open = true; // the command that proves is there
    root.dataset.kind = answer.kind;
    handles.place(scene.draw(state, answer, side));
    handles.number(answer.order || [], answer.kind === "tour");
    summary = onMap ? answers.fill(state, answer.entries) : legs.fill(state, answer);
    handles.speak(state, summary);
    for (const name of NUMBERS) show(fields[name], state[name]);
    stepRadius(state.radius);
    show(fields.heading, Number((state.heading / DEGREE).toPrecision(12)));
    const {final_heading} = state;
    show(fields.final_heading, final_heading === null ? "" : Number((final_heading / DEGREE).toPrecision(12)));
    setAttributes(finalButton, {"aria-pressed": String(final_heading !== null)});
    setAttributes(orderButton, {"aria-pressed": String(state.order === "free")});
    copies.fill(state, `${location.href.split("#")[0]}${HASH}${listed(state)}`);
    cancelAnimationFrame(frame); // the sweep is drawn at most once a frame
    if (onMap) frame = requestAnimationFrame(() => sweep.draw(state, answer.entries.find((entry) => entry.optimal).length));
    clearTimeout(settle);
    settle = setTimeout(settled, SETTLED_MS);
  }

  // Write a number into its field, unless a reader is typing there.
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

  // A click beside the handles sets the target on the map of words, and adds a via point otherwise.
  svg.addEventListener("click", (event) => {
    if (event.target.closest(".handle")) return;
    const {pixel, point} = handles.pointed(event);
    if (answer.kind === "point") changed({target_x: point[0], target_y: point[1]}, "keep");
    else changed({via: withPoint(scene.legAt(state, answer, pixel), point)}, "keep");
  });
  // The via points with one more on a leg; of a tour it comes last.
  function withPoint(leg, point) {
    return state.via.toSpliced(answer.kind === "tour" ? state.via.length : leg, 0, point);
  }
  // A via point in the middle of the longest leg.
  root.querySelector("[data-add]").addEventListener("click", () => {
    const {x, y, target_x, target_y, via} = state, passed = (answer.order || []).map((i) => via[i]);
    const points = [[x, y], ...passed, [target_x, target_y]];
    const lengths = points.slice(1).map(([u, v], i) => Math.hypot(u - points[i][0], v - points[i][1]));
    const longest = lengths.indexOf(Math.max(...lengths)), [[x1, y1], [x2, y2]] = points.slice(longest);
    changed({via: withPoint(longest, [handles.rounded((x1 + x2) / 2), handles.rounded((y1 + y2) / 2)])});
  });
  orderButton.addEventListener("click", () => changed({order: state.order === "free" ? "given" : "free"}));
  // The final heading is set free, or given as what it is, in whole degrees.
  finalButton.addEventListener("click", () => {
    const {kind, entries, headings} = answer;
    const last = headings ? headings.at(-1)
      : window.dubins.poses(state, ...["curvatures", "lengths"].map((name) => entries.find((entry) => entry.optimal)[name])).at(-1).heading;
    const degrees = Math.round(Math.atan2(Math.sin(last), Math.cos(last)) / DEGREE);
    changed(state.final_heading === null ? {final_heading: degrees * DEGREE, final_written: `${degrees}deg`}
      : {final_heading: null, final_written: ""});
  });
  for (const [name, input] of Object.entries(fields)) {
    input.addEventListener("input", () => {
      const value = Number(input.value), empty = !input.value.trim();
      if (empty && (name !== "final_heading" || input.validity.badInput)) return;
      changed({
        heading: {heading: value * DEGREE, written: `${value}deg`},
        final_heading: empty ? {final_heading: null, final_written: ""}
          : {final_heading: value * DEGREE, final_written: `${value}deg`},
      }[name] || {[name]: value}, "fit");
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
        + `Expected: ${FORM}.`;
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
  window.explorer = {set, state: () => state, entries: () => answer.entries, sweep};
})();
