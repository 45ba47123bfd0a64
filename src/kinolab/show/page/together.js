// Pages that are shown side by side play together: what the reader does to one is done to the other.

const CLOSE = 0.35; // [s] of the reader's time: what a clock may be off that only ran on

/** Follow what the page around this one passes on, and tell it what the reader does here. */
export function playTogether(clock) {
  if (window.parent === window) return;
  let before = read(clock), following = false;
  clock.listeners.push(() => {
    const now = read(clock), passed = (now.at - before.at) / 1000;
    const expected = before.time + (before.playing ? passed * before.speed : 0);
    const ranOn = now.playing === before.playing && now.speed === before.speed
      && (Math.abs(now.time - expected) < CLOSE * now.speed || (now.playing && now.time < before.time && clock.loop));
    const ended = before.playing && !now.playing && now.time >= clock.last;
    before = now;
    if (ranOn || ended || following) return;
    window.parent.postMessage({ kinolab: "clock", time: now.time, playing: now.playing, speed: now.speed }, "*");
  });
  window.addEventListener("message", ({ source, data }) => {
    if (source !== window.parent || data?.kinolab !== "follow") return;
    const { time, playing, speed } = data;
    following = true;
    clock.loop = false; // the shorter motion waits at its end
    if (clock.speed !== speed) clock.setSpeed(speed);
    clock.seek(time);
    if (playing && !clock.playing && time < clock.last) clock.play();
    if (!playing && clock.playing) clock.pause();
    following = false;
  });
}

function read({ time, playing, speed }) {
  return { time, playing, speed, at: performance.now() };
}
