"use strict";
// A card per run; a click opens its interactive page in a frame that may do nothing but run.

const runs = JSON.parse(document.getElementById("runs").textContent);
const shared = JSON.parse(document.getElementById("shared").textContent);
const VERDICTS = { passed: "✓ Checked", failed: "✗ Check failed", damaged: "✗ Could not be read" };
const MARK = "{{library}}";

const viewer = document.getElementById("viewer");
const frame = document.getElementById("frame");

/** Return a new element with attributes and children; text is never read as HTML. */
function element(name, attributes, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/** Show the interactive page of a run. */
function open(run) {
  const page = element("iframe", { sandbox: "allow-scripts", title: run.title });
  page.srcdoc = run.page.replace(MARK, () => shared);
  frame.replaceChildren(page);
  viewer.showModal();
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
  if (run.page) made.addEventListener("click", () => open(run));
  return made;
}

const cards = runs.map((run) => ({ run, shown: card(run), text: JSON.stringify([run.name, run.title, run.facts, VERDICTS[run.verdict]]).toLowerCase() }));
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
