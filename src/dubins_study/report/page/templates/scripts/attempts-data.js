"use strict";
// window.attempts: the embedded attempts. `open()` unpacks them once; `report/interactive/packing.py`
// says how they are packed.
window.attempts = (() => {
  const ARRAYS = {u1: Uint8Array, u2: Uint16Array, u4: Uint32Array, i2: Int16Array,
    f4: Float32Array, f8: Float64Array};
  const FLAGS = {false_claim: 1, wrong_basin: 2, presolved: 4};

  // The bytes of an embedded element that holds gzip in base64.
  async function unpacked(name) {
    const coded = atob(document.getElementById(`data-${name}-gz`).textContent.trim());
    const bytes = new Uint8Array(coded.length);
    for (let i = 0; i < coded.length; i += 1) bytes[i] = coded.charCodeAt(i);
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  // An array out of its planes: the first bytes of all its numbers, then their second bytes, ...
  function array(bytes, [type, offset, count]) {
    const Kind = ARRAYS[type], size = Kind.BYTES_PER_ELEMENT;
    const whole = new Uint8Array(count * size);
    for (let plane = 0; plane < size; plane += 1) {
      const from = offset + plane * count;
      for (let i = 0; i < count; i += 1) whole[i * size + plane] = bytes[from + i];
    }
    return new Kind(whole.buffer);
  }

  // Sums of all that comes before: where each row's numbers begin in an array of all rows'.
  function starts(counts) {
    const begin = new Uint32Array(counts.length + 1);
    for (let i = 0; i < counts.length; i += 1) begin[i + 1] = begin[i] + counts[i];
    return begin;
  }

  class Attempts {
    constructor(bytes, header) {
      this.count = header.count;
      this.texts = header.texts;
      this.scenarios = header.scenarios;
      this.solvers = header.solvers; // {spec, label, formulation, engine, colour, marker, angle}
      this.timeLimits = header.time_limits; // s, by experiment
      this.columns = {};
      for (const [name, entry] of Object.entries(header.arrays)) {
        this.columns[name] = array(bytes, entry);
      }
      const {arcs, points} = this.columns;
      this.arcStart = starts(arcs);
      this.pointStart = starts(points);
      this.boxStart = starts(points.map((number) => (number ? 1 : 0)));
    }

    // A text of a row; null where it has none.
    text(name, i) {
      const code = this.columns[name][i];
      return code ? this.texts[name][code - 1] : null;
    }

    has(flag, i) {
      return (this.columns.flags[i] & FLAGS[flag]) !== 0;
    }

    ofScenario(name, i) {
      return this.scenarios[name][this.columns.scenario[i]];
    }

    // A text of a row, of the attempt or of its scenario; "" where it has none.
    anyText(name, i) {
      return (name in this.texts ? this.text(name, i) : this.ofScenario(name, i)) ?? "";
    }

    // The texts that occur in a column, sorted.
    valuesOf(name) {
      const values = new Set();
      for (let i = 0; i < this.count; i += 1) values.add(this.anyText(name, i));
      return [...values].sort(window.studyTables.compareTexts);
    }

    scenario(i) {
      const names = ["x", "y", "heading", "target_x", "target_y", "radius", "speed"];
      return Object.fromEntries(names.map((name) => [name, this.ofScenario(name, i)]));
    }

    // What names an attempt in every report of the same rows.
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

    // The points [x, y] of a row's path; null where there is none that can be drawn.
    path(i) {
      const {arcs, points} = this.columns;
      const line = arcs[i] ? this.arcsPath(i) : points[i] ? this.linePath(i) : null;
      return line && line.flat().every(Number.isFinite) ? line : null;
    }

    arcsPath(i) {
      const {turns, drives} = this.columns, scenario = this.scenario(i);
      const range = [this.arcStart[i], this.arcStart[i + 1]];
      const rates = [...turns.subarray(...range)].map((turn) => turn / scenario.radius);
      // Full turns beyond the first of an arc would be drawn over each other.
      const lengths = [...drives.subarray(...range)].map((drive, k) => {
        const circle = 2 * Math.PI / Math.abs(rates[k] * scenario.radius);
        return (drive > 2 * circle ? circle + drive % circle : drive) * scenario.radius;
      });
      return window.dubins.polyline(scenario, rates, lengths, 120);
    }

    linePath(i) {
      const {boxes, steps} = this.columns, total = steps.length / 2;
      const box = 3 * this.boxStart[i];
      const line = [];
      let column = 0, row = 0;
      for (let k = this.pointStart[i]; k < this.pointStart[i + 1]; k += 1) {
        column += steps[k];
        row += steps[total + k];
        line.push([boxes[box] + column * boxes[box + 2], boxes[box + 1] + row * boxes[box + 2]]);
      }
      return line;
    }
  }

  let opened = null;
  function open() {
    opened ??= Promise.all([unpacked("attempts"), unpacked("attempts-header")]).then(
      ([bytes, text]) => new Attempts(bytes, JSON.parse(new TextDecoder().decode(text))));
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
