// The page of a run, of two runs, or of a comparison with goldens. What it shows is in the element "data":
//   title, verdict {text, good}, lines [text], notes [text], facts [[name, [text of each run]]],
//   measures [{key, label, unit, log, worst: "most" | "least" | ""}],
//   runs [{label, frames {frame [k], KEY [number of each]}, frame_rate, playback_rate,
//          movie {data | href, text}, view (view.js), scene (TOML), expect [...]}],
//   golden {rows [{frame, good, picture_good, state, picture, before, after, difference, moved}], command}
'use strict';

const data = JSON.parse(document.getElementById('data').textContent);

/** An element; texts among the children stay texts, whatever they hold. */
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (value !== null && value !== false) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

/** A number as tables show it. */
function shown(value, unit = '') {
  if (value === null || value === undefined) return '–';
  const size = Math.abs(value);
  const text = Number.isInteger(value) && size < 1e6 ? String(value)
    : size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(2) : String(Number(value.toPrecision(4)));
  return unit ? text + ' ' + unit : text;
}

const page = document.getElementById('page');
const runs = data.runs || [];
const lastFrame = Math.max(0, ...runs.map((run) => run.frames.frame[run.frames.frame.length - 1] || 0));

// ---------------------------------------------------------------- the one cursor

/** The frame that movies, curves and the view show. */
const cursor = {
  frame: 0,
  followers: [],
  /** `source`: who moved it, and is not told. */
  set(frame, source = null) {
    const next = Math.min(Math.max(Math.round(frame), 0), lastFrame);
    if (next === this.frame && source !== null) return;
    this.frame = next;
    for (const follower of this.followers) if (follower !== source) follower.show(next);
  },
  follow(follower) {
    this.followers.push(follower);
    return follower;
  },
};

// ---------------------------------------------------------------- movies

/** Plays the runs' movies together; without any, a clock. */
class Player {
  constructor() {
    this.rate = (runs[0] && runs[0].playback_rate) || 30;
    this.videos = [];
    this.playing = false;
    this.element = make('div', {class: 'movies'});
    for (const run of runs) {
      if (!run.movie) continue;
      if (run.movie.data || run.movie.href) {
        const source = run.movie.data
          ? URL.createObjectURL(new Blob([bytesOf(run.movie.data)], {type: 'video/mp4'})) : run.movie.href;
        const video = make('video', {src: source, preload: 'auto', playsinline: '', 'aria-label': 'Movie of ' + run.label});
        video.muted = true;
        this.videos.push(video);
        this.element.append(make('figure', {}, video,
          runs.length > 1 || run.movie.text ? make('figcaption', {}, [runs.length > 1 ? run.label : '', run.movie.text || '']
            .filter((text) => text).join(' · ')) : null));
      } else {
        this.element.append(make('p', {class: 'note'}, run.movie.text));
      }
    }
    for (const video of this.videos) video.addEventListener('ended', () => this.pause());
    this.watchFrames();
  }

  get leader() { return this.videos[0] || null; }

  /** Tells the cursor of each frame that the first movie shows. */
  watchFrames() {
    const video = this.leader;
    if (!video) return;
    const shownAt = (time) => {
      if (!this.playing) return;
      cursor.set(Math.floor(time * this.rate + 1e-3), this);
      for (const other of this.videos) if (Math.abs(other.currentTime - video.currentTime) > 0.1) other.currentTime = video.currentTime;
    };
    if (video.requestVideoFrameCallback) {
      const next = (now, meta) => { shownAt(meta.mediaTime); video.requestVideoFrameCallback(next); };
      video.requestVideoFrameCallback(next);
    } else {
      video.addEventListener('timeupdate', () => shownAt(video.currentTime));
    }
  }

  show(frame) {
    // In the middle of the frame: on its edge a player may show the one before.
    for (const video of this.videos) video.currentTime = (frame + 0.5) / this.rate;
    if (this.playing && !this.leader) this.restart();
  }

  toggle() { this.playing ? this.pause() : this.play(); }

  play() {
    if (cursor.frame >= lastFrame) cursor.set(0);
    this.playing = true;
    this.changed();
    if (this.leader) {
      for (const video of this.videos) video.play().catch(() => this.pause());
    } else {
      this.restart();
    }
  }

  restart() {
    const from = cursor.frame, begin = performance.now();
    const token = this.clock = {};
    const tick = (now) => {
      if (!this.playing || this.clock !== token) return;
      const frame = from + Math.floor((now - begin) / 1000 * this.rate);
      cursor.set(frame, this);
      if (frame >= lastFrame) return this.pause();
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  pause() {
    this.playing = false;
    for (const video of this.videos) video.pause();
    this.show(cursor.frame);
    this.changed();
  }

  changed() {}
}

function controls(player) {
  const time = runs[0].frame_rate || 60;
  const slider = make('input', {type: 'range', min: 0, max: lastFrame, value: 0, id: 'slider', 'aria-label': 'Frame',
    oninput: () => { player.pause(); cursor.set(Number(slider.value)); }});
  const text = make('output', {for: 'slider'});
  const button = make('button', {id: 'play', onclick: () => player.toggle()}, 'Play');
  player.changed = () => { button.textContent = player.playing ? 'Pause' : 'Play'; };
  const step = (by) => { player.pause(); cursor.set(cursor.frame + by); };
  const follower = cursor.follow({
    show(frame) {
      slider.value = frame;
      text.value = `frame ${frame} of ${lastFrame}, ${(frame / time).toFixed(3)} s`;
    },
  });
  follower.show(0);
  document.addEventListener('keydown', (event) => {
    if (event.target.closest('input, select, button, summary')) return;
    if (event.key === ' ') { event.preventDefault(); player.toggle(); }
    if (event.key === 'ArrowLeft') step(-1);
    if (event.key === 'ArrowRight') step(1);
  });
  return make('div', {class: 'controls'}, button,
    make('button', {'aria-label': 'One frame back', onclick: () => step(-1)}, '‹'),
    make('button', {'aria-label': 'One frame on', onclick: () => step(1)}, '›'), slider, text);
}

// ---------------------------------------------------------------- curves

function inkOf(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** One measure over the frames, of every run, with the cursor that can be dragged. */
function chart(measure, player) {
  const frames = [...new Set(runs.flatMap((run) => run.frames.frame))].sort((a, b) => a - b);
  const columns = runs.map((run) => {
    const values = run.frames[measure.key] || [];
    return new Map(run.frames.frame.map((frame, i) => [frame, values[i] === undefined ? null : values[i]]));
  });
  const usable = (value) => value !== null && value !== undefined && (!measure.log || value > 0);
  const rows = frames.map((frame) => [frame, ...columns.map((column) => usable(column.get(frame)) ? column.get(frame) : null)]);
  if (!rows.some((row) => row.slice(1).some((value) => value !== null && (value !== 0 || !measure.worst)))) return null;
  const line = make('div', {class: 'cursor'});
  const inner = make('div');
  const plot = make('div', {class: 'plot', role: 'img', 'aria-label': measure.label + ' over the frames'}, inner, line);
  const value = make('output');
  const element = make('section', {class: 'chart', 'data-measure': measure.key},
    make('h3', {}, measure.label + (measure.unit ? ` [${measure.unit}]` : ''), value), plot);
  const look = () => ({colors: [inkOf('--one'), inkOf('--two')], axisLineColor: inkOf('--line'), gridLineColor: inkOf('--line')});
  const start = () => {
    const graph = new Dygraph(inner, rows, {
      labels: ['frame', ...runs.map((run, i) => run.label + ' '.repeat(i))], legend: 'never', interactionModel: {},
      highlightCircleSize: 0, strokeWidth: 1.6, logscale: measure.log, axisLabelFontSize: 11, connectSeparatedPoints: true,
      rightGap: 6, gridLineWidth: 0.5, ...look(),
      axes: {y: {axisLabelWidth: 50, drawGrid: !measure.log, pixelsPerLabel: 26, axisLabelFormatter: (v) => shown(v)}, x: {pixelsPerLabel: 60, drawGrid: false}},
    });
    const place = () => { line.style.left = graph.toDomXCoord(cursor.frame) + 'px'; };
    const show = (frame) => {
      place();
      value.value = columns.map((column) => shown(column.get(frame))).join(' · ');
    };
    cursor.follow({show});
    show(cursor.frame);
    new ResizeObserver(() => { graph.resize(); place(); }).observe(plot);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => graph.updateOptions(look()));
    const seek = (event) => {
      player.pause();
      cursor.set(graph.toDataXCoord(event.clientX - inner.getBoundingClientRect().left));
    };
    plot.addEventListener('pointerdown', (event) => { plot.setPointerCapture(event.pointerId); seek(event); });
    plot.addEventListener('pointermove', (event) => { if (event.buttons & 1) seek(event); });
  };
  return {element, start};
}

// ---------------------------------------------------------------- frames worth a look

function worstFrames() {
  const list = [];
  runs.forEach((run, r) => {
    for (const measure of data.measures) {
      if (!measure.worst) continue;
      const values = run.frames[measure.key] || [];
      let at = -1;
      values.forEach((value, i) => {
        if (value === null || run.frames.frame[i] === 0) return;
        if (at < 0 || (measure.worst === 'most' ? value > values[at] : value < values[at])) at = i;
      });
      if (at < 0 || values[at] === 0) continue;
      list.push(make('button', {onclick: () => cursor.set(run.frames.frame[at])},
        `${measure.worst_label}${runs.length > 1 ? ' of ' + run.label : ''}: frame ${run.frames.frame[at]}, ${shown(values[at], measure.unit)}`));
    }
  });
  return list.length ? make('div', {class: 'frames'}, ...list) : null;
}

// ---------------------------------------------------------------- tables

function table(head, rows) {
  const cell = (tag, content) => {
    const [text, kind] = Array.isArray(content) ? content : [content, ''];
    return make(tag, {class: kind || null}, text);
  };
  return make('div', {class: 'scroll'}, make('table', {},
    head ? make('thead', {}, make('tr', {}, ...head.map((h) => cell('th', h)))) : null,
    make('tbody', {}, ...rows.map((row) => make('tr', {}, ...row.map((c) => cell('td', c)))))));
}

function certificate() {
  const rows = [];
  for (const run of runs) {
    for (const promise of run.expect || []) {
      rows.push([...(runs.length > 1 ? [run.label] : []), promise.key,
        promise.key === 'all_converged' ? 'true' : shown(promise.limit, promise.unit),
        promise.worst === undefined ? '–' : `${shown(promise.worst, promise.unit)} in frame ${promise.worst_frame}`,
        promise.holds ? ['holds', 'good'] : [`broken from frame ${promise.first_broken_frame}`, 'bad']]);
    }
  }
  return rows.length ? table([...(runs.length > 1 ? ['run'] : []), 'expected', 'limit', 'worst', ''], rows)
    : make('p', {class: 'faint'}, 'The scene expects nothing of itself: no [expect] table.');
}

// ---------------------------------------------------------------- goldens

function goldenRow(row) {
  const picture = (source, alt) => make('img', {src: source, alt});
  const parts = [make('h2', {}, `Frame ${row.frame} `, make('span', {class: row.good ? 'good' : 'bad'}, row.good ? 'agrees' : 'differs')),
    make('p', {}, 'State: ' + row.state), make('p', {}, 'Picture: ' + row.picture)];
  /** Two pictures under one edge that can be drawn. */
  const slider = (before, after, about) => {
    const now = picture(after, 'now');
    now.className = 'after';
    const edge = make('div', {class: 'edge'});
    const input = make('input', {type: 'range', min: 0, max: 1000, value: 500, 'aria-label': `Frame ${row.frame}: ${about}`});
    const place = () => {
      const share = input.value / 10;
      now.style.clipPath = `inset(0 0 0 ${share}%)`;
      edge.style.left = share + '%';
    };
    input.addEventListener('input', place);
    place();
    return make('figure', {}, make('div', {class: 'slider'}, picture(before, 'golden'), now, input, edge),
      make('figcaption', {}, about));
  };
  const alone = (source, about) => make('figure', {}, make('div', {class: 'slider'}, picture(source, about)), make('figcaption', {}, about));
  const pictures = [];
  if (row.before && row.moved) pictures.push(slider(row.before, row.moved, 'the golden state on the left, the state of now on the right of the edge, which can be drawn'));
  if (row.before && row.after && !(row.moved && row.picture_good)) {
    pictures.push(slider(row.before, row.after, 'the golden state: as it was drawn on the left, as it is drawn now on the right of the edge'));
    if (row.difference && !row.picture_good) pictures.push(alone(row.difference, 'difference, times 16'));
  } else if (!row.moved && (row.before || row.after)) {
    pictures.push(alone(row.before || row.after, row.before ? 'golden; nothing was drawn to compare' : 'now; there is no golden'));
  }
  parts.push(make('div', {class: 'pair'}, ...pictures));
  return make('section', {class: 'golden'}, ...parts);
}

// ---------------------------------------------------------------- the page

function build() {
  page.append(make('header', {}, make('h1', {}, data.title),
    data.verdict ? make('span', {class: 'badge ' + data.verdict.tone, id: 'verdict'}, data.verdict.text) : null));
  for (const line of data.lines || []) page.append(make('p', {class: 'faint'}, line));
  for (const fault of data.faults || []) page.append(make('p', {class: 'note bad'}, fault));
  const started = [];
  if (runs.length) {
    const player = cursor.follow(new Player());
    const charts = data.measures.map((measure) => chart(measure, player)).filter((c) => c);
    const worst = worstFrames();
    const left = make('div', {class: 'movie'}, player.element, controls(player),
      ...(worst ? [make('h2', {}, 'Frames worth a look'), worst] : []), make('h2', {}, 'Certificate'), certificate());
    page.append(make('div', {class: 'watch' + (runs.length > 1 ? ' wide' : '')}, left,
      make('div', {class: 'charts'}, ...charts.map((c) => c.element))));
    const seen = runs.filter((run) => run.view);
    if (seen.length) page.append(make('h2', {}, 'The cloth, to be turned'), viewOf(seen, cursor));
    started.push(...charts.map((c) => c.start));
  }
  if (data.golden) {
    page.append(make('p', {}, 'Pictures are drawn from the golden states. If the change is wanted: ', make('code', {}, data.golden.command)));
    for (const row of data.golden.rows) page.append(goldenRow(row));
  }
  if ((data.facts || []).length)
    page.append(make('h2', {}, 'Made from'), table(data.facts_head || null, data.facts.map(([name, texts]) => [name, ...texts])));
  if ((data.notes || []).length) page.append(make('h2', {}, 'Notes'), ...data.notes.map((note) => make('p', {class: 'note'}, note)));
  for (const run of runs) {
    if (run.scene) page.append(make('details', {}, make('summary', {}, 'The scene' + (runs.length > 1 ? ' of ' + run.label : '') + ', every default written out'), make('pre', {}, run.scene)));
  }
  if (data.text) page.append(make('details', {}, make('summary', {}, 'As text'), make('pre', {}, data.text)));
  for (const start of started) start();
  window.clothPage = {cursor, data};
}

build();
