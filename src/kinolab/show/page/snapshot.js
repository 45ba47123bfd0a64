// A picture of the scene as it is seen now, as a PNG file.

const PAPER = "#ffffff", INK = "#1d2330";

/** Save the canvas, drawn anew by `draw()`, with the words in it; the file is named by `name` and the time. */
export function buildSnapshot(button, canvas, { draw, name, title, clock }) {
  const save = () => {
    draw(); // what was drawn before is gone by now
    const sheet = document.createElement("canvas"), pen = sheet.getContext("2d");
    const scale = canvas.width / Math.max(canvas.clientWidth, 1), bar = Math.round(30 * scale);
    sheet.width = canvas.width; sheet.height = canvas.height + bar;
    pen.fillStyle = PAPER; pen.fillRect(0, 0, sheet.width, bar);
    pen.drawImage(canvas, 0, bar);
    pen.fillStyle = INK; pen.textBaseline = "middle"; pen.font = `600 ${14 * scale}px system-ui, sans-serif`;
    pen.fillText(title, 10 * scale, bar / 2);
    pen.textAlign = "right";
    pen.fillText(`t = ${clock.time.toFixed(2)} s`, sheet.width - 10 * scale, bar / 2);
    pen.textAlign = "center"; pen.font = `600 ${12 * scale}px system-ui, sans-serif`;
    const stage = canvas.getBoundingClientRect();
    for (const sign of document.querySelectorAll("#captions:not([hidden]) .sign:not([hidden])")) {
      const box = sign.getBoundingClientRect(), x = scale * (box.left - stage.left), y = scale * (box.top - stage.top) + bar;
      pen.fillStyle = PAPER; pen.globalAlpha = 0.82; pen.fillRect(x, y, scale * box.width, scale * box.height); pen.globalAlpha = 1;
      pen.fillStyle = INK; pen.fillText(sign.textContent, x + (scale * box.width) / 2, y + (scale * box.height) / 2);
    }
    const link = document.createElement("a");
    link.download = `${name}_${clock.time.toFixed(2)}s.png`;
    link.href = sheet.toDataURL("image/png");
    link.click();
  };
  button.addEventListener("click", save);
  return save;
}
