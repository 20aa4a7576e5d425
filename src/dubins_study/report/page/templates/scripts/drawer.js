"use strict";
// The drawer of one attempt: its path beside the reference, its numbers, and the command that
// repeats it. `#attempt=ID` in the page's address opens it, or a sentence says why it cannot.
(() => {
  if (!document.getElementById("attempts-plot")) return;
  const {element} = window.studyTables;
  const {picture, number, seconds, command, open} = window.attempts;
  const HASH = "#attempt=";
  const problem = document.getElementById("attempt-problem");
  const state = {drawer: null, hits: [], place: 0, before: null};

  // A number of a scenario with at most six digits; the command has them all.
  function short(value) {
    return String(Number(value.toPrecision(6))).replaceAll("-", "−");
  }

  function facts(data, i) {
    const {columns} = data, radius = data.ofScenario("radius", i);
    const {target_x, target_y, x, y, has_target} = data.scenario(i);
    const heading = data.ofScenario("heading", i);
    const angle = (rad) => (rad === null ? "free" : `${short(rad * 180 / Math.PI)}°`);
    const claim = data.text("claim", i), verdict = data.text("verdict", i);
    const margin = data.ofScenario("margin", i), {via_x, final_heading, order, closed} = data.route(i);
    const end = has_target ? `(${short(target_x)}, ${short(target_y)})` : closed ? "the start" : "any of them";
    const where = [data.ofScenario("label", i), data.ofScenario("region", i),
      margin === null ? "" : `margin ${number(margin)} R`];
    const at = `from (${short(x)}, ${short(y)}), heading ${angle(heading)}, `
      + (via_x.length ? `via ${via_x.length} point${via_x.length > 1 ? "s" : ""} ` : "")
      + (order === "free" ? "in any order " : "") + `to ${end}, `
      + (final_heading === null ? "" : `heading ${angle(final_heading)}, `)
      + `R = ${short(radius)}`;
    const asked = data.text("branch", i) === "best" ? "the shortest path of all"
      : `the shortest path of word ${data.text("branch", i)}`;
    const guess = data.text("initial_guess", i);
    return [
      ["claim", claim],
      ["verdict", verdict + (data.has("false_claim", i) ? ": a false claim" : "")
        + (data.has("wrong_basin", i) ? ": another basin" : "")],
      ["outcome", data.text("outcome", i)],
      ["word", data.text("word", i)],
      ["gap", number(columns.gap[i])],
      ["miss", `${number(columns.miss[i] / radius)} R`, columns.miss[i]],
      ["curvature beyond 1/R", `${number(columns.curvature_excess[i])} / R`, columns.curvature_excess[i] || NaN],
      ["length", `${number(columns.length[i] / radius)} R`, columns.length[i]],
      ["time", `${seconds(columns.wall_s[i])}, in the solver ${seconds(columns.solve_s[i])}`],
      ["evaluations", String(columns.evaluations[i]), columns.evaluations[i]],
      ["status", data.text("native_status", i)],
      ["message", data.text("message", i)],
      ["asked for", asked + (guess && guess !== "cold" ? `, from the initial guess ${guess}` : "")],
      ["scenario", where.filter(Boolean).join(", ")],
      ["", at],
      ["experiment", data.text("experiment", i)],
    ].filter(([, text, needed]) => text !== null && text !== "" && !Number.isNaN(needed));
  }

  function build() {
    const close = element("button", {type: "button", className: "close", title: "close (Escape)"}, "close");
    const drawer = element("aside", {id: "attempt-drawer", tabIndex: -1, hidden: true});
    drawer.setAttribute("role", "dialog");
    drawer.setAttribute("aria-labelledby", "attempt-title");
    drawer.append(element("div", {className: "bar"}, element("div", {className: "steps"}), close),
      element("div", {className: "content"}));
    close.addEventListener("click", hide);
    drawer.addEventListener("keydown", (event) => event.key === "Escape" && hide());
    document.body.append(drawer);
    return drawer;
  }

  function commandBox(text) {
    const code = element("code", {}, text);
    const button = element("button", {type: "button"}, "copy");
    button.addEventListener("click", async () => {
      getSelection().selectAllChildren(code); // also where the clipboard is closed to the page
      try {
        await navigator.clipboard.writeText(text);
        button.textContent = "copied";
      } catch {
        button.textContent = "selected";
      }
    });
    return element("div", {className: "command"}, element("pre", {tabIndex: 0}, code), button);
  }

  function fill(data, i) {
    const content = state.drawer.querySelector(".content");
    const solver = data.solvers[data.columns.solver[i] - 1];
    const list = element("dl");
    for (const [name, text] of facts(data, i)) {
      list.append(element("dt", {}, name), element("dd", {}, text));
    }
    const bad = list.querySelectorAll("dd")[1];
    bad.className = data.has("false_claim", i) ? "bad" : "";
    const link = element("a", {href: HASH + data.id(i)}, "link to this attempt");
    const warm = !["cold", null].includes(data.text("initial_guess", i));
    content.replaceChildren(
      element("h3", {id: "attempt-title"}, solver.label),
      element("p", {className: "spec"}, element("code", {}, solver.spec)),
      picture(data, i, {width: 420, height: 340, labels: true}),
      element("p", {className: "legend"}, "solid: the solver's path; dashed: the shortest path, of a "
        + "route one that the check found optimal; thin circles: the start's turning circles"),
      list,
      element("h4", {}, "To repeat it"),
      commandBox(command(data, i)),
      ...(warm ? [element("p", {className: "note"}, "The command starts cold; this attempt did not.")] : []),
      element("p", {}, link));
    content.scrollTop = 0;
  }

  function steps(data) {
    const bar = state.drawer.querySelector(".steps"), {hits, place} = state;
    bar.replaceChildren();
    if (hits.length < 2) return;
    for (const [text, by] of [["previous", -1], ["next", 1]]) {
      const button = element("button", {type: "button"}, text);
      button.addEventListener("click", () => {
        state.place = (place + by + hits.length) % hits.length;
        render(data);
        [...bar.querySelectorAll("button")].find((other) => other.textContent === text).focus();
      });
      bar.append(button);
    }
    bar.append(element("span", {}, `${place + 1} of ${hits.length} here`));
  }

  function render(data) {
    const i = state.hits[state.place];
    fill(data, i);
    steps(data);
    history.replaceState(null, "", HASH + data.id(i));
    document.dispatchEvent(new CustomEvent("attempt", {detail: i}));
  }

  // Open the drawer at the first of some rows, which lie at one place of the plot.
  function show(data, hits) {
    if (!hits.length) return;
    problem.textContent = "";
    state.drawer ??= build();
    if (state.drawer.hidden) state.before = document.activeElement;
    Object.assign(state, {hits, place: 0});
    state.drawer.hidden = false;
    render(data);
    state.drawer.focus({preventScroll: true});
  }

  function hide() {
    history.replaceState(null, "", location.pathname + location.search);
    close();
  }

  function close() {
    state.drawer.hidden = true;
    if (state.before && state.before.isConnected) state.before.focus({preventScroll: true});
    document.dispatchEvent(new CustomEvent("attempt", {detail: -1}));
  }

  async function openAddress() {
    problem.textContent = "";
    if (!location.hash.startsWith(HASH)) return;
    const data = await open(), id = location.hash.slice(HASH.length);
    let i = -1, reason = "this page holds none of that name";
    try {
      i = data.find(id);
    } catch (error) { // no text in percent-encoding
      reason = error.message;
    }
    if (i >= 0) {
      show(data, [i]);
      return;
    }
    if (state.drawer && !state.drawer.hidden) close();
    problem.textContent = `The address opens no attempt: ${reason}. Expected: an address that “link `
      + "to this attempt” gives, of a page of the same rows.";
    problem.closest("details").open = true;
    problem.scrollIntoView({behavior: "instant", block: "center"});
  }

  Object.assign(window.attempts, {show});
  window.addEventListener("hashchange", openAddress);
  openAddress();
})();
