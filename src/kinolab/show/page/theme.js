// Dark and light: what the reader's system prefers, until the switch is used.

/** What the scene is painted with; the rest of the page takes its colours from page.css. */
export const PAINT = {
  light: { dark: false, world: 1, paper: 0xf4f5f3, floor: 0xe9eae6, grid: 0xd2d4cf, wallEdge: 0x68788c,
           ink: 0x262a32, path: 0x3a6ea5, ahead: 0x8fb2d6, tree: 0x6f8196,
           force: 0xd5480f, sky: 0xffffff, earth: 0xc9c5bc, sun: 1.7, fill: 1.8, shadow: 0.8, shade: 0xc4c5c2 },
  dark: { dark: true, world: 0.62, paper: 0x14171c, floor: 0x22272f, grid: 0x363d49, wallEdge: 0x8194ac,
          ink: 0xdfe5ee, path: 0x6cb0f5, ahead: 0x3d628a, tree: 0x8796ab,
          force: 0xff8a50, sky: 0xcfdcf2, earth: 0x4c525e, sun: 1.8, fill: 1.6, shadow: 0.85, shade: 0x15181d },
};

/** Follow the system's preference and the switch; calls `changed(name)` now and at every change. */
export function themes(button, changed) {
  const system = matchMedia("(prefers-color-scheme: dark)");
  let chosen = null;
  const apply = () => {
    const name = chosen ?? (system.matches ? "dark" : "light");
    document.documentElement.dataset.theme = name;
    changed(name);
  };
  const toggle = () => {
    chosen = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    apply();
  };
  system.addEventListener("change", apply);
  button.addEventListener("click", toggle);
  apply();
  return { toggle };
}
