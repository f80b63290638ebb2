// Kept frames in three dimensions. A run's `view`:
//   frames [k], low [x, y, z], size [x, y, z], vertices, triangles,
//   cloths [{first, count, color}], colliders [{vertices, triangles, color, bends, poses [[16 numbers] | null]}],
//   fields [{name, label, unit, low, high}], colors (base64 of 256 r g b), every, data (base64 of zlib), of:
//     int32 triangles of the cloths; for each collider float32 x y z of its vertices, int32 triangles;
//     then for each frame uint16 x, all y, all z of the cloths' vertices as shares of the box, less the frame before;
//     uint8 of each field, one number a vertex; of each collider that bends its vertices as those of the cloths.
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
    for (let axis = 0; axis < 3; ++axis) {
      for (let v = 0; v < count; ++v, at += 2) {
        const i = axis * count + v;
        last[i] = last[i] + bytes.getUint16(at, true);
        list[3 * v + axis] = view.low[axis] + view.size[axis] * last[i] / 65535;
      }
    }
    return list;
  };
  const scene = {triangles: whole(3 * view.triangles), colliders: [], frames: []};
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

/** The section with the view of the runs that have one. */
function viewOf(runs, cursor) {
  const canvas = make('canvas', {id: 'view', tabindex: 0, 'aria-label': 'The cloth; drag to turn, two fingers or the wheel to come nearer'});
  const stage = make('div', {class: 'stage'}, canvas);
  const choice = make('select', {id: 'field', 'aria-label': 'Colours'});
  const which = make('select', {'aria-label': 'Run'}, ...runs.map((run, i) => make('option', {value: i}, run.label)));
  const strip = make('canvas', {width: 256, height: 1});
  const low = make('span'), high = make('span');
  const scale = make('span', {class: 'scale'}, low, strip, high);
  const about = make('p', {class: 'faint'});
  const section = make('section', {}, stage, make('div', {class: 'controls'}, runs.length > 1 ? which : null, choice, scale), about);
  const probe = document.createElement('canvas');
  if (!probe.getContext('webgl')) {
    stage.append(make('p', {}, 'This browser shows no WebGL: the movie above has the same frames.'));
    return section;
  }
  const renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true, preserveDrawingBuffer: true});
  renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
  const world = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(35, 1, 0.01, 1000);
  const orbit = new THREE.OrbitControls(camera, canvas);
  world.add(new THREE.HemisphereLight(0xffffff, 0x8a8f98, 0.75));
  const sun = new THREE.DirectionalLight(0xffffff, 0.55);
  camera.add(sun);
  sun.position.set(-1, 1.5, 1);
  world.add(camera);
  let run = null, scene = null, bodies = [];
  const draw = () => renderer.render(world, camera);
  orbit.addEventListener('change', draw);
  const fit = () => {
    renderer.setSize(stage.clientWidth, stage.clientHeight, false);
    camera.aspect = stage.clientWidth / Math.max(1, stage.clientHeight);
    camera.updateProjectionMatrix();
    draw();
  };
  new ResizeObserver(fit).observe(stage);

  const bodyOf = (positions, triangles, material) => {
    const shape = new THREE.BufferGeometry();
    shape.setAttribute('position', new THREE.BufferAttribute(positions.slice(), 3));
    shape.setIndex(new THREE.BufferAttribute(triangles, 1));
    shape.computeVertexNormals();
    const body = new THREE.Mesh(shape, material);
    body.frustumCulled = false;
    world.add(body);
    return body;
  };
  const moved = (body, positions) => {
    body.geometry.attributes.position.array.set(positions);
    body.geometry.attributes.position.needsUpdate = true;
    body.geometry.computeVertexNormals();
  };

  const show = (frame) => {
    if (!scene) return;
    const view = run.view;
    let f = 0;
    while (f + 1 < view.frames.length && view.frames[f + 1] <= frame) ++f;
    const now = scene.frames[f];
    moved(bodies[0], now.positions);
    const colors = bodies[0].geometry.attributes.color;
    const field = Number(choice.value);
    if (field < 0) {
      for (const cloth of view.cloths)
        for (let v = cloth.first; v < cloth.first + cloth.count; ++v) colors.array.set(cloth.color, 3 * v);
    } else {
      for (let v = 0; v < view.vertices; ++v)
        for (let k = 0; k < 3; ++k) colors.array[3 * v + k] = scene.colors[3 * now.fields[field][v] + k] / 255;
    }
    colors.needsUpdate = true;
    view.colliders.forEach((collider, c) => {
      const body = bodies[1 + c], pose = collider.poses[f];
      body.visible = pose !== null;
      if (pose) body.matrix.fromArray(pose);
      if (now.bent[c]) moved(body, now.bent[c]);
    });
    draw();
  };

  const color = () => {
    const field = run.view.fields[Number(choice.value)];
    scale.style.visibility = field ? 'visible' : 'hidden';
    if (field) {
      low.textContent = shown(field.low, field.unit);
      high.textContent = shown(field.high, field.unit);
    }
    show(cursor.frame);
  };

  const load = async (next) => {
    run = next;
    scene = null;
    const view = run.view;
    const unpacked = await unpackView(view);
    unpacked.colors = bytesOf(view.colors);
    if (run !== next) return;
    for (const body of bodies) world.remove(body);
    const cloth = bodyOf(unpacked.frames[0].positions, unpacked.triangles,
      new THREE.MeshPhongMaterial({vertexColors: THREE.VertexColors, side: THREE.DoubleSide, shininess: 8}));
    cloth.geometry.setAttribute('color', new THREE.BufferAttribute(new Float32Array(3 * view.vertices), 3));
    bodies = [cloth, ...unpacked.colliders.map((collider, c) => {
      const body = bodyOf(collider.positions, collider.triangles,
        new THREE.MeshPhongMaterial({color: new THREE.Color(...view.colliders[c].color), side: THREE.DoubleSide, shininess: 5}));
      body.matrixAutoUpdate = false;
      return body;
    })];
    const strips = strip.getContext('2d'), image = strips.createImageData(256, 1);
    for (let i = 0; i < 256; ++i) image.data.set([...unpacked.colors.slice(3 * i, 3 * i + 3), 255], 4 * i);
    strips.putImageData(image, 0, 0);
    choice.replaceChildren(make('option', {value: -1}, 'own colours'),
      ...view.fields.map((field, i) => make('option', {value: i}, field.label)));
    const center = new THREE.Vector3(...view.low.map((l, k) => l + view.size[k] / 2));
    const reach = Math.hypot(...view.size);
    if (!orbit.placed) {
      orbit.target.copy(center);
      camera.position.copy(center).add(new THREE.Vector3(0.45, 0.4, 1).normalize().multiplyScalar(1.05 * reach));
      camera.near = reach / 1000;
      camera.far = reach * 100;
      orbit.placed = true;
    }
    about.textContent = view.every > 1 ? `Every ${view.every}th frame is here, so that the page stays small; the movie has all.` : '';
    scene = unpacked;
    orbit.update();
    fit();
    color();
    canvas.dataset.ready = 'yes';
  };
  choice.addEventListener('change', color);
  which.addEventListener('change', () => load(runs[Number(which.value)]));
  cursor.follow({show});
  load(runs[0]).catch((error) => stage.append(make('p', {}, 'The frames cannot be unpacked here: ' + error.message)));
  return section;
}
