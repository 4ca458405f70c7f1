"use strict";
// Formulas as text: what is copied of a formula is its LaTeX, and a button copies it in one click.

// Appends a name: as a symbol, if it is one.
function symbol(parent, symbols, name) {
  if (symbols && symbols[name]) parent.insertAdjacentHTML("beforeend", symbols[name]);
  else parent.append(name);
}

// Puts buttons beside the equations of a part of the page that copy one as LaTeX, SymPy or text. Those of an equation are
// one stop of the Tab key; the arrow keys go from one to the next.
function copyable(root) {
  for (const equation of root.querySelectorAll(".equation")) {
    const formula = equation.querySelector(".formula");
    if (!formula || equation.querySelector("button")) continue;
    const box = document.createElement("span");
    box.className = "copy";
    box.setAttribute("role", "toolbar");
    box.setAttribute("aria-label", "Copy this equation");
    for (const [title, text] of [["LaTeX", formula.dataset.tex], ["SymPy", equation.dataset.sympy], ["text", formula.getAttribute("aria-label")]]) {
      if (!text) continue;
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = title;
      button.tabIndex = box.children.length ? -1 : 0;
      button.setAttribute("aria-label", `Copy this equation as ${title}`);
      button.addEventListener("click", () => {
        const put = (event) => (event.clipboardData.setData("text/plain", text), event.preventDefault());
        document.addEventListener("copy", put, { once: true });
        button.textContent = document.execCommand("copy") ? "copied" : "not allowed";
        document.removeEventListener("copy", put);
        setTimeout(() => (button.textContent = title), 1200);
      });
      box.append(button);
    }
    box.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key], all = [...box.children], now = all.indexOf(document.activeElement);
      if (!step || now < 0) return;
      const next = all[(now + step + all.length) % all.length];
      for (const button of all) button.tabIndex = button === next ? 0 : -1;
      next.focus();
      event.preventDefault();
    });
    equation.append(box);
  }
}

// Returns the text of what is selected, with formulas as LaTeX between dollar signs; nothing if there are none.
function selected(selection) {
  if (!selection.rangeCount || selection.isCollapsed) return "";
  const range = selection.getRangeAt(0), near = range.commonAncestorContainer, holder = document.createElement("div");
  const around = (near.nodeType === 1 ? near : near.parentElement).closest(".formula");
  if (around) return `$${around.dataset.tex}$`;
  holder.append(range.cloneContents());
  const formulas = [...holder.querySelectorAll(".formula")];
  for (const formula of formulas) formula.replaceWith(`$${formula.dataset.tex}$`);
  for (const block of holder.querySelectorAll("div, p, tr, li, h2, h3")) block.append("\n");
  for (const box of holder.querySelectorAll(".copy, svg")) box.remove();
  return formulas.length ? holder.textContent : "";
}

document.addEventListener("copy", (event) => {
  const text = !event.defaultPrevented && selected(document.getSelection());
  if (!text) return;
  event.clipboardData.setData("text/plain", text);
  event.preventDefault();
});
copyable(document);
