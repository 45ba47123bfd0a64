// Text and plots need not change with every picture where pictures are slow.

const SLOW = 30; // [ms] per picture
const REST = 120; // [ms] between two changes then

/** Let `run(clock)` follow the clock: at once where it stands, seldom where pictures are slow. */
export function gently(clock, run) {
  let last = 0, waiting = null;
  const now = () => { last = performance.now(); clearTimeout(waiting); waiting = null; run(clock); };
  clock.listeners.push(() => {
    if (!clock.playing || clock.pace < SLOW || performance.now() - last > REST) now();
    else waiting ??= setTimeout(now, REST);
  });
}
