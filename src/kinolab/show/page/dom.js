// Making elements in a line.

/** Return a new element with attributes and children; text is never read as HTML. */
export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/** Return a part of the panel that can be folded. */
export function section(title, open, ...children) {
  const part = element("details", open ? { open: "" } : {}, element("summary", {}, title));
  part.append(element("div", { class: "section" }, ...children));
  return part;
}

/** Write a number for people: four digits that matter. */
export function number(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-3 || size >= 1e5) return value.toExponential(1).replace("e+", "e");
  return String(Number(value.toPrecision(4)));
}

const RAISED = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴" };

/** Write a unit with raised exponents: kg m^2 is kg m². */
export function unitText(unit) {
  return unit.replace(/\^(-?\d)/g, (_, power) => [...power].map((sign) => RAISED[sign] ?? sign).join(""));
}
