"use strict";
// window.studyTables: sort by a column, filter by words, fold long tables.
//
// A table is complete without this script. Sorting reads the number behind a cell (`data-value`)
// where there is one, and otherwise the cell's text with its numbers as numbers: 10, 20, 160.
window.studyTables = (() => {
  const FILTER_FROM = 13; // lines from which a table gets a filter
  const FOLD_FROM = 41, FOLDED = 12; // lines from which a table is folded, and lines left then
  const NUMBER = /\d+(?:\.\d+)?(?:e[+-]?\d+)?/gi;
  const FIRST_NUMBER = /^[+\u2212-]?[\d.]/; // two minus signs: the page's and the keyboard's
  const ABSENT = new Set(["", "–", "-"]);
  const NEXT = {none: "ascending", ascending: "descending", descending: "none"};

  function element(name, properties = {}, ...children) {
    const node = Object.assign(document.createElement(name), properties);
    node.append(...children);
    return node;
  }

  // A text as alternating words and numbers, for `compareTexts`.
  function pieces(text) {
    const words = text.toLowerCase().split(NUMBER);
    const numbers = (text.match(NUMBER) || []).map(Number);
    return words.flatMap((word, i) => (i < numbers.length ? [word, numbers[i]] : [word]));
  }

  function comparePieces(a, b) {
    for (let i = 0; i < Math.min(a.length, b.length); i += 1) {
      if (a[i] < b[i]) return -1;
      if (a[i] > b[i]) return 1;
    }
    return a.length - b.length;
  }

  function compareTexts(a, b) {
    return comparePieces(pieces(a), pieces(b));
  }

  // The key that a cell is sorted by: a number, pieces of text, or null for a cell without a value.
  // In a column of numbers as text, a cell that begins with no number has none: `[2]`, `none`.
  function key(cell, numeric) {
    if (cell.dataset.value !== undefined) return Number(cell.dataset.value);
    const text = cell.textContent.trim();
    if (cell.classList.contains("cell") && !FIRST_NUMBER.test(text)) return null;
    return numeric || ABSENT.has(text) ? null : pieces(text);
  }

  function compareKeys(a, b) {
    return typeof a === "number" ? a - b : comparePieces(a, b);
  }

  // The lines in the order of a column; lines without a value come last either way.
  function sorted(lines, column, direction) {
    if (direction === "none") return [...lines];
    const sign = direction === "ascending" ? 1 : -1;
    const numeric = lines.some((line) => line.cells[column].dataset.value !== undefined);
    const keyed = lines.map((line) => [key(line.cells[column], numeric), line]);
    const present = keyed.filter(([value]) => value !== null && !Number.isNaN(value));
    const rest = keyed.filter(([value]) => value === null || Number.isNaN(value));
    present.sort((a, b) => sign * compareKeys(a[0], b[0]));
    return [...present, ...rest].map(([, line]) => line);
  }

  // The text that the filter searches: the line's text, and the full names that it shows on hover.
  function searchable(line) {
    const titles = [...line.querySelectorAll("[title]")].map((node) => node.title);
    const text = [line.textContent, ...titles].join(" ");
    return text.replace(/[\u202f\u00a0]/g, "").toLowerCase();
  }

  // Make a table sortable; `update` is called after its lines were changed by another script.
  function enhance(table) {
    const head = table.tHead && table.tHead.rows[0], body = table.tBodies[0];
    if (!head || !body || table.dataset.enhanced) return null;
    table.dataset.enhanced = "yes";
    const state = {lines: [...body.rows], words: [], open: false, texts: new Map()};
    const tools = {};

    function show() {
      const matching = state.lines.filter((line) => matches(line));
      const folded = state.lines.length >= FOLD_FROM && !state.open;
      const kept = new Set(matching), first = new Set(folded ? matching.slice(0, FOLDED) : matching);
      for (const line of body.rows) {
        line.classList.toggle("filtered", !kept.has(line));
        line.classList.toggle("folded", kept.has(line) && !first.has(line));
      }
      report(matching.length, folded && matching.length > FOLDED);
    }

    function matches(line) {
      if (!state.words.length) return true;
      if (!state.texts.has(line)) state.texts.set(line, searchable(line));
      return state.words.every((word) => state.texts.get(line).includes(word));
    }

    function report(matching, cut) {
      if (!tools.bar) return;
      const all = state.lines.length;
      const counted = state.words.length ? `${matching} of ${all}` : `${all} lines`;
      tools.count.textContent = cut ? `${counted}, the first ${FOLDED} shown` : counted;
      tools.fold.hidden = all < FOLD_FROM || (!state.open && !cut);
      tools.fold.textContent = state.open ? "show fewer" : `show all ${matching}`;
      tools.fold.setAttribute("aria-expanded", String(state.open));
    }

    function sortBy(header) {
      const direction = NEXT[header.getAttribute("aria-sort")];
      for (const other of head.cells) other.setAttribute("aria-sort", "none");
      header.setAttribute("aria-sort", direction);
      state.lines = sorted(state.original, header.cellIndex, direction);
      body.append(...state.lines);
      show();
    }

    function update() {
      state.original = [...body.rows];
      state.lines = [...body.rows];
      state.texts.clear();
      const header = [...head.cells].find((cell) => !["none", null].includes(cell.ariaSort));
      if (header) {
        state.lines = sorted(state.original, header.cellIndex, header.ariaSort);
        body.append(...state.lines);
      }
      addTools();
      show();
    }

    function addTools() {
      if (tools.bar || state.lines.length < FILTER_FROM) return;
      tools.box = element("input", {type: "search", autocomplete: "off", spellcheck: false});
      tools.count = element("output", {className: "count"});
      tools.fold = element("button", {type: "button", className: "fold"});
      const label = element("label", {}, "filter ", tools.box);
      tools.bar = element("div", {className: "table-tools"}, label, tools.count, tools.fold);
      tools.box.addEventListener("input", () => {
        state.words = tools.box.value.toLowerCase().split(/\s+/).filter(Boolean);
        show();
      });
      tools.fold.addEventListener("click", () => {
        state.open = !state.open;
        show();
      });
      const frame = table.closest(".scroll") || table;
      if (state.lines.length >= FOLD_FROM) frame.classList.remove("tall");
      frame.before(tools.bar);
    }

    for (const header of head.cells) {
      if (!header.textContent.trim()) continue; // a button would have no name
      const button = element("button", {type: "button", className: "sort"}, ...header.childNodes);
      header.append(button);
      header.setAttribute("aria-sort", "none");
      button.addEventListener("click", () => sortBy(header));
    }
    update();
    return {update};
  }

  document.querySelectorAll("figure.table table").forEach(enhance);
  return {enhance, compareTexts, element};
})();
