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

  async function start() {
    const data = await open();
    const select = choice(data), list = element("ol", {className: "cards"});
    const none = element("p", {className: "note"}, "None of its attempts is wrong.");
    const update = () => {
      const worst = data.worst(Number(select.value));
      list.replaceChildren(...worst.map((i) => card(data, i)));
      none.hidden = worst.length > 0;
    };
    select.addEventListener("change", update);
    select.value = String(data.telling());
    place.append(element("label", {htmlFor: select.id}, "solver "), select, list, none);
    update();
    place.dataset.ready = "yes";
    document.dispatchEvent(new Event("laidout"));
  }

  whenNear(place, start);
})();
