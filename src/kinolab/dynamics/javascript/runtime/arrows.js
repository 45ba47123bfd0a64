// The forces of constraints as arrows in the world.

// Return [{ name, value, at, force, torque }]: value is the multiplier; at, force and torque are null
// where no single body is held.
function arrowsOf({ constraints, sizes, places }, called, x, u, p) {
  if (!constraints.length) return [];
  const values = called("constraint_forces", [x, u, p], false), poses = called("frames", [x, p], false);
  const w = called("covectors", [x, p], false), twists = called("twists", [x, p], false);
  const width = sizes.covectors / constraints.length;
  const lines = constraints.map(({ body, twist, onGround }, row) => {
    if (body === null) return null;
    const line = lineOfAction(twists, twist * 6 * width, w, row, width);
    const at = line.arm.map((part, i) => poses[POSE * body + 4 * i + 3] + part);
    if (onGround) at[2] = 0;
    return { ...line, at, body };
  });
  return constraints.map(({ name }, row) => {
    const value = values[places?.[row] ?? row], line = lines[row];
    if (line === null) return { name, value, at: null, force: null, torque: null };
    const [force, torque] = [line.force, line.torque].map((v) => v.map((part) => value * part));
    return { name, value, at: contact(line, lines), force, torque };
  });
}
