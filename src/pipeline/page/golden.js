// Goldens: title, text, command, states, rows [{frame, good, state_good, picture_good, distance, psnr, over_2, over_32, reasons [text], gain,
//   before: the golden picture, after: drawn now from the golden state, difference,
//   moved: drawn from the state of now, moved_difference}], pictures as addresses.
'use strict';

/** Two pictures under one edge that can be drawn, and their difference. */
function beforeAfter(frame, before, after, about) {
  const picture = (source, alt) => make('img', {src: source, alt});
  const now = picture(after, 'now');
  now.className = 'after';
  const edge = make('div', {class: 'edge'});
  const input = make('input', {type: 'range', min: 0, max: 1000, value: 500, 'aria-label': `Frame ${frame}: before and after`});
  const place = () => {
    const share = input.value / 10;
    now.style.clipPath = `inset(0 0 0 ${share}%)`;
    edge.style.left = share + '%';
  };
  input.addEventListener('input', place);
  place();
  return make('figure', {}, make('div', {class: 'slider'}, picture(before, 'golden'), now, input, edge,
    make('span', {class: 'side'}, 'before'), make('span', {class: 'side right'}, 'after')), make('figcaption', {}, about));
}

function pictureOf(source, about) {
  return make('figure', {}, make('div', {class: 'slider'}, make('img', {src: source, alt: about})), make('figcaption', {}, about));
}

function goldenRow(row) {
  const pictures = [];
  const pair = (after, difference, about) => {
    pictures.push(beforeAfter(row.frame, row.before, after, about));
    if (difference) pictures.push(pictureOf(difference, `difference, times ${row.gain}`));
  };
  if (row.before && row.moved) pair(row.moved, row.moved_difference, 'The state: golden before the edge, of now after it. Draw the edge.');
  if (row.before && row.after) pair(row.after, row.difference, 'The drawing of the golden state: as it was before the edge, as it is now after it. Draw the edge.');
  if (!pictures.length && (row.before || row.after)) pictures.push(pictureOf(row.before || row.after, row.good ? 'golden, and now' : row.before ? 'golden; nothing could be drawn to compare' : 'now; there is no golden'));
  return make('section', {class: 'golden', id: 'golden-' + row.frame},
    make('h3', {}, `Frame ${row.frame} `, make('span', {class: row.good ? 'good' : 'bad'}, row.good ? 'agrees' : 'differs')),
    ...row.reasons.map((reason) => make('p', {}, reason)), make('div', {class: 'pair'}, ...pictures));
}

function goldens(golden) {
  const word = (good) => [good ? 'same' : 'differs', good ? 'good' : 'bad'];
  const parts = [];
  if (runs.length) parts.push(make('h2', {id: 'goldens'}, 'Golden frames'));
  if (golden.text) parts.push(make('p', {class: 'faint'}, golden.text));
  if (!golden.rows.length) return [make('p', {}, 'There were no goldens to compare with.')];
  parts.push(table(['frame', 'state', ['distance [m]', 'number'], 'picture', ['PSNR [dB]', 'number'], ['over 2', 'number'], ['over 32', 'number']],
    golden.rows.map((row) => [make('a', {href: '#golden-' + row.frame, onclick: () => { agreeing.open = agreeing.open || row.good; }}, String(row.frame)),
      word(row.state_good), [row.distance, 'number'], word(row.picture_good), [row.psnr, 'number'], [row.over_2, 'number'], [row.over_32, 'number']])));
  parts.push(make('p', {class: 'faint'}, `States must agree in ${golden.states}; pictures are compared as they are drawn from the golden states, so that a change of the simulation and one of the drawing are told apart.`));
  const bad = golden.rows.filter((row) => !row.good), good = golden.rows.filter((row) => row.good);
  if (bad.length) parts.push(make('p', {}, 'If the change is wanted: ', make('code', {}, golden.command)));
  parts.push(...bad.map(goldenRow));
  const agreeing = make('details', {}, make('summary', {}, good.length === 1 ? '1 frame agrees' : `${good.length} frames agree`), ...good.map(goldenRow));
  if (good.length) parts.push(agreeing);
  return parts;
}

/** At the head of a run's page: what became of its goldens. */
function goldenNote(golden) {
  const bad = golden.rows.some((row) => !row.good);
  return make('p', {class: bad ? 'note bad' : 'note'}, make('a', {href: '#goldens'}, golden.title));
}
