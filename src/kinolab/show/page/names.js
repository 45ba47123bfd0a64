// Names as people write them: theta_x_dot is a theta with an index x and a dot above.

import { element } from "./dom.js";

const GREEK = { alpha: "α", beta: "β", gamma: "γ", delta: "δ", epsilon: "ε", zeta: "ζ", eta: "η", theta: "θ",
  kappa: "κ", lambda: "λ", mu: "μ", nu: "ν", xi: "ξ", rho: "ρ", sigma: "σ", tau: "τ", phi: "φ", chi: "χ", psi: "ψ", omega: "ω" };
const DOT = "\u0307"; // combining, above the letter before it
const TURN = /^(\w+?)_w([xyz])$/; // a rate of turn of an attitude, about an axis of the body

/** Return {letter, index, words} of a name: a symbol with its index, or words where it is none. */
export function symbolOf(name) {
  const turn = TURN.exec(name);
  if (turn) return { letter: "ω", index: turn[1] === "R" ? turn[2] : `${turn[1]} ${turn[2]}`, words: "" };
  const parts = name.split("_"), rate = parts.length > 1 && parts.at(-1) === "dot";
  if (rate) parts.pop();
  const [head, ...tail] = parts, found = /^([A-Za-z]+?)(\d*)$/.exec(head);
  const letter = found && (GREEK[found[1]] ?? (found[1].length === 1 ? found[1] : null));
  if (!letter) return { letter: "", index: "", words: parts.join(" ") + (rate ? ", rate" : "") };
  return { letter: letter + (rate ? DOT : ""), index: [found[2], ...tail].filter(Boolean).join(" "), words: "" };
}

/** Return a name as an element; what it is called in files is its title. */
export function named(name, tag = "span") {
  const { letter, index, words } = symbolOf(name), whole = element(tag, { class: "symbol", title: name });
  if (words) whole.append(words);
  else whole.append(element("var", {}, letter), ...(index ? [element("sub", {}, index)] : []));
  return whole;
}
