// Curves over the frames, and the frames that stand out in them.
'use strict';

function inkOf(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Powers of ten between two numbers, four at most; 1, 2 and 5 times them where there are few. */
function logTicks(low, high) {
  const first = Math.floor(Math.log10(low)), last = Math.ceil(Math.log10(high));
  const parts = last - first <= 2 ? [1, 2, 5] : [1];
  const step = Math.max(1, Math.ceil((last - first) / 4));
  const ticks = [];
  for (let e = first; e <= last; e += step)
    for (const part of parts) if (part * 10 ** e >= low * 0.999 && part * 10 ** e <= high * 1.001) ticks.push([part, e]);
  const superscript = (e) => String(e).replace(/./g, (c) => '⁰¹²³⁴⁵⁶⁷⁸⁹'[c] || '⁻');
  const every = Math.max(1, Math.ceil(ticks.length / 4));
  const some = ticks.filter((tick, i) => i % every === 0);
  const plain = some.every(([, e]) => e >= -2 && e <= 3);
  return some.map(([part, e]) => ({v: part * 10 ** e,
    label: plain ? String(Number((part * 10 ** e).toPrecision(2))) : (part > 1 ? part + '·' : '') + '10' + superscript(e)}));
}

/** One measure over the frames, of every run, with the cursor that can be dragged. Null: there is nothing to see. */
function chart(measure, player) {
  const frames = [...new Set(runs.flatMap((run) => run.frames.frame))].sort((a, b) => a - b);
  const columns = runs.map((run) => {
    const values = run.frames[measure.key] || [];
    return new Map(run.frames.frame.map((frame, i) => [frame, values[i] === undefined ? null : values[i]]));
  });
  const usable = (value) => value !== null && value !== undefined && (!measure.log || value > 0);
  const rows = frames.map((frame) => [frame, ...columns.map((column) => usable(column.get(frame)) ? column.get(frame) : null)]);
  const values = rows.flatMap((row) => row.slice(1)).filter((value) => value !== null);
  if (!values.some((value) => value !== 0)) return null;
  // A limit is drawn where it is not far beyond what is reached.
  let [least, most] = [Math.min(...values), Math.max(...values)];
  const span = measure.log ? Math.max(10, most / least) : most - least || Math.abs(most);
  const near = (limit) => measure.log ? limit > least / span && limit < most * span : limit > least - span && limit < most + span;
  const limits = [...new Set(runs.flatMap((run) => (run.expect || []).filter((p) => measure.expect && p.key === measure.expect).map((p) => p.limit)))].filter(near);
  [least, most] = [Math.min(least, ...limits), Math.max(most, ...limits)];
  const room = measure.log ? (most / least) ** 0.06 : 0.06 * (most - least || Math.abs(most) || 1);
  const range = measure.log ? [least / room, most * room] : [least >= 0 && least < 0.2 * most ? 0 : least - room, most + room];

  const line = make('div', {class: 'cursor'});
  const inner = make('div');
  const plot = make('div', {class: 'plot', role: 'img', 'aria-label': `${measure.label} over the frames, from ${shown(least, measure.unit)} to ${shown(most, measure.unit)}`}, inner, line);
  const outputs = runs.map(() => make('output'));
  const element = make('section', {class: 'chart', 'data-measure': measure.key},
    make('h3', {}, make('span', {}, measure.label + (measure.unit ? ` [${measure.unit}]` : '')),
      make('span', {class: 'now'}, ...outputs.flatMap((output, i) => several ? [columns[i].size && hasMeasure(i, measure) ? key(i) : '', output] : [output]))), plot);
  const look = () => ({colors: [inkOf('--one'), inkOf('--two')], axisLineColor: inkOf('--line'), gridLineColor: inkOf('--line')});
  const start = () => {
    const graph = new Dygraph(inner, rows, {
      labels: ['frame', ...runs.map((run, i) => run.label + ' '.repeat(i))], legend: 'never', interactionModel: {},
      highlightCircleSize: 0, strokeWidth: 1.6, logscale: measure.log, axisLabelFontSize: 11, connectSeparatedPoints: true,
      rightGap: 6, gridLineWidth: 0.5, valueRange: range, ...look(),
      underlayCallback: (ink, area, g) => {
        ink.strokeStyle = inkOf('--bad');
        ink.setLineDash([5, 4]);
        for (const limit of limits) {
          const y = Math.round(g.toDomYCoord(limit)) + 0.5;
          ink.beginPath();
          ink.moveTo(area.x, y);
          ink.lineTo(area.x + area.w, y);
          ink.stroke();
        }
        ink.setLineDash([]);
      },
      axes: {
        y: {axisLabelWidth: 44, drawGrid: true, pixelsPerLabel: 26, axisLabelFormatter: (v) => shown(v),
          ...(measure.log ? {ticker: (a, b) => logTicks(a, b)} : {})},
        x: {pixelsPerLabel: 60, drawGrid: false},
      },
    });
    const place = () => { line.style.left = graph.toDomXCoord(cursor.frame) + 'px'; };
    const show = (frame) => {
      place();
      columns.forEach((column, i) => { outputs[i].value = hasMeasure(i, measure) ? shown(column.get(frame)) : ''; });
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

function hasMeasure(i, measure) {
  return (runs[i].frames[measure.key] || []).length > 0;
}

/** The place of a run's worst value of a measure, or -1. */
function worstOf(run, measure) {
  const values = run.frames[measure.key] || [];
  let at = -1;
  values.forEach((value, i) => {
    if (value === null || run.frames.frame[i] === 0) return;
    if (at < 0 || (measure.worst === 'most' ? value > values[at] : value < values[at])) at = i;
  });
  return at >= 0 && values[at] !== 0 ? at : -1;
}

/** Links to the slowest and worst frames: a list for one run, a table for two. Null: there are none. */
function worstFrames() {
  const found = data.measures.filter((measure) => measure.worst)
    .map((measure) => [measure, runs.map((run) => worstOf(run, measure))]).filter(([, at]) => at.some((i) => i >= 0));
  const about = (run, measure, i) => `frame ${run.frames.frame[i]}, ${shown(run.frames[measure.key][i], measure.unit)}`;
  const own = (data.links || []).map((link) => [link.text, link.frame]);
  if (several) {
    const rows = found.map(([measure, at]) => [measure.worst_label,
      ...runs.map((run, r) => at[r] < 0 ? '' : frameLink(run.frames.frame[at[r]], about(run, measure, at[r])))]);
    for (const [text, frame] of own) rows.unshift([text, frameLink(frame, 'frame ' + frame), '']);
    return rows.length ? make('div', {class: 'frames'}, table(['', ...runs.map((run, i) => make('span', {}, key(i), run.label))], rows)) : null;
  }
  const links = found.map(([measure, at]) => frameLink(runs[0].frames.frame[at[0]], `${measure.worst_label}: ${about(runs[0], measure, at[0])}`));
  const broken = (runs[0].expect || []).filter((promise) => !promise.holds)
    .map((promise) => make('span', {class: 'bad'}, frameLink(promise.first_broken_frame, `${promise.key} is broken: frame ${promise.first_broken_frame}`)));
  const all = [...broken, ...links];
  return all.length ? make('div', {class: 'frames chips'}, ...all) : null;
}
