"use strict";
// The list of solvers of which at most ten are coloured: by formulation or by engine, with a filter.
(() => {
  const {element} = window.studyTables;

  function solverList(data, state, changed, most) {
    const summary = element("summary"), groups = element("div", {className: "groups"});
    const box = element("input", {type: "search", autocomplete: "off", spellcheck: false});
    const by = element("select", {}, element("option", {value: "formulation"}, "formulation"),
      element("option", {value: "engine"}, "engine"));
    const none = element("button", {type: "button"}, "none");
    const note = element("p", {className: "note"});
    note.setAttribute("role", "status");
    const boxes = new Map();

    function describe() {
      const full = state.chosen.length >= most;
      summary.textContent = `solvers: ${state.chosen.length} of ${data.solvers.length} coloured`;
      note.textContent = full ? `${most} are coloured; take one away to colour another` : "";
      for (const [k, input] of boxes) {
        input.checked = state.chosen.includes(k);
        input.disabled = full && !input.checked;
      }
    }

    function choose(chosen) {
      state.chosen = chosen.slice(0, most);
      describe();
      changed("solvers");
    }

    function toggle(k, on) {
      choose(on ? [...state.chosen, k] : state.chosen.filter((other) => other !== k));
    }

    function matches({label, spec}) {
      const text = `${label} ${spec}`.toLowerCase();
      return box.value.toLowerCase().split(/\s+/).every((word) => text.includes(word));
    }

    function line(solver, k) {
      const input = element("input", {type: "checkbox"});
      input.addEventListener("change", () => toggle(k, input.checked));
      boxes.set(k, input);
      return element("label", {title: solver.spec}, input, ` ${solver.label}`);
    }

    function list() {
      boxes.clear();
      const members = new Map();
      data.solvers.forEach((solver, k) => {
        if (!matches(solver)) return;
        if (!members.has(solver[by.value])) members.set(solver[by.value], []);
        members.get(solver[by.value]).push(k);
      });
      groups.replaceChildren(...[...members].map(([name, each]) => {
        const text = each.length > most ? `first ${most}` : "only these";
        const only = element("button", {type: "button", ariaLabel: `${text} of ${name}`}, text);
        only.addEventListener("click", () => choose(each));
        return element("fieldset", {}, element("legend", {}, `${name} `, only),
          ...each.map((k) => line(data.solvers[k], k)));
      }));
      if (!members.size) groups.append(element("p", {}, "no solver has these words in its name"));
      describe();
    }

    box.addEventListener("input", list);
    by.addEventListener("change", list);
    none.addEventListener("click", () => choose([]));
    list();
    const node = element("details", {className: "solvers"}, summary,
      element("div", {className: "buttons"}, element("label", {}, "filter ", box), " ",
        element("label", {}, "by ", by), " ", none), note, groups);
    state.drop = (k) => toggle(k, false); // for the legend
    return node;
  }

  Object.assign(window.attempts, {solverList});
})();
