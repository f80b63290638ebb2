// The page of a run, of two runs, or of a comparison with goldens. What it shows is in the element "data":
//   title, verdict {text, tone}, lines [text], faults [text], notes [text], picture {url, text},
//   facts [[name, [text of each run]]], facts_head [text], links [{text, frame}],
//   measures [{key, label, unit, log, worst: "most" | "least" | "", worst_label, expect, aside}],
//   runs [{label, frames {frame [k], KEY [number of each]}, frame_rate, playback_rate,
//          movie {data | href, text}, view (view.js), scene (TOML), expect [{key, unit, limit, …}]}],
//   golden {rows [{frame, good, …}], command, states} (golden.js)
'use strict';

const data = JSON.parse(document.getElementById('data').textContent);
const page = document.getElementById('page');
const runs = data.runs || [];
const several = runs.length > 1;

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

/** A link to a frame, which the page's address can hold too. */
function frameLink(frame, ...children) {
  return make('a', {href: '#frame=' + frame, onclick: () => cursor.set(frame)}, ...children);
}

function table(head, rows) {
  const cell = (tag, content) => {
    const [inner, kind] = Array.isArray(content) ? content : [content, ''];
    return make(tag, {class: kind || null}, inner);
  };
  return make('div', {class: 'scroll'}, make('table', {},
    head ? make('thead', {}, make('tr', {}, ...head.map((h) => cell('th', h)))) : null,
    make('tbody', {}, ...rows.map((row) => make('tr', {}, ...row.map((c) => cell('td', c)))))));
}

/** Which of two runs a colour stands for. */
function key(i) {
  return make('span', {class: 'key key' + i, 'aria-hidden': 'true'});
}

// ---------------------------------------------------------------- the one cursor

const lastOf = (run) => run.frames.frame[run.frames.frame.length - 1] || 0;

/** The frame that movies, curves and the view show. */
const cursor = {
  frame: 0,
  last: Math.max(0, ...runs.map(lastOf)),
  followers: [],
  /** `source`: who moved it, and is not told. */
  set(frame, source = null) {
    const next = Math.min(Math.max(Math.round(frame), 0), this.last);
    if (next === this.frame && source !== null) return;
    this.frame = next;
    for (const follower of this.followers) if (follower !== source) follower.show(next);
  },
  follow(follower) {
    this.followers.push(follower);
    return follower;
  },
  /** Goes where the page's address says. */
  fromAddress() {
    const found = /^#frame=(\d+)$/.exec(location.hash);
    if (found) this.set(Number(found[1]));
  },
};
