"use strict";
// window.attempts: the embedded attempts. `open()` unpacks them on its first call.
// `report/topics/single_attempts.py:packed` says how they are packed.
window.attempts = (() => {
  const FINEST = 0.15; // rad of a turn between two points of a drawn path

  // The text of an embedded element that holds gzip in base64.
  async function unpacked(name) {
    const coded = atob(document.getElementById(`data-${name}-gz`).textContent.trim());
    const bytes = new Uint8Array(coded.length);
    for (let i = 0; i < coded.length; i += 1) bytes[i] = coded.charCodeAt(i);
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  }

  class Attempts {
    constructor(content) {
      this.count = content.count;
      this.texts = content.texts;
      this.scenarios = content.scenarios;
      this.solvers = content.solvers; // {spec, label, formulation, engine, colour, marker, angle}
      this.paths = content.paths;
      this.columns = {};
      for (const [name, values] of Object.entries(content.columns)) {
        this.columns[name] = values.map((value) => (value === null ? NaN : Number(value)));
      }
    }

    // The text of row `i` in a column; null if the row has no text there.
    text(name, i) {
      const code = this.columns[name][i];
      return code ? this.texts[name][code - 1] : null;
    }

    has(flag, i) {
      return this.columns[flag][i] === 1;
    }

    ofScenario(name, i) {
      return this.scenarios[name][this.columns.scenario[i]];
    }

    // The text of row `i` in a column of attempts or of scenarios; "" if there is none.
    anyText(name, i) {
      return (name in this.texts ? this.text(name, i) : this.ofScenario(name, i)) ?? "";
    }

    // The texts that occur in a column, sorted.
    valuesOf(name) {
      const values = new Set();
      for (let i = 0; i < this.count; i += 1) values.add(this.anyText(name, i));
      return [...values].sort(window.studyTables.compareTexts);
    }

    // The scenario of a row as it is drawn. If the start heading is free, the path's own is taken.
    // If there is no target, a closed path ends at the start, and another one at the last via
    // point.
    scenario(i) {
      const names = ["x", "y", "heading", "target_x", "target_y", "radius", "speed"];
      const drawn = Object.fromEntries(names.map((name) => [name, this.ofScenario(name, i)]));
      drawn.heading ??= this.columns.start_heading?.[i] ?? 0;
      drawn.has_target = drawn.target_x !== null;
      if (!drawn.has_target) {
        const {via_x, via_y, closed} = this.route(i);
        [drawn.target_x, drawn.target_y] = closed ? [drawn.x, drawn.y] : [via_x.at(-1), via_y.at(-1)];
      }
      return drawn;
    }

    // The via points of a row's scenario with the headings there, the final heading (null if it is
    // free), the order, and whether the path is closed.
    route(i) {
      const given = (name) => this.scenarios[name]?.[this.columns.scenario[i]] ?? null;
      return {via_x: given("via_x") ?? [], via_y: given("via_y") ?? [],
        via_heading: given("via_heading") ?? [], final_heading: given("final_heading"),
        order: given("order") ?? "given", closed: given("closed") ?? false};
    }

    // The id of an attempt, for the page's address. Every report of the same rows has the same id.
    id(i) {
      const names = ["experiment", "solver", "branch", "initial_guess", "profile"];
      const parts = names.map((name) => this.text(name, i) ?? "");
      return [this.ofScenario("scenario_id", i), this.columns.repeat[i], ...parts]
        .map((part) => encodeURIComponent(part)).join("/");
    }

    find(id) {
      const scenario = decodeURIComponent(id.split("/")[0]);
      for (let i = 0; i < this.count; i += 1) {
        if (this.ofScenario("scenario_id", i) === scenario && this.id(i) === id) return i;
      }
      return -1;
    }

    // The rows of a solver's worst attempts, the worst first.
    worst(solver) {
      const rows = [], {worst} = this.columns;
      for (let i = 0; i < this.count; i += 1) {
        if (worst[i] && this.columns.solver[i] === solver + 1) rows.push(i);
      }
      return rows.sort((a, b) => worst[a] - worst[b]);
    }

    // The number of the solver whose worst attempts are shown first: a plug-in's, or else the one
    // with most false claims whose paths are visibly wrong.
    telling() {
      const own = this.solvers.findIndex((solver) => solver.own);
      return own >= 0 ? own : this.mostFalse();
    }

    // The solvers that are coloured at first: at most three, each with its own colour and marker.
    opening() {
      const own = this.solvers.map((_, k) => k).filter((k) => this.solvers[k].own), chosen = [];
      for (const k of [...own, this.mostFalse()]) {
        const alike = (other) => this.solvers[other].colour === this.solvers[k].colour
          || this.solvers[other].marker === this.solvers[k].marker;
        if (chosen.length < 3 && !chosen.some(alike)) chosen.push(k);
      }
      return chosen;
    }

    mostFalse() {
      const {gap, miss} = this.columns;
      const seen = (i) => this.has("false_claim", i) && this.path(i)
        && (gap[i] > 0.05 || miss[i] > 0.05 * this.ofScenario("radius", i));
      const most = this.solvers.map((_, k) => this.worst(k).filter(seen).length);
      return most.indexOf(Math.max(...most));
    }

    // The points [x, y] of a row's path; null if there is no path that can be drawn.
    path(i) {
      const arcs = this.paths[i];
      if (arcs === null) return null;
      const line = this.arcsPath(arcs, this.scenario(i));
      return line.flat().every(Number.isFinite) ? line : null;
    }

    // The path of a right attempt at the question of row `i`; null if no such attempt is embedded.
    rightPath(i) {
      const {scenario, branch, verdict} = this.columns;
      const right = this.texts.verdict.indexOf("optimal") + 1;
      for (let k = 0; k < this.count; k += 1) {
        if (scenario[k] === scenario[i] && branch[k] === branch[i] && verdict[k] === right) {
          const path = this.path(k);
          if (path) return path;
        }
      }
      return null;
    }

    arcsPath(arcs, scenario) {
      const rates = arcs.map(([turn]) => Number(turn) / scenario.radius);
      // An arc keeps at most one full turn: further ones would be drawn over it.
      const lengths = arcs.map(([turn, drive]) => {
        const circle = 2 * Math.PI / Math.abs(Number(turn)), driven = Number(drive);
        return (driven > 2 * circle ? circle + driven % circle : driven) * scenario.radius;
      });
      const turned = rates.reduce((sum, rate, k) => sum + Math.abs(rate * lengths[k]), 0);
      return window.dubins.polyline(scenario, rates, lengths, Math.max(120, turned / FINEST));
    }
  }

  let opened = null;
  function open() {
    opened ??= unpacked("attempts").then((text) => new Attempts(JSON.parse(text)));
    return opened;
  }

  // Call `start` once an element is about to come into view.
  function whenNear(place, start) {
    const watcher = new IntersectionObserver((entries) => {
      if (!entries.some((entry) => entry.isIntersecting)) return;
      watcher.disconnect();
      start();
    }, {rootMargin: "300px"});
    watcher.observe(place);
  }

  return {open, unpacked, whenNear};
})();
