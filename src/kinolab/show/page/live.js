// What the page's own server tells of a search that goes on, by server-sent events.

import { buildBest } from "./best.js";
import { showStatus } from "./report.js";

/** Follow a search to its end; `growing` shows it and `changed` draws it anew. */
export function followSearch(address, growing, changed, byId) {
  const progress = buildBest();
  byId("panel").prepend(progress.whole);
  const source = new EventSource(address);
  const on = (kind, take) => source.addEventListener(kind, ({ data }) => take(data));
  const shown = (take) => (text) => { take(numbers(text)); changed(); };
  on("words", (words) => { byId("subtitle").textContent = words; });
  on("phase", (name) => { byId("badge").textContent = progress.phase(name); });
  on("best", (points) => progress.best(JSON.parse(points)));
  on("verdict", (told) => {
    const { status, message } = JSON.parse(told);
    showStatus(byId, status);
    byId("badge").dataset.verdict = status;
    byId("subtitle").textContent = message;
  });
  on("tree", shown(growing.grow));
  on("path", shown(growing.lead));
  on("end", (finished) => {
    source.close();
    if (finished) location.replace(finished);
    else ended(byId);
  });
  source.addEventListener("error", () => {
    source.close();
    ended(byId);
  });
}

function ended(byId) {
  if (!byId("badge").dataset.verdict) byId("badge").textContent = "The search has ended";
}

/** Read base64 of single precision. */
function numbers(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}
