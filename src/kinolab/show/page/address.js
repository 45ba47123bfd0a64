// The time in the page's address: #t=2.5 opens there, and standing still writes it.

/** Return the time that an address asks for, null where it asks for none. */
export function timeIn(hash) {
  const found = /^#(?:.*&)?t=(\d+(?:\.\d*)?(?:e-?\d+)?)/.exec(hash);
  return found ? Number(found[1]) : null;
}

/** Go to the time in the address whenever it changes, and keep the address true where it may be. */
export function buildAddress(clock) {
  let written = "";
  addEventListener("hashchange", () => {
    const t = timeIn(location.hash);
    if (t !== null && location.hash !== written) { clock.pause(); clock.seek(t); }
  });
  let waiting = null;
  clock.listeners.push(() => {
    clearTimeout(waiting);
    if (!clock.playing) waiting = setTimeout(() => {
      const wanted = `#t=${Number(clock.time.toFixed(3))}`;
      if (clock.time === clock.first && !location.hash) return;
      written = wanted;
      try { history.replaceState(null, "", wanted); } catch { /* some browsers forbid it to files */ }
    }, 250);
  });
}
