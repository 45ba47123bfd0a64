// What became of the plan: the verdict with its checks, planner, seed, duration.

import { element, number, section } from "./dom.js";

const WORDS = {
  solved: ["Solved and verified", "good"], simulated: ["Simulated", "fair"],
  approximate: ["Near the goal, not in it", "fair"], local_minimum: ["Stuck in a local minimum", "fair"],
  not_found: ["No plan found", "bad"], verification_failed: ["Verification failed", "bad"],
  interrupted: ["Interrupted", "fair"], searching: ["Searching", "fair"],
  machine: ["Machine by itself", "fair"], ready: ["Not planned yet", "fair"], impossible: ["Start or goal impossible", "bad"],
};

/** Write title, subtitle and badge. */
export function buildHeading(data, byId) {
  const { facts } = data;
  byId("title").textContent = byId("title").title = data.title;
  const parts = [data.machine, facts.planner && `${facts.planner}, seed ${facts.seed}`,
                 facts.duration != null && `${facts.duration.toFixed(2)} s`];
  byId("subtitle").textContent = parts.filter(Boolean).join(" · ");
  showStatus(byId, facts.status);
}

/** Write on the badge what became of a plan. */
export function showStatus(byId, status) {
  const [word, kind] = Object.hasOwn(WORDS, status) ? WORDS[status] : ["Not planned yet", "fair"];
  byId("badge").textContent = word;
  byId("badge").className = kind;
}

/** Return the part of the panel that tells what became of the plan. */
export function buildReport(data) {
  const { facts } = data, checks = facts.verification ?? [];
  const rows = { Machine: data.machine, Scenario: data.name, Planner: facts.planner, Seed: facts.seed,
                 Iterations: facts.iterations,
                 Duration: facts.duration == null ? null : `${number(facts.duration)} s`,
                 Cost: facts.cost === facts.duration ? null : number(facts.cost),
                 "Distance from goal centre": offCentre(facts), "Smallest clearance": smallestClearance(facts.margin) };
  const list = element("dl", { class: "facts" });
  for (const [name, value] of Object.entries(rows))
    if (value !== null && value !== undefined) list.append(element("dt", {}, name), element("dd", {}, String(value)));
  const message = facts.message ? [element("p", { class: "message" }, facts.message)] : [];
  for (const told of facts.warnings ?? []) message.push(element("p", { class: "message" }, told));
  const passed = checks.filter((check) => check.passed).length;
  return section("Plan", true, ...message, list, ...(checks.length ? [checkList(checks, passed)] : []));
}

/** How far the motion ends from the goal's centre, in each unit: metres and radians have no sum. */
function offCentre({ goal_distance: all, goal_distance_by_unit: parts }) {
  if (!parts) return all == null ? null : `${number(all)} (norm in SI units)`;
  return Object.entries(parts).map(([unit, value]) => `${number(value)} ${unit}`.trim()).join(", ");
}

/** The smallest clearance along the motion: how much, when and beside what. */
function smallestClearance(margin) {
  if (!margin) return null;
  const beside = margin.beside.length ? ` (${margin.beside.join(", ")})` : "";
  return `${number(1000 * (margin.clearance + (margin.required ?? 0)))} mm at ${number(margin.time)} s${beside}`;
}

/** The checks, folded where all of them passed. */
function checkList(checks, passed) {
  const list = element("ul", { class: "checks", "aria-label": "Checks" });
  for (const { name, value, limit, passed, detail } of checks) {
    const row = element("li", { class: passed ? "passed" : "failed" },
      element("span", { class: "mark", role: "img", "aria-label": passed ? "passed" : "failed" }, passed ? "✓" : "✗"),
      element("span", {}, name),
      element("span", { class: "value", title: "found, and the largest that passes" }, `${number(value)} ≤ ${number(limit)}`));
    if (detail) row.append(element("span", { class: "detail" }, detail));
    list.append(row);
  }
  const all = passed === checks.length;
  const title = element("span", { class: all ? "verdict passed" : "verdict failed" }, `${passed} of ${checks.length} checks passed`);
  return element("details", { class: "checked", ...(all ? {} : { open: "" }) }, element("summary", {}, title), list);
}

/** Return the part of the panel that names what the machine keeps at zero. */
export function buildConstraints(data) {
  const list = element("ul", { class: "list" });
  data.constraints.forEach((name) => list.append(element("li", {}, name)));
  return section("Constraints (always satisfied)", false, list);
}
