// Kept frames as numbers. A run's `view`:
//   frames [k], every, low [x, y, z], size [x, y, z], vertices, triangles, aspect (of the movie's pictures),
//   cameras [[position, target, up, vertical field of view in degrees: 10 numbers]],
//   cloths [{first, count, color}], colliders [{vertices, triangles, color, bends, poses [[16 numbers] | null]}],
//   fields [{name, label, unit, low, high, below, above, log}], shade (name of the field to begin with), ground (y),
//   left_out [name of a collider], colors (base64 of 256 r g b), data (base64 of zlib, or empty: it found no room), of:
//     int32 triangles of the cloths; for each collider float32 x y z of its vertices, int32 triangles;
//     then for each frame, axis by axis, shares of the box in uint16, less those of the frame before: the lower bytes of all
//     of the cloths' vertices, then the higher; uint8 of each field, one number a vertex, the last colour for none; of each
//     collider that bends its vertices as those of the cloths.
// Where cameras or poses have one entry it holds for all frames.
'use strict';

/** All numbers of a view: arrays over its frames. */
async function unpackView(view) {
  const stream = new Blob([bytesOf(view.data)]).stream().pipeThrough(new DecompressionStream('deflate'));
  const buffer = await new Response(stream).arrayBuffer();
  const bytes = new DataView(buffer);
  let at = 0;
  const whole = (count) => {
    const list = new Uint32Array(count);
    for (let i = 0; i < count; ++i, at += 4) list[i] = bytes.getInt32(at, true);
    return list;
  };
  const floats = (count) => {
    const list = new Float32Array(count);
    for (let i = 0; i < count; ++i, at += 4) list[i] = bytes.getFloat32(at, true);
    return list;
  };
  /** Shares of the box, rolled on from frame to frame; as x y z of each vertex. */
  const roll = (last, count) => {
    const list = new Float32Array(3 * count);
    for (let axis = 0; axis < 3; ++axis, at += 2 * count) {
      for (let v = 0; v < count; ++v) {
        const i = axis * count + v;
        last[i] = last[i] + bytes.getUint8(at + v) + 256 * bytes.getUint8(at + count + v);
        list[3 * v + axis] = view.low[axis] + view.size[axis] * last[i] / 65535;
      }
    }
    return list;
  };
  const scene = {triangles: whole(3 * view.triangles), colliders: [], frames: [], colors: bytesOf(view.colors)};
  for (const collider of view.colliders)
    scene.colliders.push({positions: floats(3 * collider.vertices), triangles: whole(3 * collider.triangles)});
  const last = new Uint16Array(3 * view.vertices);
  const lastBent = view.colliders.map((collider) => new Uint16Array(3 * collider.vertices));
  for (let f = 0; f < view.frames.length; ++f) {
    const frame = {positions: roll(last, view.vertices), fields: [], bent: []};
    for (let k = 0; k < view.fields.length; ++k, at += view.vertices) frame.fields.push(new Uint8Array(buffer, at, view.vertices));
    view.colliders.forEach((collider, c) => frame.bent.push(collider.bends ? roll(lastBent[c], collider.vertices) : null));
    scene.frames.push(frame);
  }
  return scene;
}
