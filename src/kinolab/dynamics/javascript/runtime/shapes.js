// Sizes and places of shapes: per body [{ kind, axis, size: { … }, at }].

function shapesOf({ shapes }, called, p) {
  const values = called("shapes", [p], false);
  const read = ({ kind, axis, dimensions, first, hull }) => {
    const place = first + dimensions.length;
    const size = hull ?? Object.fromEntries(dimensions.map((name, i) => [name, values[first + i]]));
    return { kind, axis, size, at: Array.from(values.subarray(place, place + 3)) };
  };
  return shapes.map((list) => list.map(read));
}
