// Areas of code in the page: room, a fixed width, numbers of lines, colours, and the lines at fault in red.
// Ctrl-Enter or Ctrl-S presses the button below; Tab indents. viser's own areas are plain and six lines high.
// And -0.5 can be typed as a number: what it begins with, -0, would be taken for 0, without its sign.

(() => {
  if (window.kinolabCode) return;
  window.kinolabCode = true;
  const style = document.createElement("style");
  style.textContent = `
    textarea.kl-code, pre.kl-code, pre.kl-lines { font: 12px/1.45 ui-monospace, Menlo, Consolas, monospace !important;
      padding: 6px 6px 6px 46px !important; margin: 0; white-space: pre; tab-size: 4; border: 1px solid transparent; }
    textarea.kl-code { background: transparent !important; color: transparent !important; caret-color: #1c7ed6;
      border-color: #ced4da; min-height: 50vh !important; max-height: none !important; overflow: auto !important; }
    textarea.kl-code::selection { background: #1c7ed655; }
    pre.kl-code, pre.kl-lines { position: absolute; inset: 0; overflow: hidden; pointer-events: none; }
    pre.kl-lines { right: auto; width: 38px; padding: 6px 6px 6px 0 !important; text-align: right; color: #868e96; }
    pre.kl-lines b { color: #fff; background: #e03131; }
    .kl-word { color: #1864ab; font-weight: 600; } .kl-text { color: #2b8a3e; } .kl-note { color: #868e96; }
    .kl-number { color: #c2410c; } .kl-head { color: #862e9c; font-weight: 600; }
    [data-mantine-color-scheme="dark"] .kl-word { color: #74c0fc; }
    [data-mantine-color-scheme="dark"] .kl-text { color: #8ce99a; }
    [data-mantine-color-scheme="dark"] .kl-number { color: #ffa94d; }
    [data-mantine-color-scheme="dark"] .kl-head { color: #e599f7; }
    .kl-wrong { color: #c92a2a; font-size: 13px; white-space: pre-wrap; padding: 0 10px 6px; }`;
  document.head.append(style);

  const WORDS = "and as assert break class continue def del elif else except False finally for from if import in is " +
    "lambda None nonlocal not or pass raise return True try while with yield true false";
  const PARTS = new RegExp([
    /(?<note>#[^\n]*)/, /(?<text>"""[^]*?"""|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')/, /^(?<head>\[[^\]\n]*\]\]?)/,
    `\\b(?<word>${WORDS.split(" ").join("|")})\\b`, /\b(?<number>\d[\d_]*\.?\d*(?:e[+-]?\d+)?)\b/,
  ].map((part) => part.source ?? part).join("|"), "gm");

  /** Fill an element with the parts of a text in their colours. */
  function colour(element, text) {
    const pieces = [];
    let end = 0;
    for (const found of text.matchAll(PARTS)) {
      const piece = document.createElement("span");
      piece.className = `kl-${Object.entries(found.groups).find(([, part]) => part !== undefined)[0]}`;
      piece.textContent = found[0];
      pieces.push(text.slice(end, found.index), piece);
      end = found.index + found[0].length;
    }
    element.replaceChildren(...pieces, `${text.slice(end)}\n`);
  }

  /** Number the lines, those at fault in red. */
  function number(element, count, wrong) {
    const parts = [];
    for (let line = 1; line <= count; line++) {
      const part = wrong.has(line) ? document.createElement("b") : document.createTextNode("");
      part.textContent = line;
      parts.push(part, "\n");
    }
    element.replaceChildren(...parts);
  }

  function buttonBelow(area) {
    return [...document.querySelectorAll("button")].find((button) => button.offsetParent && button.textContent.trim()
      && area.compareDocumentPosition(button) & Node.DOCUMENT_POSITION_FOLLOWING);
  }

  function pressed(event) {
    if (event.key === "Tab" && !event.shiftKey) {
      event.preventDefault();
      document.execCommand("insertText", false, "    ");
    } else if (["Enter", "s"].includes(event.key) && (event.ctrlKey || event.metaKey)) {
      event.preventDefault();
      const area = event.target;
      setTimeout(() => buttonBelow(area)?.click(), 200); // [ms] in which what was typed last is sent
    }
  }

  function begin(area) {
    const [code, lines] = ["kl-code", "kl-lines"].map((name) => {
      const made = document.createElement("pre");
      made.className = name;
      made.ariaHidden = "true";
      return made;
    });
    area.classList.add("kl-code");
    area.spellcheck = false;
    area.wrap = "off";
    area.parentElement.style.position = "relative";
    area.parentElement.append(code, lines);
    const row = area.closest(".mantine-Flex-root");
    if (row) row.style.display = "block", row.firstElementChild.style.display = "none";
    const scroll = () => { code.scrollTop = lines.scrollTop = area.scrollTop; code.scrollLeft = area.scrollLeft; };
    let before = null;
    area.paint = () => {
      const wrong = new Set([...document.querySelectorAll(".kl-wrong")].filter((told) => told.offsetParent)
        .flatMap((told) => [...told.textContent.matchAll(/\blines? (\d+)/g)].map((found) => Number(found[1]))));
      const now = `${[...wrong]}|${area.value}`;
      if (now === before) return;
      before = now;
      colour(code, area.value);
      number(lines, area.value.split("\n").length, wrong);
      scroll();
    };
    area.addEventListener("scroll", scroll);
    area.addEventListener("input", area.paint);
    area.addEventListener("keydown", pressed);
  }

  window.addEventListener("input", (event) => {
    const number = event.target.closest?.(".mantine-NumberInput-root");
    if (number && /^-0?\.?0*$/.test(event.target.value)) event.stopImmediatePropagation();
  }, true);

  setInterval(() => {
    for (const area of document.querySelectorAll("textarea:not([aria-hidden])")) {
      if (!area.paint) begin(area);
      area.paint();
    }
  }, 200); // [ms] after which a text that the studio has changed is coloured
})();
