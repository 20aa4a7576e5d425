"use strict";
// window.explorerCopies(root): the scenario as a command, as Python and as a link, each with a button
// that copies it.
window.explorerCopies = (root) => {
  const {write} = window.svgElements, codes = {};
  for (const code of root.querySelectorAll("[data-copy]")) codes[code.dataset.copy] = code;
  for (const button of root.querySelectorAll("button[data-copies]")) {
    const label = button.textContent;
    button.addEventListener("click", async () => {
      const done = await copied(codes[button.dataset.copies]);
      button.textContent = done ? "copied" : "press Ctrl+C";
      setTimeout(() => { button.textContent = label; }, 1500);
    });
  }

  async function copied(code) {
    getSelection().selectAllChildren(code); // if the browser refuses, the text is selected for Ctrl+C
    try {
      await navigator.clipboard.writeText(code.textContent);
      return true;
    } catch {
      return document.execCommand("copy");
    }
  }

  // A heading as the command takes it: one of more than a turn only with its unit.
  const asOption = (written) => written.replace("°", "deg").replace(/\d$/, "$&rad").replace(/\s/g, "");

  function command({x, y, written, target_x, target_y, radius, via, final_written, order}) {
    const points = via.map(([u, v]) => ` --via ${u} ${v}`).join("");
    const final = final_written && ` --final-heading ${asOption(final_written)}`;
    const free = order === "free" ? " --order free" : "";
    return `dubins-study solve ${target_x} ${target_y} --from ${x} ${y} ${asOption(written)}${points}${free}${final} --radius ${radius}`;
  }

  const asPython = (written) => (/[a-z°]/i.test(written.replace(/e[+-]?\d+$/i, "")) ? `"${written}"` : written);

  function python({x, y, written, target_x, target_y, radius, via, final_written, order}) {
    const points = via.length ? `, via=[${via.map(([u, v]) => `(${u}, ${v})`).join(", ")}]` : "";
    const final = final_written && `, final_heading=${asPython(final_written)}`;
    const free = order === "free" ? ', order="free"' : "", shown = free && "answer.order, ";
    return `from dubins_study import Scenario, solve\n\nanswer = solve(Scenario(${x}, ${y}, ${asPython(written)}, `
      + `${target_x}, ${target_y}, radius=${radius}${points}${free}${final}))\nprint(${shown}answer.word, answer.length, answer.verdict)`;
  }

  return {
    fill(scenario, address) {
      write(codes.command, command(scenario));
      write(codes.python, python(scenario));
      write(codes.link, address);
    },
  };
};
