// Kept frames in three dimensions (unpack.js).
'use strict';

/** The one of a list for each frame, which has one entry where that is the same in all. */
const entryOf = (list, f) => list[Math.min(f, list.length - 1)];

/** One run in the view: its bodies, and what they are coloured by. */
class Pane {
  constructor(run, scene) {
    this.view = run.view;
    this.scene = scene;
    this.world = new THREE.Scene();
    this.plain = [new THREE.HemisphereLight(0xffffff, 0x9a9fa8, 0.85), new THREE.DirectionalLight(0xffffff, 0.4)];
    this.plain[1].position.set(-1, 1.5, 1);
    // As pictures are shaded: what faces the eye has the colour of the scale.
    this.shaded = [new THREE.AmbientLight(0xffffff, 0.55), new THREE.DirectionalLight(0xffffff, 0.45)];
    this.world.add(...this.plain, ...this.shaded, this.shaded[1].target);
    const double = {side: THREE.DoubleSide};
    this.cloth = this.body(scene.frames[0].positions, scene.triangles, new THREE.MeshLambertMaterial({vertexColors: THREE.VertexColors, ...double}));
    this.cloth.geometry.setAttribute('color', new THREE.BufferAttribute(new Float32Array(3 * this.view.vertices), 3));
    this.edges = new THREE.Mesh(this.cloth.geometry, new THREE.MeshBasicMaterial({wireframe: true, color: 0x14161a, transparent: true, opacity: 0.4}));
    this.edges.frustumCulled = false;
    this.edges.visible = false;
    this.world.add(this.edges);
    this.colliders = scene.colliders.map((collider, c) => {
      const body = this.body(collider.positions, collider.triangles, new THREE.MeshLambertMaterial({color: new THREE.Color(...this.view.colliders[c].color), ...double}));
      body.matrixAutoUpdate = false;
      return body;
    });
    if (this.view.ground !== undefined) {
      const reach = Math.max(1, 2 ** Math.round(Math.log2(4 * Math.hypot(...this.view.size))));
      const grid = new THREE.GridHelper(reach, 16, 0x7b8591, 0x98a2ad);
      grid.position.set(this.view.low[0] + this.view.size[0] / 2, this.view.ground, this.view.low[2] + this.view.size[2] / 2);
      this.world.add(grid);
    }
  }

  body(positions, triangles, material) {
    const shape = new THREE.BufferGeometry();
    shape.setAttribute('position', new THREE.BufferAttribute(positions.slice(), 3));
    shape.setIndex(new THREE.BufferAttribute(triangles, 1));
    shape.computeVertexNormals();
    const body = new THREE.Mesh(shape, material);
    body.frustumCulled = false;
    this.world.add(body);
    return body;
  }

  /** The last kept frame that is not behind `frame`. */
  at(frame) {
    const frames = this.view.frames;
    let f = 0;
    while (f + 1 < frames.length && frames[f + 1] <= frame) ++f;
    return f;
  }

  /** `range`: of the field, {low, high}; null: the cloths' own colours. */
  color(name, range) {
    this.field = range ? this.view.fields.findIndex((field) => field.name === name) : -1;
    if (this.field < 0) return;
    // A byte stands for a share of this run's range; its colour is that of the common one.
    const own = this.view.fields[this.field];
    const same = own.low === range.low && own.high === range.high;
    this.colors = new Float32Array(3 * 256);
    for (let i = 0; i < 256; ++i) {
      let share = i;
      if (!same && i < 255) share = 254 * Math.min(1, Math.max(0, (own.low + i / 254 * (own.high - own.low) - range.low) / (range.high - range.low)));
      for (let k = 0; k < 3; ++k) this.colors[3 * i + k] = this.scene.colors[3 * Math.round(share) + k] / 255;
    }
  }

  move(body, positions) {
    body.geometry.attributes.position.array.set(positions);
    body.geometry.attributes.position.needsUpdate = true;
    body.geometry.computeVertexNormals();
  }

  show(frame) {
    const f = this.at(frame), now = this.scene.frames[f];
    this.move(this.cloth, now.positions);
    const colors = this.cloth.geometry.attributes.color;
    if (this.field < 0) {
      for (const cloth of this.view.cloths)
        for (let v = cloth.first; v < cloth.first + cloth.count; ++v) colors.array.set(cloth.color, 3 * v);
    } else {
      const values = now.fields[this.field];
      for (let v = 0; v < this.view.vertices; ++v)
        for (let k = 0; k < 3; ++k) colors.array[3 * v + k] = this.colors[3 * values[v] + k];
    }
    colors.needsUpdate = true;
    for (const light of this.plain) light.visible = this.field < 0;
    for (const light of this.shaded) light.visible = this.field >= 0;
    this.view.colliders.forEach((collider, c) => {
      const pose = entryOf(collider.poses, f);
      this.colliders[c].visible = pose !== null;
      if (pose) this.colliders[c].matrix.fromArray(pose);
      if (now.bent[c]) this.move(this.colliders[c], now.bent[c]);
    });
  }
}

/** What is said below the view of a run. */
function aboutView(run) {
  const view = run.view, said = [];
  if (view.every > 1 && view.data) said.push(`every ${view.every}${view.every === 2 ? 'nd' : view.every === 3 ? 'rd' : 'th'} frame is here, so that the page stays small; the movie has all`);
  for (const name of view.left_out || []) said.push(`the mesh of ${name || 'a collider'} is too large for the page and left out`);
  if (!view.data) said.push('its frames are too large for the page');
  return said.length ? (several ? run.label + ': ' : '') + said.join('; ') + '.' : '';
}

/** The section with the view of the runs that have one, beside each other under one camera. */
function viewOf(runs, cursor) {
  const canvas = make('canvas', {id: 'view', tabindex: 0, 'aria-label': 'The cloth in three dimensions. Drag or arrow keys turn it, the wheel, two fingers, plus and minus come nearer.'});
  const names = runs.map((run, i) => several ? make('span', {class: 'pane'}, key(i), run.label) : null).filter((name) => name);
  const stage = make('div', {class: 'stage'}, canvas, ...names);
  const choice = make('select', {id: 'field', 'aria-label': 'Colours'});
  const back = make('button', {id: 'as-movie'}, 'As in the movie');
  const edges = make('input', {type: 'checkbox', id: 'edges'});
  const strip = make('canvas', {width: 255, height: 1});
  const low = make('span'), high = make('span');
  const scale = make('span', {class: 'scale'}, low, strip, high);
  const section = make('section', {}, stage,
    make('div', {class: 'controls'}, choice, scale, make('label', {}, edges, ' Edges'), back),
    ...runs.map(aboutView).filter((text) => text).map((text) => make('p', {class: 'faint'}, text)));
  const withData = runs.filter((run) => run.view.data);
  if (!withData.length || !document.createElement('canvas').getContext('webgl')) {
    stage.replaceChildren(make('p', {}, withData.length ? 'This browser shows no WebGL: the movie above has the same frames.' : 'There is nothing to be turned here.'));
    return section;
  }
  const renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true, preserveDrawingBuffer: true});
  renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
  renderer.autoClear = false;
  const lead = withData[0].view;
  const camera = new THREE.PerspectiveCamera(35, 1, 0.01, 1000);
  camera.up.fromArray(lead.cameras[0], 6);
  const orbit = new THREE.OrbitControls(camera, canvas);
  orbit.enableKeys = false;  // they move the target, which nobody expects
  orbit.enableZoom = false;  // the wheel scrolls the page until the view has been touched
  canvas.addEventListener('pointerdown', () => canvas.focus({preventScroll: true}));
  canvas.addEventListener('focus', () => { orbit.enableZoom = true; });
  canvas.addEventListener('blur', () => { orbit.enableZoom = false; });
  let panes = [], following = true, stacked = false;

  const draw = () => {
    const width = stage.clientWidth, height = stage.clientHeight, n = panes.length;
    renderer.setScissorTest(true);
    panes.forEach((pane, i) => {
      const [x, y, w, h] = stacked ? [0, height - (i + 1) * height / n, width, height / n] : [i * width / n, 0, width / n, height];
      renderer.setViewport(x, y, w, h);
      renderer.setScissor(x, y, w, h);
      renderer.clear();
      pane.shaded[1].position.copy(camera.position);
      pane.shaded[1].target.position.copy(orbit.target);
      renderer.render(pane.world, camera);
    });
  };
  /** The movie's field of view, widened where the view is narrower than it. */
  const frameField = (fov) => {
    const half = Math.tan(fov * Math.PI / 360);
    camera.fov = 360 / Math.PI * Math.atan(half * Math.max(1, lead.aspect / camera.aspect));
    camera.updateProjectionMatrix();
  };
  const asMovie = (frame) => {
    const c = entryOf(lead.cameras, panes[0].at(frame));
    camera.position.fromArray(c, 0);
    orbit.target.fromArray(c, 3);
    const reach = camera.position.distanceTo(orbit.target) + Math.hypot(...lead.size);
    camera.near = reach / 2000;
    camera.far = reach * 100;
    frameField(c[9]);
    orbit.update();
  };
  const fit = () => {
    if (!panes.length) return;
    const n = panes.length, width = stage.clientWidth, height = Math.max(1, stage.clientHeight);
    stacked = n > 1 && width < 1.2 * height;
    stage.classList.toggle('stacked', stacked);
    renderer.setSize(width, height, false);
    camera.aspect = stacked ? width / (height / n) : width / n / height;
    frameField(entryOf(lead.cameras, panes[0].at(cursor.frame))[9]);
    draw();
  };
  const show = (frame) => {
    if (!panes.length) return;
    for (const pane of panes) pane.show(frame);
    if (following) asMovie(frame);
    draw();
  };
  const color = () => {
    const same = withData.map((run) => run.view.fields.find((field) => field.name === choice.value)).filter((field) => field);
    const range = same.length ? {low: Math.min(...same.map((field) => field.low)), high: Math.max(...same.map((field) => field.high))} : null;
    for (const pane of panes) pane.color(choice.value, range);
    scale.hidden = !range;
    if (range) {
      const beyond = (end) => same.some((field) => field[end]);
      low.textContent = (beyond('below') ? '≤ ' : '') + shown(range.low, same[0].unit);
      high.textContent = (beyond('above') ? '≥ ' : '') + shown(range.high, same[0].unit) + (same[0].log ? ', logarithmic' : '');
    }
    show(cursor.frame);
  };
  /** Turns the eye about the target [radian], or comes nearer. */
  const turn = (around, above, nearer = 1) => {
    following = false;
    const upright = new THREE.Quaternion().setFromUnitVectors(camera.up.clone().normalize(), new THREE.Vector3(0, 1, 0));
    const arm = camera.position.clone().sub(orbit.target).applyQuaternion(upright);
    const place = new THREE.Spherical().setFromVector3(arm);
    place.theta += around;
    place.phi = Math.min(Math.PI - 0.01, Math.max(0.01, place.phi + above));
    place.radius *= nearer;
    camera.position.setFromSpherical(place).applyQuaternion(upright.inverse()).add(orbit.target);
    orbit.update();
    draw();
  };
  canvas.addEventListener('keydown', (event) => {
    const turns = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1], '+': [0, 0, 0.9], '-': [0, 0, 1 / 0.9]};
    if (!turns[event.key]) return;
    event.preventDefault();
    turn(...turns[event.key]);
  });
  orbit.addEventListener('start', () => { following = false; });
  orbit.addEventListener('change', draw);
  new ResizeObserver(fit).observe(stage);
  back.addEventListener('click', () => { following = true; show(cursor.frame); });
  choice.addEventListener('change', color);
  edges.addEventListener('change', () => { for (const pane of panes) pane.edges.visible = edges.checked; draw(); });
  cursor.follow({show});

  const load = async () => {
    const scenes = await Promise.all(withData.map((run) => unpackView(run.view)));
    panes = scenes.map((scene, i) => new Pane(withData[i], scene));
    const strips = strip.getContext('2d'), image = strips.createImageData(255, 1);
    for (let i = 0; i < 255; ++i) image.data.set([...scenes[0].colors.slice(3 * i, 3 * i + 3), 255], 4 * i);
    strips.putImageData(image, 0, 0);
    choice.replaceChildren(make('option', {value: ''}, 'own colours'), ...lead.fields.map((field) => make('option', {value: field.name}, field.label)));
    choice.value = lead.fields.some((field) => field.name === lead.shade) ? lead.shade : '';
    fit();
    color();
    canvas.dataset.ready = 'yes';
  };
  load().catch((error) => stage.append(make('p', {}, 'The frames cannot be unpacked here: ' + error.message)));
  return section;
}
