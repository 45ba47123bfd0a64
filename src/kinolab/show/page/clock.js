// The time of the motion: it runs, stands, and is set.

/** A clock from `first` to `last` seconds; `listeners` are told of every change. */
export function buildClock(first, last, speed) {
  const clock = { time: first, first, last, speed, playing: false, loop: true, listeners: [],
                  pace: 0 }; // [ms] from one picture to the next, as it was last
  const tell = () => clock.listeners.forEach((listener) => listener(clock));
  clock.seek = (t) => { clock.time = Math.min(Math.max(t, first), last); tell(); };
  clock.play = () => {
    if (last <= first) return;
    if (clock.time >= last) clock.time = first;
    clock.playing = true;
    tell();
  };
  clock.pause = () => { clock.playing = false; tell(); };
  clock.toggle = () => (clock.playing ? clock.pause() : clock.play());
  clock.setSpeed = (value) => { clock.speed = value; tell(); };

  /** Let `seconds` of the viewer's time pass. */
  clock.pass = (seconds) => {
    const t = clock.time + seconds * clock.speed;
    if (t < last) clock.time = t;
    else if (clock.loop) clock.time = first;
    else { clock.time = last; clock.playing = false; }
    tell();
  };
  return clock;
}
