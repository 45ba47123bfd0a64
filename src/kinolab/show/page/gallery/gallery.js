"use strict";
// A card per run; a click opens its interactive page in a frame that may do nothing but run.

const runs = JSON.parse(document.getElementById("runs").textContent);
const shared = JSON.parse(document.getElementById("shared").textContent);
const VERDICTS = { passed: "✓ Checked", failed: "✗ Check failed", damaged: "✗ Could not be read" };
const MARK = "<library>";

const viewer = document.getElementById("viewer");
const frame = document.getElementById("frame");

/** Return a new element with attributes and children; text is never read as HTML. */
function element(name, attributes, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/** Show the interactive pages of runs side by side; what one of them plays the others play too. */
function open(...shown) {
  const pages = shown.map((run) => {
    const page = element("iframe", { sandbox: "allow-scripts", title: run.title });
    page.srcdoc = run.page.replace(MARK, () => shared);
    return page;
  });
  frame.replaceChildren(...pages.map((page, k) => (shown.length > 1 ? element("figure", {}, element("figcaption", {}, caption(shown[k])), page) : page)));
  viewer.showModal();
}

function caption({ name, facts }) {
  return [name, ...facts.map(([label, value]) => `${label}: ${value}`)].join(" · ");
}

window.addEventListener("message", ({ source, data }) => {
  if (data?.kinolab !== "clock") return;
  const frames = [...frame.querySelectorAll("iframe")].map((page) => page.contentWindow);
  if (frames.includes(source)) frames.filter((other) => other !== source).forEach((other) => other.postMessage({ ...data, kinolab: "follow" }, "*"));
});

const selected = new Set(); // runs to be compared
const compare = document.getElementById("compare");
compare.addEventListener("click", () => open(...selected));

/** A box that selects a run for comparison; of more than two the first one is given up. */
function selection(run) {
  const box = element("input", { type: "checkbox", "aria-label": `Compare ${run.title} (${run.name})` });
  box.addEventListener("change", () => {
    if (box.checked) selected.add(run); else selected.delete(run);
    if (selected.size > 2) selected.delete([...selected][0]);
    cards.forEach((one) => { if (one.box) one.box.checked = selected.has(one.run); });
    compare.hidden = selected.size !== 2;
  });
  return box;
}

function card(run) {
  const facts = run.facts.flatMap(([label, value]) => [element("dt", {}, label), element("dd", {}, value)]);
  const made = element(
    run.page ? "button" : "article", { class: "card" },
    run.poster ? element("img", { src: run.poster, alt: "", loading: "lazy" }) : element("span", { class: "none" }, "no picture"),
    element(
      "div", { class: "text" },
      element("h2", {}, run.title), element("p", {}, run.name),
      element("p", { class: run.verdict }, VERDICTS[run.verdict]), element("dl", {}, ...facts),
    ),
  );
  if (!run.page) return { shown: made };
  made.addEventListener("click", () => open(run));
  const box = selection(run);
  return { shown: element("div", { class: "slot" }, made, element("label", { class: "pick" }, box, "compare")), box };
}

const cards = runs.map((run) => ({ run, ...card(run), text: JSON.stringify([run.name, run.title, run.facts, VERDICTS[run.verdict]]).toLowerCase() }));
document.getElementById("cards").append(...cards.map((one) => one.shown));

/** Show the cards that contain all words of the filter, and say how many passed. */
function filter() {
  const words = document.getElementById("filter").value.toLowerCase().split(/\s+/);
  for (const one of cards) one.shown.hidden = !words.every((word) => one.text.includes(word));
  const left = cards.filter((one) => !one.shown.hidden);
  const passed = left.filter((one) => one.run.verdict === "passed").length;
  document.getElementById("count").textContent = `${left.length} of ${cards.length} runs, ${passed} passed the check`;
}

document.getElementById("filter").addEventListener("input", filter);
viewer.addEventListener("close", () => frame.replaceChildren());
filter();
