"use strict";
// window.explorerNumbers: how the explorer writes numbers.
window.explorerNumbers = (() => {
  // Six significant digits, with a minus sign that is one; tiny and huge numbers with a power of ten.
  function number(value, digits = 6) {
    const rounded = Number(value.toPrecision(digits)), size = Math.abs(rounded);
    if (size !== 0 && (size < 1e-4 || size >= 1e6)) return powered(value, digits);
    return String(rounded).replace("-", "−");
  }

  function powered(value, digits) {
    const [mantissa, power] = value.toExponential(digits - 1).split("e");
    return `${Number(mantissa)}e${Number(power)}`.replaceAll("-", "−");
  }

  // Four digits, in a few characters: for ticks.
  function brief(value) {
    const plain = number(value, 4);
    return plain.length > 5 ? powered(value, 4) : plain;
  }

  const degrees = (angle, digits = 4) => `${number(angle * 180 / Math.PI, digits)}°`;

  // The pieces of a path in words: turns as angles, straights in radii.
  function segments({word, segments: lengths}) {
    return [...word].map((letter, i) => (letter === "S"
      ? `S\u00a0${number(lengths[i], 5)}\u00a0R` : `${letter}\u00a0${degrees(lengths[i])}`)).join(", ");
  }

  return {number, brief, degrees, segments};
})();

// window.explorerAnswers(root): the explorer's table and sentences. Everything is set as text.
window.explorerAnswers = (root) => {
  const {set, write} = window.svgElements;
  const SHORTEST = "shortest";
  const rows = new Map();
  for (const row of root.querySelectorAll("tr[data-branch]")) {
    const cells = {};
    for (const cell of row.querySelectorAll("[data-cell]")) cells[cell.dataset.cell] = cell;
    rows.set(row.dataset.branch, {row, cells});
  }
  const place = root.querySelector("[data-answer=place]");
  // The summary is shown in every frame of a drag (`summary`, hidden from screen readers). Screen
  // readers speak it once the drag rests (`spoken`, not visible).
  const summary = root.querySelector("[data-answer=summary]");
  const spoken = root.querySelector("[data-answer=spoken]");

  const {number, degrees, segments: segmentsOf} = window.explorerNumbers;

  // Why a word has no path.
  function absence(branch, {X, Y}) {
    const [first, second] = branch, side = first === "L" ? "left" : "right";
    if (second === "S") return `no path: the target is inside the ${side} turning circle`;
    const distance = Math.hypot(X, Y - (first === "L" ? 1 : -1));
    const what = distance > 3 ? "more than 3 R" : "less than 1 R";
    return `no path: ${what} (${number(distance, 4)} R) from the ${side} circle's centre`;
  }

  // What the certificate says, in words (docs/derivation.md, sections 9 and 10).
  function verdict(entry, certificate, tied) {
    const {segments, word} = entry;
    if (word === "") return "nothing to drive";
    if (certificate.verdict === "no extremal") {
      const [a, b] = segments;
      if (b <= Math.PI) return `not the shortest: its second arc turns by ${degrees(b)}, not by more than 180°`;
      if (a > b) return "not the shortest: its first arc turns by more than its second";
      return "not the shortest: a turn goes the wrong way";
    }
    if (certificate.verdict === SHORTEST) {
      if (word === "S") return "the shortest: a straight line";
      if (tied) return "another word is as short";
      return "proved the shortest";
    }
    return "another word is shorter";
  }

  function evidence(entry, found) {
    if (!entry.word || found.sign_margin === null) return "";
    const size = found.abnormal ? "ν₀ = 0, " : "ν₀ = 1, ";
    const sign = Math.abs(found.sign_margin) < 1e-12 ? 0 : found.sign_margin;
    const cut = found.extremal ? `; cut margin ${degrees(found.cut_margin)}` : "";
    return `${size}ν₁ = ${number(found.costate_x, 4)}, ν₂ = ${number(found.costate_y, 4)}; `
      + `largest |H| ${found.hamiltonian < 1e-12 ? "0" : number(found.hamiltonian, 2)}; `
      + `least −u\u00a0ν₃\u00a0${number(sign, 3)}${cut}`;
  }

  function over(entry, best) {
    if (entry.optimal) return SHORTEST;
    const excess = entry.length - best.length;
    return best.length > 0 ? `+${number(100 * excess / best.length, 3)} %` : `+${number(excess, 4)}`;
  }

  // Returns the summary.
  function fill(scenario, entries) {
    const best = entries.find((entry) => entry.optimal), local = window.dubins.local(scenario);
    const tied = new Set(entries.filter((entry) => entry.optimal).map((entry) => entry.word)).size > 1;
    for (const entry of entries) {
      const {row, cells} = rows.get(entry.branch);
      row.classList.toggle("optimal", entry.optimal);
      row.classList.toggle("absent", !entry.exists);
      write(cells.mark, entry.optimal ? "✓" : "");
      set(cells.mark, {title: entry.optimal ? "the shortest path" : ""});
      const {certificate} = entry;
      const texts = entry.exists ? {
        path: segmentsOf(entry) || "nothing: the target is at the start",
        radii: number(entry.length / scenario.radius),
        length: number(entry.length),
        over: over(entry, best),
        certificate: verdict(entry, certificate, tied && entry.optimal),
        evidence: evidence(entry, certificate),
      } : {path: "–", radii: "–", length: "–", over: "–", certificate: absence(entry.branch, local), evidence: ""};
      for (const [name, text] of Object.entries(texts)) write(cells[name], text);
      set(cells.length, {"data-value": entry.exists ? entry.length : ""});
    }
    const text = summaryOf(scenario, best, tied);
    write(summary, text);
    write(place, placeOf(scenario, best));
    return text;
  }

  function placeOf(scenario, best) {
    if (!best.word) return "The target is the start, where both turning circles meet.";
    const region = window.dubins.region(scenario), margin = number(window.dubins.margin(scenario), 4);
    const where = {
      outside: `outside both turning circles, ${margin} R from the nearer one`,
      circle: "on a turning circle: one arc reaches it, and next to it the length jumps or bends",
      "left disc": `inside the left turning circle, ${margin} R from it: no left turn reaches it at once, so the path turns right first`,
      "right disc": `inside the right turning circle, ${margin} R from it: no right turn reaches it at once, so the path turns left first`,
    };
    return `The target lies ${where[region]}.`;
  }

  function summaryOf(scenario, best, tied) {
    if (!best.word) return "Shortest: nothing to drive, length 0.";
    const words = tied ? "LS and RS, which tie" : best.word;
    return `Shortest: ${words}, length ${number(best.length)} (${number(best.length / scenario.radius)} R).`;
  }

  function announce(text) {
    write(spoken, text);
  }

  return {fill, announce};
};
