"use strict";
// The worst attempts of a chosen solver as small pictures; each opens the drawer.
(() => {
  const place = document.getElementById("attempts-worst");
  if (!place) return;
  const {element} = window.studyTables;
  const {picture, number, show, open, whenNear} = window.attempts;

  function choice(data) {
    const select = element("select", {id: "worst-solver"});
    const groups = new Map();
    data.solvers.forEach((solver, k) => {
      if (!groups.has(solver.formulation)) {
        groups.set(solver.formulation, element("optgroup", {label: solver.formulation}));
        select.append(groups.get(solver.formulation));
      }
      const option = element("option", {value: String(k), title: solver.spec}, solver.label);
      groups.get(solver.formulation).append(option);
    });
    return select;
  }

  // The rows of a solver's worst attempts, the worst first.
  function worst(data, solver) {
    const rows = [];
    for (let i = 0; i < data.count; i += 1) {
      if (data.columns.worst[i] && data.columns.solver[i] === solver + 1) rows.push(i);
    }
    return rows.sort((a, b) => data.columns.worst[a] - data.columns.worst[b]);
  }

  function caption(data, i) {
    const {gap, miss, curvature_excess} = data.columns, radius = data.ofScenario("radius", i);
    const verdict = data.has("false_claim", i)
      ? `false claim: ${data.text("claim", i)}, ${data.text("verdict", i)}` : data.text("verdict", i);
    const much = !Number.isNaN(gap[i]) ? `gap ${number(gap[i])}`
      : curvature_excess[i] > miss[i] / radius ? `curvature ${number(1 + curvature_excess[i])} / R`
        : Number.isNaN(miss[i]) ? "no path" : `miss ${number(miss[i] / radius)} R`;
    return `${verdict}; ${much}`;
  }

  function card(data, i) {
    const button = element("button", {type: "button", className: "card"},
      picture(data, i, {width: 180, height: 150, labels: false}),
      element("span", {}, caption(data, i)),
      element("span", {className: "note"}, data.ofScenario("label", i) || data.ofScenario("region", i) || ""));
    button.addEventListener("click", () => show(data, [i]));
    return element("li", {}, button);
  }

  // The solver with most false claims whose paths can be seen to be wrong.
  function telling(data) {
    const {gap, miss} = data.columns;
    const seen = (i) => data.has("false_claim", i) && data.path(i)
      && (gap[i] > 0.05 || miss[i] > 0.05 * data.ofScenario("radius", i));
    const most = data.solvers.map((_, k) => worst(data, k).filter(seen).length);
    return most.indexOf(Math.max(...most));
  }

  async function start() {
    const data = await open();
    const select = choice(data), list = element("ol", {className: "cards"});
    const update = () => list.replaceChildren(
      ...worst(data, Number(select.value)).map((i) => card(data, i)));
    select.addEventListener("change", update);
    select.value = String(telling(data));
    place.append(element("label", {htmlFor: select.id}, "solver "), select, list);
    update();
    place.dataset.ready = "yes";
    document.dispatchEvent(new Event("laidout"));
  }

  whenNear(place, start);
})();
