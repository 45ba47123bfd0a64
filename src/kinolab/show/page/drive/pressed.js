// Which keys are down, on the keyboard, on a gamepad or as buttons of the page.

const DEAD = 0.12; // share of a stick's way that counts as its middle
const STICKS = [{ axis: 1, sign: -1 }, { axis: 0, sign: 1 }, { axis: 3, sign: -1 }, { axis: 2, sign: 1 }];

/**
 * Watch the keys of some channels while `active()`; `actions` has what other keys do, by key.
 *
 * They are asked before the page's own keys. `pushes()` gives a number in [-1, 1] per channel.
 */
export function watchKeys(active, channels, actions) {
  const down = new Set();
  const name = (event) => (event.key.length === 1 ? event.key.toLowerCase() : event.key);
  const meant = (key) => channels().some(({ keys }) => keys.includes(key));

  const pressed = (event) => {
    if (!active() || event.ctrlKey || event.metaKey || event.altKey || typing(event.target)) return;
    const key = name(event);
    if (key === " " && event.target.closest("button, summary, [type=checkbox]")) return; // it is what is pressed
    if (meant(key)) down.add(key);
    else if (key in actions) { if (!event.repeat) actions[key](); }
    else return;
    event.preventDefault();
    event.stopImmediatePropagation();
  };
  addEventListener("keydown", pressed, { capture: true });
  addEventListener("keyup", (event) => down.delete(name(event)), { capture: true });
  addEventListener("blur", () => down.clear());

  const pushes = () => {
    const sticks = active() ? sticksNow() : [];
    return channels().map(({ keys: [more, less] }, c) => {
      const push = down.has(more) - down.has(less);
      const stick = c < STICKS.length ? sticks[STICKS[c].axis] ?? 0 : 0;
      return push || STICKS[c]?.sign * stick * (more === "ArrowLeft" ? -1 : 1) || 0;
    });
  };
  return { pushes, hold: (key, on) => (on ? down.add(key) : down.delete(key)), clear: () => down.clear() };
}

/** The axes of the first gamepad, their dead middle taken out. */
function sticksNow() {
  const pad = [...(navigator.getGamepads?.() ?? [])].find(Boolean);
  return (pad?.axes ?? []).map((value) => {
    const beyond = Math.abs(value) - DEAD;
    return beyond > 0 ? (Math.sign(value) * Math.min(beyond, 1 - DEAD)) / (1 - DEAD) : 0;
  });
}

function typing(target) {
  return target.closest?.("select, textarea, input:not([type=checkbox])") != null; // a slider has keys of its own
}
