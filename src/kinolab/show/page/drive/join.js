// The drive mode as part of the page: its button, its section of the panel, its place in the scene.

import { section } from "../dom.js";
import { driven_machine } from "../driven_machine.js";
import { buildContacts } from "./contacts.js";
import { buildDrive } from "./drive.js";

/**
 * Let the reader drive the machine, where the page has its equations and a scene to show it in.
 *
 * `plan` has the plan's {clock, motion}, `scene` the {machine, join, changed} of the page; the
 * cockpit goes into its panel. Returns null where nobody can drive.
 */
export function joinDrive(data, array, plan, scene, byId) {
  if (!driven_machine || !data.driving || !scene.machine) return null;
  const stored = { ...plan, knots: array(data.knots), states: array(data.driving.states) };
  const names = { bodies: data.bodies.map(({ name }) => name), obstacles: data.obstacles.map(({ name }) => name) };
  const around = { names, surfaces: scene.world.surfaces, switched: scene.switched,
                   contacts: () => buildContacts(data.obstacles, array) };
  const drive = buildDrive(data.driving, driven_machine, stored, scene.machine, scene.changed, around);
  const part = section("Drive the machine", true, drive.panel);
  const button = byId("drive-button");
  part.id = "drive";
  part.hidden = true;
  button.hidden = false;
  button.addEventListener("click", () => { drive.toggle(); button.blur(); }); // the space bar pauses
  byId("panel").append(part);
  let view = null; // that the reader had before driving
  drive.listeners.push((on) => {
    if (on) { view = scene.viewName(); scene.choose("follow"); } else scene.choose(view ?? "perspective");
    part.hidden = !on;
    button.setAttribute("aria-pressed", on);
    document.body.classList.toggle("driving", on);
    if (on && document.body.classList.contains("closed")) byId("drawer").click(); // the keys are in the panel
  });
  scene.join(drive);
  return drive;
}
