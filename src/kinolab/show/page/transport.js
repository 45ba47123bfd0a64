// The bar below: play, steps, scrub, speed.

import { element } from "./dom.js";
import { gently } from "./gently.js";
import { rowAt } from "./motion.js";

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8, 16];

/** Connect the bar with the clock; `knots` are the times of the stored steps. */
export function buildTransport(clock, knots, byId) {
  const scrub = byId("scrub"), play = byId("play"), speed = byId("speed");
  scrub.min = clock.first; scrub.max = clock.last;
  const choices = [...new Set([...SPEEDS, clock.speed])].sort((a, b) => a - b);
  for (const value of choices) speed.add(new Option(`${value}×`, value));
  let held = false;

  const step = (count) => {
    clock.pause();
    const last = knots.length - 1, row = clock.time >= knots[last] ? last : rowAt(knots, clock.time);
    const between = count < 0 && clock.time > knots[row] + 1e-9 ? 1 : 0; // first back to this step's own knot
    clock.seek(knots[Math.min(Math.max(row + count + between, 0), last)]);
  };
  const faster = (count) => {
    const at = choices.indexOf(clock.speed);
    clock.setSpeed(choices[Math.min(Math.max(at + count, 0), choices.length - 1)]);
  };
  play.addEventListener("click", clock.toggle);
  byId("back").addEventListener("click", () => step(-1));
  byId("next").addEventListener("click", () => step(1));
  byId("loop").addEventListener("click", () => {
    clock.loop = !clock.loop;
    byId("loop").setAttribute("aria-pressed", clock.loop);
  });
  scrub.addEventListener("input", () => clock.seek(Number(scrub.value)));
  scrub.addEventListener("pointerdown", () => { held = clock.playing; clock.pause(); });
  scrub.addEventListener("pointerup", () => { if (held) clock.play(); });
  speed.addEventListener("change", () => clock.setSpeed(Number(speed.value)));

  gently(clock, () => {
    scrub.value = clock.time;
    scrub.setAttribute("aria-valuetext", `${clock.time.toFixed(2)} seconds`);
    byId("clock").replaceChildren(`${clock.time.toFixed(2)} `, element("small", {}, `/ ${clock.last.toFixed(2)} s`));
    const label = clock.playing ? "Pause" : "Play";
    if (play.getAttribute("aria-label") !== label) {
      play.setAttribute("aria-label", label);
      play.querySelector("use").setAttribute("href", clock.playing ? "#i-pause" : "#i-play");
    }
    speed.value = clock.speed;
  });
  return { step, faster };
}
